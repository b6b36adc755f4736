"""Environments with other versions of Python and of the packages than those of the lock."""

import functools
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Literal

from tests.support.sources import ROOT, pyproject

FOLDER = ROOT / "build" / "versions"

TOOLS = ("pytest", "pytest-asyncio", "pytest-timeout", "pytest-xdist", "hypothesis", "httpx", "jsonschema")
"""What the tests need themselves, in the versions of this environment."""

QUICK_KERNELS = {"NUMBA_OPT": "1"}
"""Environment in which numba compiles with few optimizations; without any, it keeps half of the kernels in no cache."""

INSTALL_TIMEOUT = 600.0
"""Time limit of an installation, for a registry that is slow [s]."""


class Missing(Exception):
    """An interpreter is not installed; the message says which."""


@dataclass(frozen=True)
class Versions:
    """Versions that an environment is made of.

    Parameters
    ----------
    name : str
        Name of its folder.
    python : str
        Version of Python, such as ``3.12``.
    resolution : str
        Which of the versions that ``pyproject.toml`` allows are installed of its packages: the lowest or the newest.
    """

    name: str
    python: str
    resolution: Literal["lowest-direct", "highest"]

    @property
    def folder(self) -> Path:
        """Folder of the environment."""
        return FOLDER / self.name

    def run(self, *arguments: str | Path, timeout: float, **variables: str) -> subprocess.CompletedProcess[str]:
        """Run its Python in the checkout, with further environment variables.

        Kernels are compiled into a cache of its own, which stays for the next time; with few optimizations, which
        takes four fifths of the time, they do the same.
        """
        cache = {"NUMBA_CACHE_DIR": str(FOLDER / f"{self.name}-kernels"), **QUICK_KERNELS}
        return subprocess.run(
            [self.folder / "bin" / "python", *arguments],
            cwd=ROOT,
            env=os.environ | cache | variables,
            capture_output=True,
            text=True,
            timeout=timeout,
            check=False,
        )


LOWEST = Versions("lowest", "3.11", "lowest-direct")
NEWEST_312 = Versions("newest-3.12", "3.12", "highest")
NEWEST_313 = Versions("newest-3.13", "3.13", "highest")


def make(versions: Versions) -> None:
    """Make the environment anew, with all extras that a cloud and its robots may install.

    Raises
    ------
    Missing
        The interpreter is not installed.
    AssertionError
        The packages cannot be installed together.
    """
    python = interpreter(versions.python)
    uv = Path(sys.executable).with_name("uv")
    _run([uv, "venv", "--quiet", "--clear", "--no-python-downloads", "--python", python, versions.folder])
    install = [uv, "pip", "install", "--quiet", "--python", versions.folder / "bin" / "python"]
    _run([*install, "--resolution", versions.resolution, "--editable", f".[{','.join(shipped_extras())}]"])
    _run([*install, *(f"{tool}=={version(tool)}" for tool in TOOLS)])


def add(versions: Versions, *packages: Path) -> None:
    """Install packages that need this project into an environment, as their users would.

    Raises
    ------
    AssertionError
        They cannot be installed.
    """
    uv = Path(sys.executable).with_name("uv")
    _run([uv, "pip", "install", "--quiet", "--python", versions.folder / "bin" / "python", *packages])


def shipped_extras() -> list[str]:
    """Return the extras that users install; those for developers hold packages at newer versions."""
    return [extra for extra in pyproject()["project"]["optional-dependencies"] if extra not in ("dev", "bench")]


@functools.cache
def interpreter(minor: str) -> Path:
    """Return an interpreter of a version: the one of the tests, of the path, or of pyenv."""
    if sys.version.startswith(f"{minor}."):
        return Path(sys.executable)
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"))
    on_path = shutil.which(f"python{minor}")
    candidates = [*sorted(pyenv.glob(f"versions/{minor}.*/bin/python"), reverse=True)]
    for candidate in [Path(on_path), *candidates] if on_path else candidates:
        told = subprocess.run([candidate, "-V"], capture_output=True, text=True, timeout=60, check=False)
        if told.returncode == 0 and told.stdout.startswith(f"Python {minor}."):  # a shim of pyenv may lead nowhere
            return candidate
    raise Missing(f"no Python {minor} is installed")


def _run(command: list[str | Path]) -> None:
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=INSTALL_TIMEOUT, check=False)
    assert done.returncode == 0, done.stderr
