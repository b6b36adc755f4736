"""Settings of commands as the commands get them: words of the command line go before all others."""

import argparse
from pathlib import Path
from typing import Any

import pytest

from endpoints.cli import machine_join, up
from endpoints.cli.settings_tree import TABLES, settled
from endpoints.cloud_processes.server import cloud_config
from endpoints.store_options import settle_stores
from engine.master.quotas import Quota
from ppaas.errors import InvalidInput
from robots.cli.command_parser import CommandParser
from robots.cli.main import main, parser_of

TEXT = """
[up]
port = 8600
linger = 5
data = "/srv/ppaas"
trusted-proxy = ["10.0.0.0/8"]
quota = {maps = 3}
standby = true

[machine]
label = {hall = "2"}
endpoints = 2
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    (tmp_path / "ppaas.toml").write_text(TEXT)
    return tmp_path / "ppaas.toml"


def settled_up(*words: str) -> argparse.Namespace:
    """Return the arguments with which ``ppaas up`` would start."""
    return settled("up", parser_of(["up", *words]).parse_args(["up", *words]))


def test_settings_of_a_file_are_arguments_of_the_cloud(file: Path) -> None:
    arguments = settled_up("--config", str(file))
    config = cloud_config(arguments)
    assert (arguments.port, config.linger, config.quota) == (8600, 5.0, Quota(maps=3))
    assert config.store == "sqlite:////srv/ppaas/ppaas.sqlite"
    assert (arguments.standby, arguments.config) == ("", file)


@pytest.mark.parametrize(
    ("words", "name", "value"),
    [
        (["--port", "8500"], "port", 8500),  # the default, but given
        (["--linger=30"], "linger", 30.0),
        (["--trusted-proxy", "::1", "--trusted-proxy", "::2"], "trusted_proxy", ["::1", "::2"]),
        (["--quota", "robots=2"], "quota", [("robots", 2)]),
        (["--standby", "a-ticket"], "standby", "a-ticket"),
    ],
)
def test_options_go_before_the_file(file: Path, words: list[str], name: str, value: Any) -> None:
    assert getattr(settled_up("--config", str(file), *words), name) == value


def test_variables_go_between_options_and_the_file(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PPAAS_PORT", "8700")
    assert settled_up("--config", str(file)).port == 8700
    assert settled_up("--config", str(file), "--port", "8800").port == 8800


def test_a_machine_takes_its_own_table(file: Path) -> None:
    words = ["machine", "join", "ticket", "--config", str(file), "--cores", "3"]
    arguments = settled("machine", parser_of(words).parse_args(words))
    assert (arguments.ticket, arguments.cores, arguments.endpoints, arguments.port) == ("ticket", 3, 2, 8500)
    assert arguments.label == [("hall", "2")]


def test_the_url_of_a_store_stays_in_the_environment_until_the_cloud_removes_it(
    file: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    environment = {"PPAAS_STORE": f"sqlite://{tmp_path}/a.sqlite"}
    monkeypatch.setattr("os.environ", environment)
    file.write_text("[up]\nstore = 'sqlite:///srv/b.sqlite'\n")
    arguments = settled_up("--config", str(file))
    assert (arguments.store, list(environment)) == (None, ["PPAAS_STORE"])
    settle_stores(arguments)
    assert (arguments.store, environment) == (f"sqlite://{tmp_path}/a.sqlite", {})


def test_all_that_is_wrong_ends_the_start(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file.write_text("[up]\nprot = 1\nport = 'x'\n")
    monkeypatch.setenv("PPAAS_LINGR", "1")
    with pytest.raises(InvalidInput) as error:
        settled_up("--config", str(file))
    assert str(error.value).splitlines() == [
        "the variable PPAAS_LINGR is unknown: did you mean PPAAS_LINGER?",
        f"{file}:2: up.prot is unknown: did you mean port?",
        f"{file}:3: up.port: Input should be a valid integer",
    ]


@pytest.mark.parametrize("command", [["up"], ["machine", "join"]])
def test_both_commands_refuse_a_misspelt_setting(
    command: list[str], file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file.write_text("[up]\nprot = 1\n")
    assert main([*command, "--config", str(file), "--data", str(tmp_path / "data")]) == 1
    assert capsys.readouterr().err == f"ppaas: invalid-input: {file}:2: up.prot is unknown: did you mean port?\n"
    assert not (tmp_path / "data").exists()


def test_the_tables_are_those_of_the_commands() -> None:
    assert dict(TABLES) == {"up": up.configure, "machine": machine_join.configure}


def test_the_words_of_a_verb_are_kept() -> None:
    parser = CommandParser()
    inner = parser.add_subparsers().add_parser("verb")
    inner.add_argument("--option")
    assert parser.parse_args(["verb", "--option", "x"]).words == ["--option", "x"]
