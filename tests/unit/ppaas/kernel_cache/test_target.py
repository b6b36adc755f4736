"""The processor that kernels are compiled for, by what the computer has and the environment asks for."""

import os
import subprocess
import sys

import pytest
from llvmlite import binding

from ppaas.kernel_cache import target

ALL = dict.fromkeys(target._OF_LEVEL, True)


@pytest.fixture(autouse=True)
def _nothing_given(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(target.NAME, raising=False)
    monkeypatch.delenv(target.FEATURES, raising=False)


def of_host(monkeypatch: pytest.MonkeyPatch, features: dict[str, bool]) -> None:
    """Replace this computer by one with these features."""
    monkeypatch.setattr(binding, "get_host_cpu_features", lambda: binding.targets.FeatureMap(features))
    monkeypatch.setattr(binding, "get_host_cpu_name", lambda: "host")


def test_kernels_are_compiled_for_the_level(monkeypatch: pytest.MonkeyPatch) -> None:
    of_host(monkeypatch, ALL | {"avx512f": True})
    assert target.compile_target() == ("x86-64-v3", "")


@pytest.mark.parametrize("lacking", target._OF_LEVEL)
def test_a_processor_below_the_level_is_the_target_itself(monkeypatch: pytest.MonkeyPatch, lacking: str) -> None:
    of_host(monkeypatch, ALL | {lacking: False})
    name, features = target.compile_target()
    assert name == "host"
    assert f"-{lacking}" in features.split(",")


def test_the_environment_selects_the_target(monkeypatch: pytest.MonkeyPatch) -> None:
    of_host(monkeypatch, ALL)
    monkeypatch.setenv(target.NAME, "skylake")
    assert target.compile_target()[0] == "skylake"
    monkeypatch.setenv(target.NAME, "generic")
    assert target.compile_target() == ("generic", "")
    monkeypatch.setenv(target.FEATURES, "+avx2")
    assert target.compile_target() == ("generic", "+avx2")
    before = dict(os.environ)
    target.export_target()
    assert dict(os.environ) == before


def of_numba(program: str, **environment: str) -> str:
    """Return the processor for which numba compiles a kernel in a new process, after a line of Python."""
    code = f"""
{program}
from numba import njit
from numba.core.registry import cpu_target
njit(lambda: 0)()
print(cpu_target.target_context.codegen().magic_tuple()[1])
"""
    given = os.environ | environment
    return subprocess.run([sys.executable, "-c", code], env=given, check=True, capture_output=True, text=True).stdout


@pytest.mark.skipif(not target.has_level(), reason="wheels are for x86-64-v3")
@pytest.mark.parametrize(
    "program",
    [
        "import ppaas.planners.kernels",
        "import numba; import ppaas.planners.kernels",
        "from ppaas.kernel_cache import target; target.export_target()",
        "from engine.runtimes.compilation import threading_layer; threading_layer.choose()",
    ],
)
def test_numba_compiles_for_the_level(program: str) -> None:
    assert of_numba(program) == "x86-64-v3\n"


def test_another_target_stays() -> None:
    """One that is given, and that of a program which has compiled something before."""
    assert of_numba("import ppaas.planners.kernels", NUMBA_CPU_NAME="generic") == "generic\n"
    earlier = "import numba; numba.njit(lambda: 0)(); import ppaas.planners.kernels"
    assert of_numba(earlier) == f"{binding.get_host_cpu_name()}\n"
