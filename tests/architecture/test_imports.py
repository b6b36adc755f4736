"""Arrows point down, and a robot gets by with the base install."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.sources import ROOT

# Runs in a fresh interpreter: every distribution but those of the base install is as good as not installed.
BASE_INSTALL = """
import importlib, sys
from importlib.abc import MetaPathFinder

BASE = {"msgspec", "numpy", "websockets", "ppaas", "engine", "endpoints", "storage", "robots"}

class NotInstalled(MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] not in BASE | sys.stdlib_module_names:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, NotInstalled())
"""

ROBOT_MODULES = [
    "ppaas.errors",
    "ppaas.messages",
    "ppaas.nodes.base",
    "ppaas.nodes.graph",
    "ppaas.plugins",
    "ppaas.wire.rosbridge",
    "robots.client.robot_client",
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


def test_the_contracts_between_packages_are_kept():
    command = Path(sys.executable).with_name("lint-imports")
    result = subprocess.run([command], cwd=ROOT, capture_output=True, text=True, timeout=120, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    assert "0 broken" in result.stdout


@pytest.mark.parametrize("module", ROBOT_MODULES)
def test_a_robot_imports_it_with_the_base_install(module):
    result = base_install("importlib.import_module(sys.argv[1])", module)
    assert result.returncode == 0, result.stderr


def test_the_base_install_of_these_tests_lacks_the_rest():
    result = base_install("importlib.import_module('numba')")
    assert "No module named 'numba'" in result.stderr


def test_the_command_line_helps_with_the_base_install():
    result = base_install("from robots.cli.main import main; sys.argv = ['ppaas', '--help']; sys.exit(main())")
    assert result.returncode == 0, result.stderr
    assert "usage: ppaas" in result.stdout
