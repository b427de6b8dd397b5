"""Links of README and documentation: each leads to a file, and to a heading in it."""

from pathlib import Path

import pytest

from tests.docs.pages import PAGES, PROJECT, anchors, links, page_name


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_links_lead_somewhere(page: Path) -> None:
    """Files exist, and headings in them; links to the web are not followed."""
    for path, anchor in links(page):
        target = (page.parent / path).resolve() if path else page
        assert target.exists(), f"{page_name(page)}: {path}"
        assert not anchor or anchor in anchors(target), f"{page_name(page)}: {path}#{anchor}"


def test_every_page_is_in_a_list_of_pages() -> None:
    """Readers of the README reach every page of how-to guides, by it or by a page that it links to."""
    reached, waiting = set(), [PROJECT / "README.md"]
    while waiting:
        page = waiting.pop()
        if page in reached or page.suffix != ".md":
            continue
        reached.add(page)
        waiting += [target for path, _ in links(page) if (target := (page.parent / path).resolve()).is_file()]
    assert {page_name(page) for page in (PROJECT / "docs" / "how-to").glob("*.md") if page not in reached} <= {
        "docs/how-to/compare.md"
    }
