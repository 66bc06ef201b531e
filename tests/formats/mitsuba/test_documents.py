"""Files: both spellings, parameters, includes, references, and what a file may reach."""

import re

import pytest

from alight.core.errors import SceneError
from alight.formats import load, loads
from alight.shapes.disk import Disk
from tests.formats.mitsuba.reading import FILES, PICTURE, issues, messages, native, node, read

LAMP = '<emitter type="point"><rgb name="intensity" value="$power"/></emitter>'

OLD = """
<sensor type="thinlens">
    <float name="fov" value="30"/> <string name="fovAxis" value="smaller"/>
    <float name="apertureRadius" value="0.1"/> <float name="focusDistance" value="3"/>
    <transform name="toWorld"><lookAt origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>
    <sampler type="ldsampler"><integer name="sampleCount" value="32"/></sampler>
    <film type="hdrfilm">
        <integer name="width" value="40"/> <integer name="height" value="30"/>
        <integer name="cropOffsetX" value="4"/> <integer name="cropOffsetY" value="2"/>
        <integer name="cropWidth" value="8"/> <integer name="cropHeight" value="6"/>
        <rfilter type="mitchell">
            <float name="b" value="0.5"/><float name="c" value="0.25"/>
        </rfilter>
    </film>
</sensor>
<integrator type="path">
    <integer name="maxDepth" value="7"/> <integer name="rrDepth" value="4"/>
</integrator>
<shape type="sphere">
    <boolean name="flipNormals" value="true"/>
    <bsdf type="dielectric">
        <float name="intIOR" value="1.4"/><float name="extIOR" value="1.1"/>
    </bsdf>
</shape>
"""


def in_new_spelling(text):
    """The same file as Mitsuba 3 spells it."""
    for old, new in {
        "intIOR": "int_ior", "extIOR": "ext_ior", "fovAxis": "fov_axis", "toWorld": "to_world",
        "apertureRadius": "aperture_radius", "focusDistance": "focus_distance",
        "sampleCount": "sample_count", "cropOffsetX": "crop_offset_x", "lookAt": "lookat",
        "cropOffsetY": "crop_offset_y", "cropWidth": "crop_width", "cropHeight": "crop_height",
        "maxDepth": "max_depth", "rrDepth": "rr_depth", "flipNormals": "flip_normals",
        'name="b"': 'name="B"', 'name="c"': 'name="C"',
    }.items():  # fmt: skip
        assert old in text
        text = text.replace(old, new)
    return text


def test_both_spellings_say_the_same():
    old, new = read(OLD, "0.6.0"), read(in_new_spelling(OLD))
    assert old == new
    assert old.camera.camera.aperture_radius == 0.1
    assert old.film.crop == (4, 2, 8, 6)
    assert old.source.remarks.spp == 32
    assert node(old).bsdf.ext_ior == 1.1


def test_old_names_in_a_new_file_are_refused_with_the_right_ones():
    found = "\n".join(f"{issue.path} {issue.message}" for issue in issues(OLD))
    for old, new in (("maxDepth", "max_depth"), ("intIOR", "int_ior"), ("fovAxis", "fov_axis")):
        assert f'"{old}"' in found
        assert f'"{new}"' in found


@pytest.mark.parametrize("version", ["", "three", "3.x", "1" * 9])
def test_a_file_without_a_sensible_version_is_refused(version):
    assert "version" in messages("", version)[0]


def test_defaults_and_definitions():
    body = f'<default name="power" value="2"/>{LAMP}'
    assert node(read(body)).light.intensity == (2.0, 2.0, 2.0)
    assert node(read(body, definitions={"power": "5"})).light.intensity == (5.0, 5.0, 5.0)
    # The first default counts, and defaults may be made of others.
    body = f'<default name="a" value="3"/><default name="power" value="$a"/>{LAMP}'
    assert node(read(body)).light.intensity == (3.0, 3.0, 3.0)


def test_unknown_parameters_are_refused_on_both_sides():
    [message] = messages(LAMP)
    assert "-D power=VALUE" in message
    [issue] = issues('<default name="spp" value="4"/>', definitions={"ssp": "5"})
    assert issue.path == "-D ssp"
    assert 'did you mean "spp"?' in issue.message


def test_includes_take_and_give_parameters(tmp_path):
    (tmp_path / "lamp.xml").write_text(f'<scene version="3.0.0">{LAMP}</scene>')
    body = '<default name="power" value="2"/><include filename="lamp.xml"/>'
    assert node(read(body, folder=tmp_path)).light.intensity == (2.0, 2.0, 2.0)
    # Places name the file that a value stands in.
    (tmp_path / "lamp.xml").write_text('<scene version="3.0.0">\n<emitter type="pont"/></scene>')
    [issue] = issues(body, folder=tmp_path)
    assert issue.place.endswith("lamp.xml:2:1")
    assert 'did you mean "point"?' in issue.message


def test_included_file_keeps_its_own_spelling():
    scene = load(PICTURE / "objects.xml")
    [disk] = [each for each in scene.nodes.values() if isinstance(each.shape, Disk)]
    # Only files of 0.6 have uscale and uoffset; the offset is scaled too.
    assert disk.bsdf.reflectance.to_uv.matrix[0] == pytest.approx([2.0, 0.0, 0.3])


def test_references_and_aliases():
    body = """<bsdf type="diffuse" id="a/b"><rgb name="reflectance" value="0.2"/></bsdf>
    <alias id="a/b" as="c"/>
    <shape type="sphere"><ref id="c"/></shape>
    <shape type="disk"><ref name="bsdf" id="a/b"/></shape>"""
    scene = read(body)
    names = {each.bsdf for each in scene.nodes.values()}
    assert len(names) == 1
    assert scene.bsdfs[names.pop()] == native("bsdfs", "{type: diffuse, reflectance: 0.2}")


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ('<shape type="sphere"><ref id="nothing"/></shape>', 'unknown id "nothing"'),
        ('<bsdf type="diffuse" id="a"/><bsdf type="diffuse" id="a"/>', "was given before"),
        ('<alias id="a" as="b"/>', 'unknown id "a"'),
        ('<bsdf type="twosided" id="a"><ref id="a"/></bsdf>', "contains itself"),
        ('<shape type="sphere" id="s"/><shape type="disk"><ref id="s"/></shape>', "refer to a"),
    ],
)
def test_wrong_references_are_refused(body, said):
    assert said in messages(body)[0]


# ---------------------------------------------------------------- hostile files


def refused(text, folder=FILES):
    """The message for a whole file."""
    with pytest.raises(SceneError) as caught:
        loads(text, "scene.xml", folder)
    return str(caught.value)


def test_entities_are_refused():
    bomb = '<!DOCTYPE s [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><scene version="3.0.0">&b;</scene>'
    assert "not allowed" in refused(bomb)
    outside = '<!DOCTYPE s [<!ENTITY a SYSTEM "file:///etc/passwd">]><scene version="3.0.0"/>'
    assert "not allowed" in refused(outside)
    assert "not XML" in refused('<scene version="3.0.0">&unknown;</scene>')


def test_parameters_that_grow_are_refused():
    steps = [f'<default name="a{i}" value="{f"$a{i - 1}" * 10}"/>' for i in range(1, 12)]
    body = '<default name="a0" value="aaaaaaaaaa"/>' + "".join(steps)
    assert "grow" in refused(f'<scene version="3.0.0">{body}</scene>')


def test_include_cycles_are_refused(tmp_path):
    text = '<scene version="3.0.0"><include filename="a.xml"/></scene>'
    (tmp_path / "a.xml").write_text(text)
    assert "nested deeper" in refused(text, tmp_path)


def test_fans_of_includes_are_refused(tmp_path):
    text = f'<scene version="3.0.0">{30 * """<include filename="%s"/>"""}</scene>'
    for i in range(6):
        (tmp_path / f"{i}.xml").write_text(text.replace("%s", f"{i + 1}.xml"))
    (tmp_path / "6.xml").write_text('<scene version="3.0.0"/>')
    assert "more than 64 includes" in refused(text.replace("%s", "0.xml"), tmp_path)


@pytest.mark.parametrize(
    "path", ["/etc/passwd", "../secret.ply", "a/../../secret.ply", "C:/secret.ply", "link.ply", ""]
)
def test_paths_out_of_reach_are_refused(path, tmp_path):
    inside = tmp_path / "scene"
    inside.mkdir()
    (tmp_path / "secret.ply").write_bytes((FILES / "tent.ply").read_bytes())
    (inside / "link.ply").symlink_to(tmp_path / "secret.ply")
    body = f'<shape type="ply"><string name="filename" value="{path}"/></shape>'
    [message] = messages(body, folder=inside)
    assert "folder of the scene" in message or "must be a path" in message
    for tag in (f'<include filename="{path}"/>', f'<path value="{path}"/>'):
        assert messages(tag, folder=inside)


def test_depth_and_size_are_limited():
    deep = "<bsdf type='twosided'>" * 40
    assert "nested deeper" in refused(f'<scene version="3.0.0">{deep}')
    chain = '<bsdf type="diffuse" id="b0"/>' + "".join(
        f'<bsdf type="mask" id="b{i}"><ref id="b{i - 1}"/></bsdf>' for i in range(1, 40)
    )
    assert "refers through more than" in refused(f'<scene version="3.0.0">{chain}</scene>')
    huge = "1e999999999"
    body = f'<shape type="sphere"><float name="radius" value="{huge}"/></shape>'
    assert "finite" in messages(body)[0]
    film = '<sensor type="perspective"><film type="hdrfilm"><integer name="width" value="{}"/>'
    film += "</film></sensor>"
    assert messages(film.format("999999999999"))
    assert messages(film.format("-1"))


def test_all_problems_are_told_at_once_with_their_lines():
    body = (
        '<bsdf type="irawan" id="a"/>\n<shape type="bspline"/>\n<emitter type="directionalarea"/>'
    )
    found = issues(body)
    assert [issue.place for issue in found] == [f"scene.xml:{line}:1" for line in (2, 3, 4)]
    assert all("is not covered" in issue.message for issue in found)


def test_lenient_replaces_and_lists_everything():
    body = """<bsdf type="irawan" id="a"/>
    <bsdf type="diffuse" id="b"><texture type="wood" name="reflectance"/></bsdf>
    <shape type="bspline"/><emitter type="directionalarea"/><sensor type="fisheye"/>
    <integrator type="vcm"/>
    <shape type="sphere"><ref id="a"/><float name="wobble" value="1"/>
        <medium type="homogeneous" name="interior"/><film type="hdrfilm"/></shape>"""
    scene = read(body, lenient=True)
    assert scene.bsdfs["a"] == scene.bsdfs["b"] == native("bsdfs", "{type: diffuse}")
    warned = "\n".join(scene.warnings)
    for word in (
        "irawan",
        "wood",
        "bspline",
        "directionalarea",
        "fisheye",
        "vcm",
        "wobble",
        "hdrfilm",
    ):
        assert word in warned
    # The same file is refused as a whole otherwise, each of them with its line.
    assert len(issues(body)) == 8


def test_integrators_of_other_programs_keep_their_depths():
    body = """<integrator type="guided_path"><integer name="maxDepth" value="3"/>
    <integer name="rrDepth" value="9"/><float name="sdTreeThreshold" value="4000"/>
    <integrator type="path"/></integrator>"""
    scene = read(body, "0.6.0", lenient=True)
    assert (scene.integrator.max_depth, scene.integrator.rr_depth) == (3, 9)
    [warning] = [line for line in scene.warnings if "guided_path" in line]
    assert "path is taken, with its max_depth and rr_depth" in warning
    [issue] = issues(body, "0.6.0")
    assert 'integrator "guided_path" is not covered' in issue.message


@pytest.mark.parametrize(
    ("depth", "kept"),
    [
        ('<integer name="max_depth" value="0"/>', None),
        ('<integer name="max_depth" value="4001"/>', None),
        ('<float name="max_depth" value="4"/>', 4),
        ('<string name="max_depth" value="many"/>', None),
        ('<integer name="max_depth" value="-1"/>', None),
        ('<boolean name="hide_emitters" value="perhaps"/>', None),
    ],
)
def test_depths_of_other_programs_never_stop_a_lenient_reader(depth, kept):
    scene = read(f'<integrator type="guided">{depth}</integrator>', lenient=True)
    assert scene.integrator.max_depth == kept
    is_odd = any(value in depth for value in ('"0"', "4001", "many"))
    assert is_odd == any("must be in [1, 4000]" in line for line in scene.warnings)


@pytest.mark.parametrize(
    "body",
    [
        '<integrator type="sppm"><integer name="photonCount" value="5"/></integrator>',
        '<shape type="sphere"><boolean name="hide" value="true"/></shape>',
        '<shape type="sphere"><bsdf type="diffuse"><float name="extEta" value="1"/></bsdf></shape>',
        '<integrator type="path"><string name="mode" value="fast"/></integrator>',
    ],
)
def test_parameters_of_other_programs_are_listed_and_left_out(body):
    scene = read(body, "0.6.0", lenient=True)
    remarks = "\n".join((*scene.warnings, *scene.source.remarks.notes))
    assert re.search("photon_?count|photonCount|hide|ext_?eta|extEta|mode", remarks)


def test_nothing_is_dropped_silently():
    body = '<shape type="sphere"><boolean name="optimize" value="true"/></shape>'
    assert "optimize" in messages(body)[0]
    body = '<shape type="sphere"><bsdf type="diffuse"><float name="eta" value="1"/></bsdf></shape>'
    assert "eta" in messages(body)[0]
    inner = '<boolean name="hide_emitters" value="true"/><integrator type="path"/>'
    assert "not covered" in messages(f'<integrator type="moment">{inner}</integrator>')[0]
    hidden = '<integrator type="path"><boolean name="hide_emitters" value="true"/></integrator>'
    assert read(hidden).integrator.hide_emitters
    # What counts is not said to be left out, by integrators that become others either.
    scene = read(hidden.replace("path", "bdpt"))
    assert scene.integrator.hide_emitters
    assert not scene.source.remarks.notes
    scene = read('<integrator type="moment"><integrator type="path"/></integrator>')
    assert "taken off" in scene.source.remarks.notes[0]
