"""Cached kernels are used until any kernel file changes, including those of the kernels that they call."""

import os
import pkgutil
import subprocess
import sys
from pathlib import Path

import pytest

import ppaas

LOWER = """
from numba import njit

STEP = {step}

@njit(cache=True)
def lower(number):
    return number + STEP
"""

UPPER = """
from numba import njit

from ppaas.room.kernels.lower import lower

@njit(cache=True)
def upper(number):
    return lower(number)
"""

ASK = """
import ppaas
ppaas.__path__.insert(0, {folder!r})
from ppaas.room.kernels.upper import upper
print(upper(1), sum(upper.stats.cache_hits.values()))
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return the folder of a package that replaces this project's, with two modules of kernels."""
    kernels = tmp_path / "ppaas" / "room" / "kernels"
    kernels.mkdir(parents=True)
    (kernels.parent / "__init__.py").touch()
    real = Path(ppaas.__path__[0], "planners", "kernels", "__init__.py")
    (kernels / "__init__.py").write_text(real.read_text())
    (kernels / "lower.py").write_text(LOWER.format(step=1))
    (kernels / "upper.py").write_text(UPPER)
    return tmp_path / "ppaas"


def ask(folder: Path, **environment: str) -> str:
    """Return the result of the upper kernel in a new process, and the number of its cache hits."""
    command = [sys.executable, "-c", ASK.format(folder=str(folder))]
    inherited = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    return subprocess.run(command, env=inherited | environment, check=True, capture_output=True, text=True).stdout


@pytest.mark.parametrize("given", [False, True])
def test_kernel_is_recompiled_if_a_called_kernel_has_changed_not_if_files_were_only_touched(folder, tmp_path, given):
    environment = {"NUMBA_CACHE_DIR": str(tmp_path / "cache")} if given else {}
    assert ask(folder, **environment) == "2 0\n"
    if not given:
        for file in folder.rglob("*.py"):
            os.utime(file, (1, 1))
    assert ask(folder, **environment) == "2 1\n"
    (folder / "room" / "kernels" / "lower.py").write_text(LOWER.format(step=2))
    assert ask(folder, **environment) == "3 0\n"
    assert (tmp_path / "cache").exists() == given


PAIR = """
from typing import NamedTuple

from numba import njit

class {name}(NamedTuple):
    left: int
    right: int

@njit(cache=True)
def upper(pair):
    return pair.left + pair.right
"""

ASK_OF_A_PAIR = """
import ppaas
ppaas.__path__.insert(0, {folder!r})
from ppaas.room.kernels import upper as module
print(module.upper(module.{name}(1, 2)), sum(module.upper.stats.cache_hits.values()))
"""


def test_kernel_is_recompiled_if_an_argument_type_is_renamed(folder):
    results = []
    for name in ("Pair", "Pair", "Couple"):
        (folder / "room" / "kernels" / "upper.py").write_text(PAIR.format(name=name))
        program = ASK_OF_A_PAIR.format(folder=str(folder), name=name)
        results.append(subprocess.check_output([sys.executable, "-c", program], text=True))
    assert results == ["3 0\n", "3 1\n", "3 0\n"]


def test_all_kernel_packages_watch_their_files():
    packages = [found.name for found in pkgutil.walk_packages(ppaas.__path__, "ppaas.") if found.ispkg]
    kernels = [name for name in packages if name.endswith(".kernels")]
    assert len(kernels) > 5
    for name in kernels:
        text = Path(ppaas.__path__[0], *name.split(".")[1:], "__init__.py").read_text()
        assert "\nwatch_all_kernels()\n" in text, name
