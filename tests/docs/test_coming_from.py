"""docs/coming-from.md: the commands that it names exist, and it names every page of its section."""

import re
import tomllib

import pytest

from ppaas.imports.report import ImportOutcome
from robots.cli.main import main
from tests.support.sources import ROOT

PAGE = (ROOT / "docs" / "coming-from.md").read_text(encoding="utf-8")
COMMANDS = sorted({" ".join(found) for found in re.findall(r"`ppaas ([a-z]+)((?: [a-z0-9-]+)?)", PAGE)})


@pytest.mark.parametrize("command", COMMANDS)
def test_each_command_has_a_help(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main([*command.split(), "--help"])
    assert end.value.code == 0
    assert capsys.readouterr().out.startswith(f"usage: ppaas {' '.join(command.split())}")


def test_it_links_every_page_of_its_section() -> None:
    sections = tomllib.loads((ROOT / "docs" / "site" / "navigation.toml").read_text(encoding="utf-8"))["section"]
    (pages,) = [each["pages"] for each in sections if "coming-from" in each["pages"]]
    assert [page for page in pages if page != "coming-from" and f"({page}.md)" not in PAGE] == []


def test_it_names_every_outcome() -> None:
    assert [each.value for each in ImportOutcome if f"| `{each.value}` |" not in PAGE] == []
