"""Wheel of compiled kernels, which other computers use instead of compiling them (`ppaas.kernel_cache.shipped`)."""

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from importlib.metadata import distribution, version
from pathlib import Path

import msgspec

import ppaas
from engine.runtimes.compilation import stamp
from engine.runtimes.compilation.stamp import ModuleNotes
from ppaas.distribution import NAME
from ppaas.errors import Unavailable
from ppaas.kernel_cache.locators import KernelIndex
from ppaas.kernel_cache.shipped import MANIFEST, PACKAGE, Manifest
from ppaas.kernel_cache.target import LEVEL, has_level

PROJECT = """\
[build-system]
requires = ["hatchling"]
build-backend = "hatchling.build"

[project]
name = "{name}-kernels"
version = "{version}"
description = "Compiled kernels of {name} for {level}."
license = "Apache-2.0"
requires-python = "=={python}.*"
dependencies = ["{name}=={version}", "numba=={numba}", "llvmlite=={llvmlite}"]

[tool.hatch.build.targets.wheel]
packages = ["{package}"]
artifacts = ["*.nbi", "*.nbc"]

[tool.hatch.build.targets.wheel.hooks.custom]
"""

HOOK = """\
from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class Tag(BuildHookInterface):
    def initialize(self, version, build_data):
        build_data["tag"] = "{tag}"
"""

LAYER = "tbb"


def build_wheel(folder: Path) -> Path:
    """Build a wheel of all kernels of this computer's cache, which must be complete.

    Parameters
    ----------
    folder : Path
        Folder to put it in.

    Returns
    -------
    Path
        The wheel. It fits one version of this project, Python, numba and llvmlite, and processors of the level.

    Raises
    ------
    Unavailable
        This processor is below the level, its cache has no kernels, or hatchling is not installed.
    """
    if not has_level():
        raise Unavailable(f"this processor is below {LEVEL}, for which kernels of a wheel are compiled")
    with tempfile.TemporaryDirectory(prefix="ppaas-") as project:
        write_project(Path(project))
        build = (sys.executable, "-m", "hatchling", "build", "--target", "wheel")
        done = subprocess.run(build, cwd=project, check=False, capture_output=True, text=True)
        if done.returncode:
            raise Unavailable(f"the wheel cannot be built, is hatchling installed?\n{done.stderr.strip()}")
        (wheel,) = Path(project, "dist").iterdir()
        folder.mkdir(parents=True, exist_ok=True)
        return Path(shutil.move(wheel, folder / wheel.name))


def write_project(project: Path) -> None:
    """Write the files that the wheel is built from: the package of kernels, and the build's parameters.

    Raises
    ------
    Unavailable
        The cache has no kernels.
    """
    manifest = Manifest.of_this_process()
    compiled = ModuleNotes(stamp.stamp_file(Path(ppaas.__path__[0]), LAYER)).compiled()
    if not compiled:
        raise Unavailable("no kernels are compiled here for threads: TBB is missing, or a wheel of them is installed")
    package = project / PACKAGE
    for module, files in compiled.items():
        inside = module.partition(".")[2].rpartition(".")[0]
        for index in map(Path, files):
            _copy(index, package / inside, f"{manifest.sources} {inside}")
    (package / "__init__.py").write_text(f'"""Compiled kernels of {NAME}."""\n')
    (package / MANIFEST).write_bytes(msgspec.json.encode(manifest))
    tag = f"{_python_tag()}-none-{_platform()}"
    (project / "hatch_build.py").write_text(HOOK.format(tag=tag))
    fields = msgspec.structs.asdict(manifest)
    (project / "pyproject.toml").write_text(
        PROJECT.format(name=NAME, version=version(NAME), level=LEVEL, package=PACKAGE, **fields)
    )


def _copy(index: Path, folder: Path, source_stamp: str) -> None:
    """Copy what a kernel was compiled to for the level, without what the cache has for other processors."""
    folder.mkdir(parents=True, exist_ok=True)
    found = KernelIndex(str(index.parent), index.stem, source_stamp, alone=True)
    copied = KernelIndex(str(folder), index.stem, source_stamp, alone=True)
    files = {key: name for key, name in found.entries().items() if key[1][1:] == (LEVEL, "")}
    copied.write_entries(files)
    for name in set(files.values()):
        shutil.copyfile(index.parent / name, folder / name)


def _python_tag() -> str:
    return f"cp{sys.version_info.major}{sys.version_info.minor}"


def _platform() -> str:
    """Return the platform tag of the installed numba, without which compiled kernels are of no use."""
    lines: Iterable[str] = (distribution("numba").read_text("WHEEL") or "").splitlines()
    tags = [line.partition(":")[2].strip() for line in lines if line.startswith("Tag:")]
    return tags[0].rpartition("-")[2]
