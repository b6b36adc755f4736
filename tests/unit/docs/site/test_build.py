"""A site is built only if all is well, and takes the place of the one before."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from docs.site import build as building
from docs.site.__main__ import main
from docs.site.build import build
from docs.site.navigation import Section
from ppaas.errors import InvalidInput

PAGES = ("rest", "adr/README", "findings/README", "CHANGELOG", "CONTRIBUTING", "SECURITY")


@pytest.fixture
def folder(project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return where the site of the project is built; an older one is there."""
    rest = project / "docs" / "rest.md"
    rest.write_text(rest.read_text().replace(" [all](examples/small)", ""))
    monkeypatch.setattr(building, "read_navigation", lambda _file: [Section("Start", PAGES)])
    folder = tmp_path / "site"
    folder.mkdir()
    (folder / "old.html").write_text("old")
    return folder


@pytest.fixture
def add(project: Path) -> Callable[[str], None]:
    """Return a function that adds text to a page."""

    def add(text: str) -> None:
        with (project / "docs" / "rest.md").open("a") as file:
            file.write(f"\n{text}\n")

    return add


def test_a_site_replaces_the_one_before(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder.parent / "draws.js").write_text("")
    assert main([str(folder), "--mermaid", str(folder.parent / "draws.js")]) == 0
    assert not (folder / "old.html").exists()
    assert {"index.html", "rest.html", "search.html", "searchindex.js"} <= {file.name for file in folder.iterdir()}
    assert re.fullmatch(r"docs: 9 pages in .*site\n", capsys.readouterr().out)
    assert 'href="rest.html#r"' in (folder / "index.html").read_text()


def test_pages_with_a_diagram_load_the_script_that_draws_it(folder: Path, add: Callable[[str], None]) -> None:
    script = folder.parent / "draws.js"
    script.write_text("draw()")
    add("## A diagram\n```mermaid\nflowchart LR\n    a --> b\n```")
    build(folder, mermaid=script)
    page = (folder / "rest.html").read_text()
    assert '<pre class="mermaid">flowchart LR\n    a --&gt; b</pre>' in page
    assert "_static/mermaid.js" in page and "_static/mermaid.js" not in (folder / "index.html").read_text()
    assert (folder / "_static" / "mermaid.js").read_text() == "draw()"
    build(folder, mermaid=None)
    assert "mermaid.js" not in (folder / "rest.html").read_text()


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("[gone](../README.md#gone)", r"rest\.md:\d+: WARNING: .*gone"),
        ("```nolanguage\n?\n```", r"rest\.md:\d+: WARNING: .*nolanguage"),
        ("<a href='gone.html'>gone</a>", r"rest\.html: gone\.html: no such file"),
        ("<script>go()</script>", r"rest\.html: has a script within the page"),
    ],
)
def test_a_fault_of_a_page_fails_the_build_and_leaves_the_site_before(
    folder: Path, add: Callable[[str], None], text: str, fault: str
) -> None:
    add(text)
    with pytest.raises(InvalidInput, match=fault):
        build(folder, mermaid=None)
    assert [file.name for file in folder.iterdir()] == ["old.html"]
    assert not list(folder.parent.glob(".docs-*"))


def test_a_page_without_a_place_fails_the_build(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(building, "read_navigation", lambda _file: [Section("Start", PAGES[:-1])])
    assert main([str(folder)]) == 1
    assert re.search(r"docs: .*SECURITY\.md: WARNING: .*toctree", capsys.readouterr().err, re.DOTALL)
