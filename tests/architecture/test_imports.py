"""Packages import each other in one direction only, and robots need only the base install."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.sources import ROOT

# Runs in a fresh interpreter that finds the packages of the base install only; those of the cloud are hidden too.
BASE_INSTALL = """
import importlib, sys
from importlib.abc import MetaPathFinder

BASE = {"msgspec", "numpy", "websockets", "ppaas", "robots"}

class NotInstalled(MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] not in BASE | sys.stdlib_module_names:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, NotInstalled())
"""

ROBOT_MODULES = [
    "ppaas.controllers.base",
    "ppaas.cost_values",
    "ppaas.errors",
    "ppaas.messages",
    "ppaas.nodes.base",
    "ppaas.nodes.graph",
    "ppaas.parameters",
    "ppaas.plugins",
    "ppaas.wire.rosbridge",
    "robots.base_controller",
    "robots.client.move_base",
    "robots.client.rest",
    "robots.client.robot_client",
    "robots.move_base_client",
    "robots.onboard.base_controller",
    "robots.rest",
]


def base_install(code: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", BASE_INSTALL + code, *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def test_import_contracts_between_packages_hold():
    command = Path(sys.executable).with_name("lint-imports")
    result = subprocess.run([command], cwd=ROOT, capture_output=True, text=True, timeout=120, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    assert "0 broken" in result.stdout


@pytest.mark.parametrize("module", ROBOT_MODULES)
def test_robot_module_is_imported_with_the_base_install(module):
    result = base_install("importlib.import_module(sys.argv[1])", module)
    assert result.returncode == 0, result.stderr


def test_base_install_of_these_tests_has_no_other_packages():
    result = base_install("importlib.import_module('numba')")
    assert "No module named 'numba'" in result.stderr


def test_command_line_shows_help_with_the_base_install():
    result = base_install("from robots.cli.main import main; sys.argv = ['ppaas', '--help']; sys.exit(main())")
    assert result.returncode == 0, result.stderr
    assert "usage: ppaas" in result.stdout


@pytest.mark.parametrize("command", ["robot", "plan", "map", "machine", "simulate"])
def test_command_shows_help_with_the_base_install(command):
    code = "from robots.cli.main import main; sys.argv = ['ppaas', *sys.argv[1:]]; sys.exit(main())"
    result = base_install(code, command, "--help")
    assert result.returncode == 0, result.stderr
    assert f"usage: ppaas {command}" in result.stdout


def test_cloud_command_names_its_missing_extra():
    result = base_install("from robots.cli.main import main; sys.argv = ['ppaas', 'up']; sys.exit(main())")
    assert result.returncode == 1
    assert "pip install '.[cloud]'" in result.stderr


# What the start of a process costs: a cloud starts four of them, and an endpoint may stay idle.
STARTS = """
import sys

def loaded(*packages):
    return [name for name in packages if name in sys.modules]

import endpoints.cloud_processes.server
of_master = loaded("numba", "scipy", "cryptography", "fastapi", "pydantic", "uvicorn", "starlette.routing")
import endpoints.cloud_processes.endpoint_process
print(of_master, loaded("numba", "scipy", "cryptography"))
"""


def test_master_and_endpoint_start_without_packages_that_only_some_requests_need():
    result = subprocess.run(
        [sys.executable, "-c", STARTS], cwd=ROOT, capture_output=True, text=True, timeout=60, check=False
    )
    assert result.stdout == "[] []\n", result.stderr
