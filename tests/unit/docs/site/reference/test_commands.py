"""The page of commands has each command, verb and option, with its default."""

from docs.site.reference.commands import page as commands_page
from tests.support.sources import pyproject

TEXT = commands_page()


def section(command: str) -> str:
    """Return what the page says of a command."""
    return TEXT.partition(f"# `{command}`\n")[2].partition("\n#")[0]


def test_each_command_and_bridge_has_a_section() -> None:
    groups = pyproject()["project"]["entry-points"]
    commands = [f"ppaas {name}" for name in groups["ppaas.commands"]]
    commands += [f"ppaas bridge {name}" for name in groups["ppaas.bridges"]]
    commands += [f"ppaas machine {name}" for name in groups["ppaas.machine_verbs"]]
    assert [command for command in commands if not section(command)] == []


def test_options_have_their_values_and_defaults() -> None:
    text = section("ppaas up")
    assert "`ppaas up [OPTION ...]`" in text
    assert "| `--port PORT` | port; 0 takes a free one (8500) |" in text
    assert "| `--log-level {debug,info,warning,error}` |" in text
    assert "%(" not in TEXT


def test_arguments_that_are_not_options_are_in_the_usage() -> None:
    assert "`ppaas map publish " in section("ppaas map publish")
    assert "`ppaas login user [OPTION ...]`" in section("ppaas login").replace("USER", "user")
