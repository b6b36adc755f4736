"""Kernels of an installed wheel are used if this process would compile the same; otherwise they are ignored."""

import json
import os
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from ppaas.kernel_cache.shipped import MANIFEST, PACKAGE
from ppaas.kernel_cache.target import has_level
from tests.unit.ppaas.kernel_cache.kernel_package import ASK, LOWER, package_of

pytestmark = pytest.mark.skipif(not has_level(), reason="wheels are for x86-64-v3")

BUILD = """
import sys
from pathlib import Path
import ppaas
ppaas.__path__.insert(0, {folder!r})
from engine.runtimes.compilation import kernel_wheel, stamp
from engine.runtimes.compilation.stamp import ModuleNotes
from ppaas.room.kernels import lower, upper
upper.upper(1)
notes = ModuleNotes(stamp.stamp_file(Path({folder!r}), kernel_wheel.LAYER))
for module in (lower, upper):
    notes.note(module.__name__, stamp.cache_files(module))
print(kernel_wheel.build_wheel(Path(sys.argv[1])))
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a wheel of the kernels of the test package, compiled in another folder."""
    folder = tmp_path_factory.mktemp("elsewhere")
    command = [sys.executable, "-c", BUILD.format(folder=str(package_of(folder))), str(folder / "wheels")]
    environment = os.environ | {"NUMBA_CACHE_DIR": str(folder / "cache")}
    printed = subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout
    return Path(printed.strip())


@pytest.fixture
def ask(wheel: Path, tmp_path: Path) -> Callable[..., str]:
    """Return a function that calls a kernel with that wheel installed: its result, and the number of cache hits."""
    folder, site = package_of(tmp_path), tmp_path / "site"
    with zipfile.ZipFile(wheel) as files:
        files.extractall(site)

    def call(**environment: str) -> str:
        command = [sys.executable, "-c", ASK.format(folder=str(folder))]
        own = {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(site)}
        given = os.environ | own | environment
        return subprocess.run(command, env=given, check=True, capture_output=True, text=True).stdout

    return call


def test_a_wheel_names_what_it_fits(wheel: Path) -> None:
    """Installers choose by the tag and the requirements."""
    name, _, python, abi, platform = wheel.stem.split("-")
    assert (name, abi) == ("ppaas_cloud_kernels", "none")
    assert python == f"cp{sys.version_info.major}{sys.version_info.minor}"
    assert platform.startswith("manylinux") and platform.endswith("x86_64")
    with zipfile.ZipFile(wheel) as files:
        metadata = next(files.read(file).decode() for file in files.namelist() if file.endswith("METADATA"))
    assert {"numba", "llvmlite", "ppaas-cloud"} <= {
        line.split(": ")[1].partition("==")[0] for line in metadata.splitlines() if line.startswith("Requires-Dist")
    }


def test_nothing_is_compiled_with_a_wheel(ask: Callable[..., str], tmp_path: Path) -> None:
    assert ask() == "2 1\n"
    assert not list((tmp_path / "cache").rglob("*.nb?"))


def test_a_wheel_of_other_sources_is_ignored(ask: Callable[..., str], tmp_path: Path) -> None:
    (tmp_path / "ppaas" / "room" / "kernels" / "lower.py").write_text(LOWER.format(step=2))
    assert ask() == "3 0\n"
    assert ask() == "3 1\n", "what was compiled here is in the cache"


def test_a_wheel_is_ignored_if_another_processor_is_asked_for(ask: Callable[..., str]) -> None:
    assert ask(NUMBA_CPU_NAME="generic") == "2 0\n"


@pytest.mark.parametrize("field", ["python", "numba", "llvmlite"])
def test_a_wheel_of_other_versions_is_ignored(ask: Callable[..., str], tmp_path: Path, field: str) -> None:
    file = tmp_path / "site" / PACKAGE / MANIFEST
    file.write_text(json.dumps(json.loads(file.read_text()) | {field: "0.1"}))
    assert ask() == "2 0\n"


@pytest.mark.parametrize("damaged", [b"", b"{}"])
def test_a_damaged_manifest_is_ignored(ask: Callable[..., str], tmp_path: Path, damaged: bytes) -> None:
    (tmp_path / "site" / PACKAGE / MANIFEST).write_bytes(damaged)
    assert ask() == "2 0\n"


@pytest.mark.parametrize("suffix", [".nbi", ".nbc"])
@pytest.mark.parametrize("left", [None, 40])
def test_a_kernel_whose_files_are_missing_or_cut_is_compiled(
    ask: Callable[..., str], tmp_path: Path, suffix: str, left: int | None
) -> None:
    """Once: what is compiled here is preferred from then on."""
    for file in (tmp_path / "site").rglob(f"upper*{suffix}"):
        content = file.read_bytes()
        file.unlink()
        if left is not None:
            file.write_bytes(content[:left])
    assert ask() == "2 0\n"
    assert ask() == "2 1\n"
