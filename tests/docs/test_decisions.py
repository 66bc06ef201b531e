"""Decisions are short and dated, and name those that supersede them."""

import re

import pytest

from tests.docs.pages import ROOT

FOLDER = ROOT / "docs" / "decisions"
DECISIONS = sorted(FOLDER.glob("0*.md"))
LONGEST = 1000

STATUS = r"\*\*Status\.\*\* Accepted, (2\d{3}-[01]\d-[0-3]\d)\.(.*)\n"


@pytest.mark.parametrize("page", DECISIONS, ids=lambda page: page.stem)
def test_decision_is_short_and_dated(page):
    text = page.read_text(encoding="utf-8")
    assert len(text.split()) <= LONGEST
    assert re.match(rf"# {int(page.stem[:4])}\. .+\n\n{STATUS}\n## Context\n", text)


def test_supersession_is_said_on_both_pages():
    says, is_said = set(), set()
    for page in DECISIONS:
        number = page.stem[:4]
        [(_, status)] = re.findall(STATUS, page.read_text(encoding="utf-8"))
        for sentence in re.split(r"(?<=\.) ", status):
            for other in re.findall(r"\]\((\d{4})-", sentence):
                if "upersedes" in sentence:
                    says.add((number, other))
                elif "superseded by" in sentence:
                    is_said.add((other, number))
    assert says == is_said


def test_the_list_of_decisions_is_complete():
    listed = re.findall(
        r"^\| \[(\d+)\]\((\S+?)\) \| (.+?) \| (\S+) \|",
        (FOLDER / "README.md").read_text(encoding="utf-8"),
        re.MULTILINE,
    )
    expected = []
    for page in DECISIONS:
        text = page.read_text(encoding="utf-8")
        title, date = re.search(r"# \d+\. (.+)\n", text)[1], re.search(STATUS, text)[1]
        expected.append((str(int(page.stem[:4])), page.name, title, date))
    assert listed == expected
