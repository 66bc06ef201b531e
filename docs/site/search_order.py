"""Hook of mkdocs: who searches a word finds how to use a thing before why it is so.

Decisions name every subject of the project, mostly in their titles, and stood before its pages.
"""

from __future__ import annotations

from typing import Any

#: Folders whose pages come after others that match as well.
AFTER = ("decisions/", "laboratory/earlier-intervals", "laboratory/mutation-testing")
BOOST = 0.1


def on_page_markdown(markdown: str, *, page: Any, **_: Any) -> None:
    """Weigh the page by its folder; the text stays."""
    if page.file.src_uri.startswith(AFTER):
        page.meta.setdefault("search", {})["boost"] = BOOST
