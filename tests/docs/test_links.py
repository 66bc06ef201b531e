"""Links, pictures and names of files in the pages lead somewhere."""

import re

import pytest

from tests.docs.pages import PAGES, ROOT, anchors, links, name_of, prose

# Pages say "the file X" of files that a reader of extending.md writes.
TO_BE_WRITTEN = (
    "minnaert.py",
    "downlight.py",
    "kronecker.py",
    "headlight.py",
    "exponential.py",
    "log_error.py",
)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_resolve(page):
    broken = []
    for link in links(page):
        if re.match(r"[a-z]+:", link):
            continue
        target, _, anchor = link.partition("#")
        path = (page.parent / target).resolve() if target else page
        if not path.exists() or (anchor and anchor not in anchors(path)):
            broken.append(link)
    assert not broken


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_named_files_exist(page):
    named = re.findall(r"`((?:alight|tests|docs|requirements)/[\w/.-]*)`", prose(page))
    missing = [
        name for name in named if not name.endswith(TO_BE_WRITTEN) and not (ROOT / name).exists()
    ]
    assert not missing


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_named_modules_of_the_package_exist(page):
    """Names such as `scene/manager.py` and `films/` in pages are relative to the package."""
    named = re.findall(r"`((?:[a-z_]+/)+(?:[a-z_0-9]+\.py)?)`", prose(page))
    missing = [
        name
        for name in named
        if not name.endswith(TO_BE_WRITTEN)
        and not any((ROOT / base / name).exists() for base in ("", "alight", "lanewise", "tests"))
    ]
    assert not missing
