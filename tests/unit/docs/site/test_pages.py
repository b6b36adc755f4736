"""Pages are laid out with links that hold in the site."""

from pathlib import Path

import pytest

from docs.site import pages
from docs.site.navigation import Section
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
