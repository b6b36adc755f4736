"""Files of settings: what is wrong with one is named with its line."""

from pathlib import Path

import pytest

from endpoints.cli.settings_tree import TABLES
from endpoints.settings.setting import settings_of
from endpoints.settings.toml_file import MAX_FILE, SettingsFile
from ppaas.errors import InvalidInput
from tests.unit.endpoints.settings.conftest import WriteSettings

SETTINGS = settings_of(TABLES)


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("[up]\nprot = 1\n", 2, "up.prot is unknown: did you mean port?"),
        ("[up]\nmap_store = 'x'\n", 2, "up.map_store is unknown: did you mean map-store?"),
        ("# a\n\n[upp]\nport = 1\n", 3, "upp is unknown: did you mean up?"),
        ("[robots]\n", 1, "robots is unknown; the tables are machine and up"),
        ("port = 1\n", 1, "port is unknown: write it in the table of its command, as machine.port or up.port"),
        ("up = 3\n", 1, "up must be a table"),
        ("[machine]\nlinger = 3\n", 2, "machine.linger is unknown"),
        ("[up]\nallow = [\n 'a:b',\n]\nprot = 1\n", 5, "up.prot is unknown: did you mean port?"),
        ("[up]\nprot = [\n 1,\n]\n", 2, "up.prot is unknown: did you mean port?"),
        ("[up]\r\nprot = 1\r\n", 2, "up.prot is unknown: did you mean port?"),
    ],
)
def test_an_unknown_key_is_named_with_its_line(write: WriteSettings, text: str, line: int, words: str) -> None:
    path = write(text)
    assert list(SettingsFile(path).unknown_keys(SETTINGS)) == [f"{path}:{line}: {words}"]


def test_known_keys_are_not_named(write: WriteSettings) -> None:
    file = SettingsFile(write("[up]\nport = 1\nquota = {maps = 3}\n[machine.label]\nhall = '2'\n"))
    assert list(file.unknown_keys(SETTINGS)) == []
    assert file.table("machine") == {"label": {"hall": "2"}}
    assert file.place("machine", "label").endswith(":4")


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"[up]\nport =\n", "is no TOML: .*line 2"),
        (b"[up]\nport = 1\nport = 2\n", "is no TOML: .*line 3"),
        (b"\xff", "is no TOML: .*utf-8"),
        (b"#" * (MAX_FILE + 1), "too large"),
    ],
)
def test_a_file_that_is_no_toml_is_refused(tmp_path: Path, content: bytes, why: str) -> None:
    (tmp_path / "bad.toml").write_bytes(content)
    with pytest.raises(InvalidInput, match=f"bad.toml.*{why}"):
        SettingsFile(tmp_path / "bad.toml")


def test_a_missing_file_and_a_folder_are_reported(tmp_path: Path) -> None:
    for path in (tmp_path / "nowhere.toml", tmp_path):
        with pytest.raises(InvalidInput, match="cannot read the settings: "):
            SettingsFile(path)
