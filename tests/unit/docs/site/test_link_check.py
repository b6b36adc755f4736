"""The checker of the site finds what no builder finds."""

from pathlib import Path

import pytest

from docs.site.link_check import broken_links, inline_scripts, unreachable_pages


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
