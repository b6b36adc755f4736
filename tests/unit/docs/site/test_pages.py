"""Pages are laid out with links that hold in the site."""

from pathlib import Path

import pytest

from docs.site import pages
from docs.site.build import HERE
from docs.site.link_check import broken_links, inline_scripts, unreachable_pages
from docs.site.navigation import Section, read_navigation, sidebar
from docs.site.pages import GENERATED, HOME, project_pages
from ppaas.errors import InvalidInput


def test_links_lead_to_the_places_of_pages_files_and_folders(project: Path, tmp_path: Path) -> None:
    site = tmp_path / "site"
    pages.lay_out(site, [Section("Start", ("rest",))])
    home = (site / "index.md").read_text()
    assert "[rest](rest.md#r) ![seen](images/seen.png) [web](https://example.org)" in home
    assert home.endswith("rest\n```\n")
    assert (site / "rest.md").read_text() == (
        "# R\n[home](index.md)\n[why](adr/README.md) [one](files/robots/one.py) "
        "[all](reference/examples.md#docsexamplessmall)\n"
        "```text\n[kept](../nowhere.md)\n```\n[here](#r)\n"
    )
    assert (site / "adr" / "0001-one.md").read_text() == "---\norphan: true\n---\n\n# 0001: One\n[r](../rest.md)\n"
    assert (site / "files" / "robots" / "one.py").read_text() == "print()\n"
    assert (site / "files" / "docs" / "examples" / "small" / "a.json").exists()
    assert (site / "images" / "seen.png").exists()


@pytest.mark.parametrize("link", ["none.md", "../none.py", "images", "../../outside.md"])
def test_a_link_to_no_file_is_reported_with_its_page(project: Path, tmp_path: Path, link: str) -> None:
    (project / "docs" / "rest.md").write_text(f"# R\n[broken]({link})\n")
    with pytest.raises(InvalidInput, match=rf"(?s)name no file.*docs/rest.md: {link}"):
        pages.lay_out(tmp_path / "site", [])


SECTIONS = (
    "Start", "Robots", "Maps and planning", "Fleet", "Bring what you have", "Bridges", "Operate", "Reference",
    "Internals",
)  # fmt: skip


def test_sections_are_in_the_order_of_a_reader() -> None:
    assert tuple(section.title for section in read_navigation(HERE / "navigation.toml")) == SECTIONS


def test_each_page_is_in_one_section() -> None:
    named = [page for section in read_navigation(HERE / "navigation.toml") for page in section.pages]
    decisions = {place for place in project_pages().values() if place.startswith("adr/0")}
    assert len(named) == len(set(named))
    assert set(named) == {*project_pages().values(), *GENERATED} - decisions - {HOME}, "name it in navigation.toml"


def test_a_section_is_a_table_of_contents_that_the_page_does_not_show() -> None:
    tree = sidebar([Section("Start", ("quickstart", "dashboard"))])
    assert tree == "\n```{toctree}\n:hidden:\n:caption: Start\n\nquickstart\ndashboard\n```\n"


@pytest.fixture
def site(tmp_path: Path) -> Path:
    """Return a site of two pages and a picture, all of whose links hold."""
    (tmp_path / "adr").mkdir()
    (tmp_path / "a picture.png").write_bytes(b"")
    (tmp_path / "index.html").write_text(
        '<h1 id="top">A</h1><a href="adr/one.html#why">1</a><img src="a%20picture.png"><a href="#top">up</a>'
        '<a href="https://example.org/none#none">away</a><a href="mailto:a@example.org">mail</a>'
    )
    (tmp_path / "adr" / "one.html").write_text('<h1 id="why">B</h1><a href="../index.html">home</a><a href="..">up</a>')
    return tmp_path


def test_links_that_hold_are_no_faults(site: Path) -> None:
    assert broken_links(site) == []
    assert unreachable_pages(site) == []
    assert inline_scripts(site) == []


@pytest.mark.parametrize(
    ("link", "fault"),
    [
        ("none.html", "no such file"),
        ("adr/none.png", "no such file"),
        ("adr/one.html#none", "no such anchor"),
        ("#none", "no such anchor"),
        ("adr", "no such file"),
        ("/index.html", "begins with /, so it would leave the path of a proxy"),
        ("../index.html", "leaves the site"),
    ],
)
def test_a_broken_link_is_found(site: Path, link: str, fault: str) -> None:
    index = site / "index.html"
    index.write_text(f'{index.read_text()}<a href="{link}">broken</a>')
    assert broken_links(site) == [f"index.html: {link}: {fault}"]


def test_missing_scripts_and_pictures_are_found(site: Path) -> None:
    (site / "adr" / "one.html").write_text('<script src="none.js"></script><img src="none.png">')
    assert broken_links(site) == [
        "adr/one.html: none.js: no such file",
        "adr/one.html: none.png: no such file",
        "index.html: adr/one.html#why: no such anchor",
    ]


def test_a_page_without_a_link_to_it_is_found(site: Path) -> None:
    (site / "lost.html").write_text('<a href="lost.html">self</a>')
    assert unreachable_pages(site) == ["lost.html"]


@pytest.mark.parametrize("html", ["<script>go()</script>", '<p onclick="go()">', '<a href="javascript:go()">'])
def test_a_script_within_a_page_is_found(site: Path, html: str) -> None:
    (site / "adr" / "one.html").write_text(html)
    assert inline_scripts(site) == ["adr/one.html"]
