"""Cached kernels are used until any kernel file changes, including those of the kernels that they call."""

import os
import pkgutil
import re
import subprocess
import sys
from pathlib import Path

import pytest

import ppaas
from ppaas.kernel_cache.sources import DECORATORS, kernel_files
from tests.unit.ppaas.kernel_cache.kernel_package import ASK, LOWER, package_of


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return the folder of a package that replaces this project's, with two modules of kernels."""
    return package_of(tmp_path)


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


@pytest.mark.parametrize("suffix", [".nbi", ".nbc"])
def test_a_kernel_whose_file_is_cut_is_compiled(folder, tmp_path, suffix):
    """A computer may lose its power while the file is written to the disk."""
    cache = {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    assert ask(folder, **cache) == "2 0\n"
    for file in tmp_path.rglob(f"upper*{suffix}"):
        file.write_bytes(file.read_bytes()[:40])
    assert ask(folder, **cache) == "2 0\n"
    assert ask(folder, **cache) == "2 1\n"


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


@pytest.mark.filterwarnings("ignore:ppaas.planners:DeprecationWarning")  # it walks through all modules
def test_all_kernel_packages_watch_their_files():
    packages = [found.name for found in pkgutil.walk_packages(ppaas.__path__, "ppaas.") if found.ispkg]
    kernels = [name for name in packages if name.endswith(".kernels")]
    assert len(kernels) > 5
    for name in kernels:
        text = Path(ppaas.__path__[0], *name.split(".")[1:], "__init__.py").read_text()
        assert "\nwatch_all_kernels()\n" in text, name


def test_all_kernels_are_compiled_with_the_options_of_one_module():
    others = [
        str(file)
        for file in kernel_files(Path(ppaas.__path__[0]))
        if file.name != DECORATORS.name and re.search(r"\b(njit|jit)\b", file.read_text())
    ]
    assert others == []
