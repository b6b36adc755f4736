"""Settings made from options: names, types, and values as the options have them."""

import argparse
from pathlib import Path
from typing import Any

import pytest

from endpoints.cli.settings_tree import TABLES
from endpoints.settings.setting import HIDDEN, Setting, settings_of, without_password

SETTINGS = {setting.key: setting for setting in settings_of(TABLES)}


def test_each_option_of_both_commands_is_a_setting_but_for_the_file_and_the_ticket() -> None:
    for table, configure in TABLES.items():
        parser = argparse.ArgumentParser(add_help=False)
        configure(parser)
        flags = {action.option_strings[0] for action in parser._actions if action.option_strings} - {"--config"}
        assert {setting.flag for setting in SETTINGS.values() if setting.table == table} == flags


def test_variables_are_unique_within_a_command() -> None:
    for table in TABLES:
        variables = [setting.variable for setting in SETTINGS.values() if setting.table == table]
        assert len(variables) == len(set(variables))


def test_the_names_of_a_setting() -> None:
    setting = SETTINGS["up.map-store"]
    assert (setting.flag, setting.name, setting.variable) == ("--map-store", "map-store", "PPAAS_MAP_STORE")
    assert SETTINGS["up.data"].variable == "PPAAS_DATA_FOLDER"


@pytest.mark.parametrize(
    ("key", "type_name"),
    [
        ("up.port", "whole number"), ("up.linger", "number"), ("up.host", "text"), ("up.data", "text"),
        ("up.standby", "true or false"), ("up.quota", "table"), ("machine.label", "table"),
        ("up.allow", "list of texts"), ("up.allow-origin", "list of texts"),
        ("up.log-level", "one of debug, info, warning, error"), ("up.metrics", "text"),
    ],
)  # fmt: skip
def test_the_type_is_the_one_that_the_parser_of_the_option_returns(key: str, type_name: str) -> None:
    assert SETTINGS[key].type_name == type_name


@pytest.mark.parametrize(
    ("key", "given", "text", "value"),
    [
        ("up.port", 8600, "8600", 8600),
        ("up.linger", 5.0, "5", 5.0),
        ("up.data", "/srv", "/srv", Path("/srv")),
        ("up.standby", True, "true", ""),
        ("up.standby", False, "false", None),
        ("up.quota", {"maps": 10.0, "cores": 0.5}, "maps=10, cores=0.5", [("maps", 10), ("cores", 0.5)]),
        ("up.trusted-proxy", ["10.0.0.0/8", "::1"], "10.0.0.0/8,::1", ["10.0.0.0/8", "::1"]),
        ("machine.label", {"hall": "2"}, "hall=2", [("hall", "2")]),
        ("up.metrics", "0.0.0.0:9464", "0.0.0.0:9464", ("0.0.0.0", 9464)),
        ("up.master", ["a:8510", "b:8510"], "a:8510,b:8510", ["a:8510", "b:8510"]),
    ],
)
def test_a_value_of_a_file_and_of_a_variable_is_read_as_the_option(key: str, given: Any, text: str, value: Any) -> None:
    setting = SETTINGS[key]
    assert setting.from_file(given) == value
    assert setting.from_text(text) == value


@pytest.mark.parametrize(
    ("key", "text", "why"),
    [
        ("up.port", "65536", "from 0 to 65535"), ("up.dead", "0.5", "at least 1 s"), ("up.quota", "cakes=1", "'cakes'"),
        ("up.standby", "yes", "true or false"), ("up.log-level", "loud", "one of debug"), ("up.linger", "x", "float"),
        ("up.root-path", "/v1", "path prefix"), ("machine.label", "hall", "KEY=VALUE"),
    ],
)  # fmt: skip
def test_a_value_out_of_range_is_refused_with_the_words_of_the_option(key: str, text: str, why: str) -> None:
    with pytest.raises(ValueError, match=why):
        SETTINGS[key].from_text(text)


def test_a_password_is_refused_in_a_file_but_not_in_a_variable() -> None:
    setting, url = SETTINGS["up.store"], "cassandra://ann:secret@host/keys"
    assert setting.from_text(url) == url
    with pytest.raises(ValueError, match="give store-file") as error:
        setting.from_file(url)
    assert "secret" not in str(error.value)


@pytest.mark.parametrize(
    ("url", "shown"),
    [
        ("cassandra://ann:secret@host:9042/keys?x=1", f"cassandra://ann:{HIDDEN}@host:9042/keys?x=1"),
        ("cassandra://ann@host/keys", "cassandra://ann@host/keys"),
        ("sqlite:///var/ppaas.sqlite", "sqlite:///var/ppaas.sqlite"),
        ("cassandra://ann:secret@[host", HIDDEN),
    ],
)
def test_passwords_are_hidden(url: str, shown: str) -> None:
    assert without_password(url) == shown
    assert SETTINGS["up.store"].shown(url) == shown


@pytest.mark.parametrize(
    ("key", "value", "shown"),
    [
        ("up.webhook-allow-http", False, False),
        ("up.webhook-allow-http", True, True),
        ("up.retention", [("audit", 30.0)], {"audit": 30.0}),
        ("up.retention-size", [("recordings", 10.0)], {"recordings": 10.0}),
        ("up.data", Path("var"), "var"), ("up.quota", [("maps", 3)], {"maps": 3}), ("up.allow", ["a:b"], ["a:b"]),
        ("up.standby", "a ticket", True), ("up.standby", None, False), ("up.cores", None, None),
        ("up.store", None, None), ("up.metrics", ("127.0.0.1", 9464), "127.0.0.1:9464"),
    ],
)  # fmt: skip
def test_values_are_shown_as_json_has_them(key: str, value: Any, shown: Any) -> None:
    assert SETTINGS[key].shown(value) == shown


def test_the_help_contains_the_default() -> None:
    setting: Setting = SETTINGS["up.port"]
    assert setting.help == "port; 0 takes a free one (8500)"
