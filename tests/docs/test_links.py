"""Links lead somewhere: to a file of the tree, and to a heading in it. Needs no Sphinx."""

import re
import urllib.parse
from functools import cache

import pytest

from tests.docs.pages import DOCS, ROOT, Page, pages

LINK = re.compile(r"!?\[(?:[^\[\]]|\[[^\]]*\])*\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ (.+?)\s*#*$", re.M)
PAGES = pages()


def slug(heading):
    """The anchor that forges and the site give to a heading."""
    plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "")
    return re.sub(r"[^\w\- ]", "", plain.lower()).replace(" ", "-")


@cache
def anchors(path):
    return frozenset(map(slug, HEADING.findall(Page(path).prose)))


def broken(page):
    found = []
    for target in LINK.findall(re.sub(r"`[^`\n]*`", "", page.prose)):
        if re.match(r"\w+:", target):
            continue
        file, _, anchor = urllib.parse.unquote(target).partition("#")
        path = (page.path.parent / file).resolve() if file else page.path
        inside = path.exists() and path.is_relative_to(ROOT)
        if not inside or (anchor and path.suffix == ".md" and anchor not in anchors(path)):
            found.append(target)
    return found


@pytest.mark.parametrize("page", PAGES, ids=[page.name for page in PAGES])
def test_internal_links_lead_to_files_and_headings(page):
    assert broken(page) == []


def test_every_page_of_the_site_is_in_its_contents():
    listed = {DOCS / "index.md"}
    for index in (DOCS / "index.md", DOCS / "notebooks" / "index.md"):
        links = re.findall(r"^- \[.+?\]\(([^)#:]+\.md)\)", index.read_text("utf-8"), re.M)
        listed |= {(index.parent / link).resolve() for link in links}

    assert set(DOCS.rglob("*.md")) - listed == set()
