"""Effective values: options go before variables, these before the file, and the file before the defaults."""

import sys
from pathlib import Path
from typing import Any

import pytest

from endpoints.cli.settings_tree import TABLES
from endpoints.settings import effective
from endpoints.settings.effective import Origin, SettingsTree, raise_if_any
from ppaas.errors import InvalidInput
from tests.unit.endpoints.settings.conftest import WriteSettings


def of_up(path: Path | None, name: str, **given: Any) -> tuple[Any, Origin, str]:
    """Return the value of a setting of ``ppaas up``, and where it comes from; nothing may be wrong."""
    values, wrong = SettingsTree(TABLES, path).values("up", given)
    assert wrong == []
    ((value, origin, source),) = [
        (each.value, each.origin, each.source) for setting, each in values.items() if setting.name == name
    ]
    return value, origin, source


def test_the_strongest_source_counts(write: WriteSettings, monkeypatch: pytest.MonkeyPatch) -> None:
    assert of_up(None, "port") == (8500, Origin.DEFAULT, "default")
    path = write("# ours\n[up]\nport = 8600\n")
    assert of_up(path, "port") == (8600, Origin.FILE, f"{path}:3")
    monkeypatch.setenv("PPAAS_PORT", "8700")
    assert of_up(path, "port") == (8700, Origin.VARIABLE, "PPAAS_PORT")
    assert of_up(path, "port", port=8500) == (8500, Origin.FLAG, "--port")
    monkeypatch.setenv("PPAAS_PORT", "")
    assert of_up(path, "port") == (8600, Origin.FILE, f"{path}:3")


def test_a_list_of_a_stronger_source_replaces_the_weaker_one(
    write: WriteSettings, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write("[up]\nquota = {maps = 3, cores = 2}\n")
    assert of_up(path, "quota")[0] == [("maps", 3), ("cores", 2.0)]
    monkeypatch.setenv("PPAAS_QUOTA", "robots=5")
    assert of_up(path, "quota")[0] == [("robots", 5)]


def test_each_command_has_its_table(write: WriteSettings) -> None:
    tree = SettingsTree(TABLES, write("[up]\nport = 8600\n[machine]\nport = 8700\n"))
    for table, port in (("up", 8600), ("machine", 8700)):
        values, _ = tree.values(table)
        assert [each.value for setting, each in values.items() if setting.name == "port"] == [port]


def test_the_file_is_the_given_one_then_that_of_the_variable_then_the_usual_one(
    write: WriteSettings, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert SettingsTree(TABLES).file is None
    usual = effective.DEFAULT_FILE
    usual.parent.mkdir()
    usual.write_text("[up]\nport = 1\n")
    assert of_up(None, "port")[0] == 1
    (tmp_path / "other.toml").write_text("[up]\nport = 2\n")
    monkeypatch.setenv("PPAAS_CONFIG", str(tmp_path / "other.toml"))
    assert of_up(None, "port")[0] == 2
    assert of_up(write("[up]\nport = 3\n"), "port")[0] == 3
    assert SettingsTree(TABLES).misspelt() == []


def test_a_usual_file_that_cannot_be_read_is_reported() -> None:
    effective.DEFAULT_FILE.mkdir(parents=True)
    with pytest.raises(InvalidInput, match="cannot read the settings"):
        SettingsTree(TABLES)


def test_a_wrong_value_is_named_with_its_source(write: WriteSettings, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write("[up]\nhost = '::'\nport = 'x'\n")
    monkeypatch.setenv("PPAAS_LINGER", "soon")
    _, wrong = SettingsTree(TABLES, path).values("up")
    assert wrong == [
        f"{path}:3: up.port: Input should be a valid integer",
        "PPAAS_LINGER: up.linger: could not convert string to float: 'soon'",
    ]


def test_a_wrong_value_is_named_with_its_source_also_if_an_option_goes_before_it(write: WriteSettings) -> None:
    path = write("[up]\nport = 'x'\n")
    values, wrong = SettingsTree(TABLES, path).values("up", {"port": 3})
    assert wrong == [f"{path}:2: up.port: Input should be a valid integer"]
    assert [each.source for setting, each in values.items() if setting.name == "port"] == ["--port"]


def test_the_file_and_the_variables_are_both_searched_for_unknown_names(
    write: WriteSettings, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write("[up]\nprot = 1\n[machine]\nlable = {}\n")
    monkeypatch.setenv("PPAAS_PROT", "1")
    assert SettingsTree(TABLES, path).misspelt() == [
        "the variable PPAAS_PROT is unknown: did you mean PPAAS_PORT?",
        f"{path}:2: up.prot is unknown: did you mean port?",
        f"{path}:4: machine.lable is unknown: did you mean label?",
    ]


def test_of_the_url_of_a_store_and_its_file_the_stronger_source_counts(
    write: WriteSettings, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write("[up]\nstore = 'sqlite:///a'\nmap-store-file = '/b'\n")
    monkeypatch.setenv("PPAAS_STORE_FILE", "/c")
    assert of_up(path, "store") == (None, Origin.DEFAULT, "default")
    assert of_up(path, "store-file") == (Path("/c"), Origin.VARIABLE, "PPAAS_STORE_FILE")
    monkeypatch.setenv("PPAAS_MAP_STORE", "file:///d")
    assert of_up(path, "map-store-file")[1] == Origin.DEFAULT
    assert of_up(path, "store-file", store="sqlite:///e")[1] == Origin.DEFAULT


def test_the_url_of_a_store_and_its_file_in_one_place_are_refused(write: WriteSettings) -> None:
    path = write("[up]\nstore = 'sqlite:///a'\nstore-file = '/b'\n")
    _, wrong = SettingsTree(TABLES, path).values("up")
    assert wrong == [f"{path}:2 and {path}:3: give either up.store or up.store-file"]


def test_a_port_of_a_service_of_kubernetes_is_no_setting(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PPAAS_PORT", "tcp://10.0.0.7:8500")
    monkeypatch.setenv("PPAAS_LINGER", "7")
    assert of_up(None, "port")[0] == 8500
    assert of_up(None, "linger")[0] == 7.0


def test_pydantic_is_not_imported_if_there_is_nothing_to_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "endpoints.settings.model", None)
    assert of_up(None, "port", port=3)[0] == 3


def test_all_problems_are_raised_together() -> None:
    raise_if_any([])
    with pytest.raises(InvalidInput, match="one\ntwo"):
        raise_if_any(["one", "two"])
