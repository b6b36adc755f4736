"""Settings of endpoints are those of the options."""

from pathlib import Path

import pytest

from endpoints.cli import machine_join, up
from endpoints.processes.config import front_config
from robots.cli.command_parser import CommandParser


@pytest.mark.parametrize(("command", "words"), [(up, []), (machine_join, ["ticket"])])
def test_the_folder_of_the_documentation_site_holds_in_any_working_folder(
    command: object, words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    parser = CommandParser()
    command.configure(parser)  # type: ignore[attr-defined]
    monkeypatch.chdir(tmp_path)
    given = parser.parse_args([*words, "--docs-site", "site"])
    assert front_config(given, port=8500).docs_site == str(tmp_path / "site")
    assert front_config(parser.parse_args(words), port=8500).docs_site == ""
