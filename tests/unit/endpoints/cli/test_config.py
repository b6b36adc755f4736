"""``ppaas config``: check, show, explain."""

import json
from pathlib import Path
from typing import Any

import pytest

from endpoints.settings import effective
from robots.cli.main import main

SECRET = "cassandra://ann:pass1234@host/keys"


@pytest.fixture(autouse=True)
def no_usual_file(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(effective, "DEFAULT_FILE", tmp_path / "etc.toml")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    (tmp_path / "ppaas.toml").write_text("[up]\nport = 8600\nquota = {maps = 3}\n")
    return tmp_path / "ppaas.toml"


def printed(capsys: pytest.CaptureFixture[str], *words: str, status: int = 0) -> str:
    """Return what ``ppaas config`` prints."""
    assert main(["config", *words]) == status
    return capsys.readouterr().out


def test_a_good_file_is_reported_as_such(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert printed(capsys, "check", str(file)) == f"no problems in {file}\n"
    assert "there is no file" in printed(capsys, "check")
    assert json.loads(printed(capsys, "check", str(file), "--json")) == {
        "good": True, "file": str(file), "problems": [],
    }  # fmt: skip


def test_all_problems_of_both_tables_are_reported(
    file: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    file.write_text(f"[up]\nport = 'x'\nstore = '{SECRET}'\n[machine]\ndead = 0.1\ndaed = 1\n")
    monkeypatch.setenv("PPAAS_PROT", "1")
    lines = printed(capsys, "check", str(file), status=1).splitlines()
    assert [line.split(": ")[0] for line in lines] == [
        "the variable PPAAS_PROT is unknown", f"{file}:6", f"{file}:2", f"{file}:3", f"{file}:5",
    ]  # fmt: skip
    assert "pass1234" not in "".join(lines)
    answer = json.loads(printed(capsys, "check", str(file), "--json", status=1))
    assert answer == {"good": False, "file": str(file), "problems": lines}


def test_a_missing_file_is_a_problem(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "cannot read the settings" in printed(capsys, "check", str(tmp_path / "no.toml"), status=1)


def test_values_are_shown_with_their_sources_and_without_passwords(
    file: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PPAAS_STORE", SECRET)
    text = printed(capsys, "show", str(file), "--json")
    rows: dict[str, Any] = {row.pop("key"): row for row in json.loads(text)}
    assert rows["up.port"] == {"value": 8600, "source": f"{file}:2"}
    assert rows["up.quota"] == {"value": {"maps": 3}, "source": f"{file}:3"}
    assert rows["up.store"] == {"value": "cassandra://ann:***@host/keys", "source": "PPAAS_STORE"}
    assert rows["up.data"] == {"value": "var", "source": "default"}
    assert rows["machine.port"] == {"value": 8500, "source": "default"}
    table = printed(capsys, "show", str(file), "--table", "up")
    assert "pass1234" not in text + table
    (line,) = [line for line in table.splitlines() if line.startswith("up.quota ")]
    assert line.split("  ")[-1] == f"{file}:3" and '{"maps": 3}' in line
    assert "machine." not in table


def test_wrong_settings_are_not_shown_but_reported(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file.write_text("[up]\nport = 'x'\n")
    assert main(["config", "show", str(file)]) == 1
    assert capsys.readouterr() == ("", f"ppaas: invalid-input: {file}:2: up.port: Input should be a valid integer\n")


@pytest.mark.parametrize("key", ["up.listen-machines", "listen-machines", "--listen-machines"])
def test_a_setting_is_explained(key: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["explain", "--json", "--", key]
    assert json.loads(printed(capsys, *words)) == [
        {
            "key": "up.listen-machines",
            "meaning": "listen for machines of other hosts here and on the next port",
            "type": "text",
            "default": None,
            "option": "--listen-machines",
            "variable": "PPAAS_LISTEN_MACHINES",
            "reload": False,
        }
    ]


def test_a_setting_of_both_commands_is_explained_for_both(capsys: pytest.CaptureFixture[str]) -> None:
    text = printed(capsys, "explain", "port")
    assert "key       up.port\n" in text and "key       machine.port\n" in text
    assert text.count("variable  PPAAS_PORT\n") == 2


def test_whether_a_setting_can_be_reloaded_is_explained(capsys: pytest.CaptureFixture[str]) -> None:
    facts = {each["key"]: each["reload"] for each in json.loads(printed(capsys, "explain", "--json", "log-level"))}
    assert facts == {"up.log-level": True, "machine.log-level": False}


def test_an_unknown_setting_is_answered_with_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["config", "explain", "prt"]) == 1
    assert capsys.readouterr().err == "ppaas: invalid-input: 'prt' is no setting: did you mean port?\n"
