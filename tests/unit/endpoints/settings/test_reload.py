"""Settings that are read again: what differs, what can be applied, and what stays."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

from endpoints.cli.settings_tree import TABLES, UP, settled
from endpoints.settings.reload import ReloadReport, RunningSettings
from endpoints.settings.setting import RELOADED, settings_of
from ppaas.errors import InvalidInput
from robots.cli.command_parser import CommandParser
from tests.unit.endpoints.settings.conftest import WriteSettings

Running = Callable[..., RunningSettings]


@pytest.fixture
def running(tmp_path: Path) -> Running:
    """Return a function that starts a command with the file of settings, and with words."""

    def started(*words: str, environment: dict[str, str] | None = None) -> RunningSettings:
        given = ["--config", str(tmp_path / "ppaas.toml"), *words]
        parser = CommandParser()
        TABLES[UP](parser)
        arguments = parser.parse_args(given)
        return RunningSettings(settings_of({UP: TABLES[UP]}), partial(settled, UP, arguments, environment or {}))

    return started


def changes(report: ReloadReport) -> dict[str, tuple[str, str, bool]]:
    return {one.key: (one.before, one.after, one.applied) for one in report.changed}


def test_what_can_be_applied_is_taken_and_the_rest_is_reported_each_time(
    running: Running, write: WriteSettings
) -> None:
    file = write("[up]\nport = 8600\nquota = {maps = 3}\n")
    command = running()
    in_force = command.arguments
    write("[up]\nport = 8700\nquota = {maps = 4}\nidle = 7\n")
    new, report = command.again()
    assert report.file == str(file)
    assert changes(report) == {
        "up.port": ("8600", "8700", False),
        "up.quota": ('{"maps": 3}', '{"maps": 4}', True),
        "up.idle": ("600.0", "7.0", True),
    }
    assert str(report) == "changed: up.quota, up.idle; needs a restart: up.port" or (
        str(report) == "changed: up.idle, up.quota; needs a restart: up.port"
    )
    assert (in_force.port, in_force.quota, in_force.idle) == (8600, [("maps", 3)], 600.0), "nothing before take"
    command.take(new)
    assert (in_force.port, in_force.quota, in_force.idle) == (8600, [("maps", 4)], 7.0)
    assert changes(command.again()[1]) == {"up.port": ("8600", "8700", False)}
    write("[up]\nport = 8600\n")
    new, report = command.again()
    assert changes(report) == {"up.quota": ('{"maps": 4}', "{}", True), "up.idle": ("7.0", "600.0", True)}


def test_a_wrong_setting_changes_nothing_and_offers_the_nearest_name(running: Running, write: WriteSettings) -> None:
    file = write("[up]\nidle = 5\n")
    command = running()
    write("[up]\nidle = 6\nretenton = {audit = 9}\n")
    with pytest.raises(InvalidInput, match=rf"{file}:3: up.retenton is unknown: did you mean retention\?"):
        command.again()
    write("[up]\nidle = -1\nlog-level = 'warning'\n")
    with pytest.raises(InvalidInput, match=f"{file}:2: up.idle"):
        command.again()
    file.unlink()
    with pytest.raises(InvalidInput, match="cannot read the settings"):
        command.again()
    assert command.arguments.idle == 5.0


def test_options_and_variables_of_the_start_go_before_the_file(running: Running, write: WriteSettings) -> None:
    write("[up]\n")
    command = running("--idle", "5", environment={"PPAAS_LOG_LEVEL": "error", "PPAAS_STORE": "sqlite:///a.db"})
    write("[up]\nidle = 7\nlog-level = 'debug'\nstore-file = 'url'\nkeep-versions = 2\n")
    assert changes(command.again()[1]) == {"up.keep-versions": ("-", "2", True)}


def test_what_the_command_has_settled_itself_is_no_change(running: Running, write: WriteSettings) -> None:
    write("[up]\nstore-file = 'url'\n")
    command = running()
    command.arguments.store = "cassandra://ann:secret@host/keys"  # read from the file
    assert changes(command.again()[1]) == {}
    write("[up]\nstore = 'cassandra://host/keys'\n")
    report = command.again()[1]
    assert changes(report)["up.store"] == ("-", "cassandra://host/keys", False)
    assert "secret" not in str(report.changed)


def test_every_setting_that_can_be_reloaded_exists() -> None:
    known = {(setting.table, setting.action.dest) for setting in settings_of(TABLES)}
    assert {(table, name) for table, names in RELOADED.items() for name in names} <= known
    assert all(setting.reloads for setting in settings_of(TABLES) if setting.key.startswith("up.oidc-"))
