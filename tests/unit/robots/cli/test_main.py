"""Command line: registered commands, cost of ``--help``, and exit statuses."""

import json
import re
import subprocess
import sys
from importlib.metadata import EntryPoint
from types import ModuleType

import pytest

from ppaas import distribution
from ppaas.errors import NotFound
from robots.cli import main
from tests.support.sources import pyproject

COMMANDS = pyproject()["project"]["entry-points"]["ppaas.commands"]
HEAVY = [
    "numpy", "msgspec", "websockets", "http.client", "fastapi", "uvicorn", "zenoh", "numba", "pymunk", "rich", "yaml",
    "asyncio",
]  # fmt: skip


def command(**members: object) -> ModuleType:
    """Return a command with the given behaviour."""
    module = ModuleType("command")
    given = {"NAME": "do", "HELP": "do it", "configure": lambda _parser: None, "run": lambda _arguments: 0}
    vars(module).update(given | members)
    return module


@pytest.fixture
def install(monkeypatch: pytest.MonkeyPatch):
    """Return a function that replaces all commands by given modules, or by names that cannot be loaded."""

    def put(**commands: ModuleType | str) -> None:
        entries = []
        for name, found in commands.items():
            path = found if isinstance(found, str) else f"command_{name}_of_a_test"
            if isinstance(found, ModuleType):
                monkeypatch.setitem(sys.modules, path, found)
            entries.append(EntryPoint(name, path, main.GROUP))
        monkeypatch.setattr(main, "entry_points", lambda group: entries)

    return put


@pytest.mark.parametrize("option", ["--help", "-h"])
def test_the_help_adds_no_options_of_commands(install, capsys, option: str):
    install(do=command(configure=lambda _parser: pytest.fail("adds its options")))
    with pytest.raises(SystemExit) as end:
        main.main([option])
    assert end.value.code == 0
    assert "do it" in capsys.readouterr().out


def test_the_help_lists_every_command(capsys):
    with pytest.raises(SystemExit) as end:
        main.main(["--help"])
    assert end.value.code == 0
    listed = re.findall(r"^    ([\w-]+)(?: +\S|$)", capsys.readouterr().out, re.MULTILINE)
    assert listed == sorted(COMMANDS)


@pytest.mark.parametrize("name", sorted(COMMANDS))
def test_each_command_has_its_own_help(capsys, name):
    with pytest.raises(SystemExit) as end:
        main.main([name, "--help"])
    assert end.value.code == 0
    assert f"usage: ppaas {name}" in capsys.readouterr().out


def test_the_help_of_all_commands_imports_nothing_heavy():
    code = f"""
import json, sys
from robots.cli.main import main
try:
    main(["--help"])
except SystemExit:
    print(json.dumps([name for name in {HEAVY} if name in sys.modules]))
"""
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert json.loads(ended.stdout.splitlines()[-1]) == []


def test_an_unknown_command_lists_the_known_ones(capsys):
    with pytest.raises(SystemExit) as end:
        main.main(["fly"])
    assert end.value.code == 2
    error = capsys.readouterr().err
    assert [name for name in COMMANDS if name not in error] == []


def test_the_exit_status_is_that_of_the_command(install):
    install(do=command(run=lambda _arguments: 7))
    assert main.main(["do"]) == 7


def test_a_command_may_lower_the_priority_of_its_process_alone(install, monkeypatch: pytest.MonkeyPatch):
    lowered: list[int] = []
    monkeypatch.setattr(main.os, "nice", lowered.append)
    monkeypatch.setattr(main.sys, "argv", ["ppaas", "do"])
    install(do=command(NICENESS=10))
    assert main.main(["do"]) == 0  # called by another program
    assert lowered == []
    assert main.main() == 0
    assert lowered == [10]


def test_an_error_is_reported_in_one_line_with_its_slug(install, capsys):
    def run(_arguments):
        raise NotFound("map", "atlantis", ["office"])

    install(do=command(run=run))
    assert main.main(["do"]) == 1
    assert capsys.readouterr().err == "ppaas: not-found: unknown map 'atlantis'; known: office\n"


def test_ctrl_c_exits_with_status_130(install):
    def run(_arguments):
        raise KeyboardInterrupt

    install(do=command(run=run))
    assert main.main(["do"]) == 130


@pytest.mark.parametrize(
    ("package", "extra"),
    [("pymunk", "sim"), ("fastapi", "cloud"), ("numba.core", "plan"), ("PIL", "plan"), ("matplotlib.figure", "plot")],
)
def test_missing_packages_are_reported_with_the_extra_to_install(install, capsys, package, extra):
    def run(_arguments):
        raise ModuleNotFoundError(f"No module named {package!r}", name=package)

    install(do=command(run=run))
    assert main.main(["do"]) == 1
    assert f"pip install '.[{extra}]'" in capsys.readouterr().err


@pytest.mark.parametrize(
    "error",
    [
        ModuleNotFoundError("No module named 'websockets.asyncio'", name="websockets.asyncio"),
        ImportError("cannot import name 'connect' from 'websockets.client'", name="websockets.client"),
    ],
)
def test_a_package_too_old_for_what_is_imported_is_named(install, capsys, monkeypatch, error):
    def run(_arguments):
        raise error

    install(do=command(run=run))
    with pytest.raises(ImportError):
        main.main(["do"])
    version = distribution.version
    monkeypatch.setattr(distribution, "version", lambda name: "12.0" if name == "websockets" else version(name))
    assert main.main(["do"]) == 1
    assert "does not work with websockets 12.0 (needed: >=" in capsys.readouterr().err


def test_a_command_that_cannot_be_loaded_is_listed_with_the_reason(install, capsys):
    install(do=command(), fly="pymunk_of_another_robot.fly")
    with pytest.raises(SystemExit):
        main.main(["--help"])
    listed = capsys.readouterr().out
    assert re.search(r"do +do it", listed)
    assert re.search(r"fly +needs pymunk_of_another_robot, which is not installed", listed)
    assert main.main(["do"]) == 0


def test_a_command_that_cannot_be_loaded_names_the_extra_to_install(install, capsys, monkeypatch):
    monkeypatch.setitem(main.EXTRAS, "pymunk_of_another_robot", "sim")
    install(do=command(), fly="pymunk_of_another_robot.fly")
    assert main.main(["fly"]) == 1
    assert "pip install '.[sim]'" in capsys.readouterr().err


def test_a_missing_module_of_this_project_is_not_hidden(install):
    def run(_arguments):
        raise ModuleNotFoundError("No module named 'endpoints.nothing'", name="endpoints.nothing")

    install(do=command(run=run))
    with pytest.raises(ModuleNotFoundError):
        main.main(["do"])
