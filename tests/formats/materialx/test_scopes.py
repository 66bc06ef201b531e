"""What is said of a file, a graph, a node or an input holds within; the inner one counts.

Source: MaterialX specification, "Standard Filename Prefix" and "Color Spaces".
"""

import itertools

import pytest

from alight.formats.materialx.document import Document
from alight.formats.reading.reach import Reach
from alight.formats.reading.report import Report

LEVELS = ("file", "graph", "node", "input")

TEXT = """<?xml version="1.0"?>
<materialx version="1.38"{file}>
  <nodegraph name="g"{graph}>
    <image name="i" type="color3"{node}>
      <input name="file" type="filename" value="p.png"{input}/>
    </image>
    <output name="out" type="color3" nodename="i"/>
  </nodegraph>
  <standard_surface name="s" type="surfaceshader">
    <input name="base_color" type="color3" nodegraph="g" output="out"/>
  </standard_surface>
</materialx>
"""


def picture_of(document):
    """The input of the only picture of a document's only shader."""
    [material] = document.materials()
    source = material.shader.inputs["base_color"].source
    return source.inputs["file"]


@pytest.mark.parametrize("attribute", ["colorspace", "fileprefix"])
@pytest.mark.parametrize("said", list(itertools.product([False, True], repeat=4)), ids=str)
def test_the_inner_one_counts(attribute, said, tmp_path):
    given = dict(zip(LEVELS, said, strict=True))
    words = {level: f' {attribute}="{level}/"' if given[level] else "" for level in LEVELS}
    text = TEXT.format(**words)
    found = picture_of(Document(text, "a.mtlx", tmp_path, Reach(tmp_path), Report()))
    wanted = next((f"{level}/" for level in reversed(LEVELS) if given[level]), "")
    if attribute == "colorspace":
        assert (found.value, found.space) == ("p.png", wanted)
    else:
        assert (found.value, found.space) == (f"{wanted}p.png", "")


def test_files_that_are_included_look_beside_themselves(tmp_path):
    """For what they include in turn, and for their pictures; each has a colour space of its own."""
    deep = tmp_path / "one" / "two"
    deep.mkdir(parents=True)
    include = '<?xml version="1.0"?><materialx version="1.38"{}><xi:include href="{}"/></materialx>'
    (tmp_path / "one" / "b.mtlx").write_text(include.format(' colorspace="b/"', "two/c.mtlx"))
    words = dict.fromkeys(LEVELS, "")
    (deep / "c.mtlx").write_text(TEXT.format(**words | {"file": ' colorspace="c/"'}))
    text = include.format(' colorspace="a/"', "one/b.mtlx")
    report = Report()
    document = Document(text, "a.mtlx", tmp_path, Reach(tmp_path), report)
    assert not report.issues
    found = picture_of(document)
    assert (found.asset, found.space) == (deep, "c/")
