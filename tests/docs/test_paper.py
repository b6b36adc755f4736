"""Each part of the paper's system has code and a page, and both exist."""

import re

import pytest

from docs.site.reference.markdown import slug
from tests.support.documents import table, text_of
from tests.support.sources import PACKAGES, ROOT

PAPER = "docs/reference/paper.md"
HEADER = ("part of the paper", "code", "page")
SECTIONS = re.findall(r"^## (.*)$", text_of(PAPER), re.MULTILINE)
ROW = re.compile(r"^\| (?!part|-)(.+?) \| (.+?) \| (.+?) \|$", re.MULTILINE)
ROWS = ROW.findall(text_of(PAPER))


def test_the_abstract_the_layers_and_the_case_study_have_a_table_each() -> None:
    assert [re.split("[:,]", section)[0] for section in SECTIONS] == [
        "The abstract", "Server layer", "Engine layer", "Client layer", "Case study",
    ]  # fmt: skip
    assert text_of(PAPER).count("| part of the paper | code | page |") == len(SECTIONS)
    assert len(table(PAPER, *HEADER)) > 3


@pytest.mark.parametrize(("part", "code", "pages"), ROWS, ids=[row[0] for row in ROWS])
def test_a_part_of_the_paper_lives_in_code_with_a_page(part: str, code: str, pages: str) -> None:
    named = re.findall(r"`([\w/.]+)`", code)
    assert named
    assert [name for name in named if name.partition("/")[0] not in PACKAGES or not holds_code(name)] == []
    links = re.findall(r"\]\(\.\./([\w-]+\.md)(?:#([\w-]+))?\)", pages)
    assert links and len(links) == pages.count("](")
    for page, anchor in links:
        headings = re.findall(r"^#+ (.*)$", text_of(f"docs/{page}"), re.MULTILINE)
        assert not anchor or anchor in map(slug, headings), f"{page}#{anchor}"


def holds_code(name: str) -> bool:
    """Return whether a file or a folder of a package holds code."""
    path = ROOT / name
    return any(file.stat().st_size for file in path.glob("**/*.py")) if path.is_dir() else path.is_file()
