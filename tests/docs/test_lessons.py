"""The lessons run and assert what they say; exercises have solutions, pages a place on the site."""

import importlib.util
import json
import re

import pytest

from tests.docs.pages import ROOT, blocks

FOLDER = ROOT / "docs" / "learn"
LESSONS = sorted(path for path in FOLDER.glob("*.md") if path.name != "index.md")

_spec = importlib.util.spec_from_file_location("lessons", ROOT / "docs" / "site" / "lessons.py")
lessons = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(lessons)


def _text(path):
    return path.read_text(encoding="utf-8")


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_lesson_runs_and_draws(path):
    outputs = lessons.run(_text(path), path.stem)
    titles = [title for output in outputs for title, _ in output.figures]
    # The titles are what a reader without the picture gets.
    assert titles
    assert "figure" not in titles
    assert sum("\nassert " in block for block in blocks(path, "python")) >= 4


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_every_exercise_has_a_solution(path):
    _, exercises = _text(path).split("\n## Exercises\n")
    exercises, solutions = exercises.split("\n## Solutions\n")
    asked = re.findall(r"^(\d)\. ", exercises, re.MULTILINE)
    assert asked == ["1", "2", "3"]
    assert re.findall(r"^### (\d)\. ", solutions, re.MULTILINE) == asked


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_a_notebook_holds_the_whole_page(path):
    text = _text(path)
    notebook = json.loads(lessons.notebook_of(text))
    cells = [(cell["cell_type"], "".join(cell["source"])) for cell in notebook["cells"]]
    assert [source for kind, source in cells if kind == "code"] == [
        block.strip("\n") for block in blocks(path, "python")
    ]
    words = re.sub(r"^```(python)?$", "", text, flags=re.MULTILINE).split()
    assert " ".join(source for _, source in cells).split() == words
    identifiers = [cell["id"] for cell in notebook["cells"]]
    assert len(set(identifiers)) == len(identifiers)


def test_lessons_are_numbered_in_the_order_of_the_navigation_and_the_overview():
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    listed = re.findall(r"- learn/([\w-]+)\.md", navigation)
    assert listed[0] == "index"
    shown = re.findall(r"\| (\d+)\. \[(.+?)\]\(([\w-]+)\.md\)", _text(FOLDER / "index.md"))
    assert [name for _, _, name in shown] == listed[1:]
    assert set(listed[1:]) == {path.stem for path in LESSONS}
    for number, title, name in shown:
        assert _text(FOLDER / f"{name}.md").startswith(f"# {number}. {title}\n")


PAGE = """# Title

```python
x = 2
print("two")
x + 1
```

Text.

```python
x = 5
```

## Solutions

### 1. One

```python
x
```
"""


def test_cells_share_a_namespace_and_show_what_notebooks_show():
    texts = [output.text for output in lessons.run(PAGE, "page")]
    assert texts == ["two\n3", "", "5"]


def test_outputs_stand_below_their_cells_and_solutions_are_folded():
    class File:
        src_uri, content_string = "learn/page.md", PAGE

    class Page:
        file = File

    shown = lessons.on_page_markdown(PAGE, Page)
    assert shown.index("x + 1") < shown.index("two\n3") < shown.index("Text.")
    assert '??? success "1. One"\n\n    ```python\n    x\n    ```\n\n    ```text\n    5\n' in shown


def test_a_false_statement_stops_the_lesson():
    with pytest.raises(AssertionError):
        lessons.run("```python\nassert 1 + 1 == 3\n```\n", "wrong")
