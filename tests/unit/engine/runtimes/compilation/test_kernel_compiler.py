"""The kernel compiler of a machine is kept running, and what it has compiled is known; other kernels are called."""

import subprocess
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import msgspec
import pytest

from engine.processes.disk_notes import exclusive
from engine.runtimes.compilation import kernel_compiler, rest_compiler
from engine.runtimes.compilation.compile_pool import CompileReport
from engine.runtimes.compilation.kernel_compiler import KernelCompiler
from engine.runtimes.compilation.kernel_modules import loaded, warm_loaded
from tests.support.engine.processes import is_gone
from tests.support.sources import ROOT
from tests.support.waiting import patience, until

NONE, ONE = CompileReport(("one", "two"), ()), CompileReport(("one", "two"), ("one",))
BOTH = CompileReport(("one", "two"), ("one", "two"))

RUN = """
import os, sys, time
with open({starts!r}, "a") as starts:
    starts.write(str(os.getpid()) + " ")
number = len(open({starts!r}).read().split())
def report(line):
    print(line, flush=True)
"""
"""Beginning of a compiler: it notes its process id."""


@asynccontextmanager
async def running(monkeypatch: pytest.MonkeyPatch, folder: Path, script: str) -> AsyncIterator[KernelCompiler]:
    """Run a compiler that executes a script."""
    monkeypatch.setattr(kernel_compiler, "PAUSE", 0.0)
    script = RUN.format(starts=str(folder / "starts")) + script
    monkeypatch.setattr(rest_compiler, "COMMAND", (sys.executable, "-c", script))
    compiler = KernelCompiler()
    compiler.begin()
    compiler.begin()
    try:
        yield compiler
    finally:
        await compiler.close()


def line(report: CompileReport) -> str:
    return f"report({msgspec.json.encode(report).decode()!r})\n"


def starts(folder: Path) -> list[int]:
    file = folder / "starts"
    return [int(pid) for pid in file.read_text().split()] if file.exists() else []


async def test_it_ends_with_its_owner(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    async with running(monkeypatch, tmp_path, "time.sleep(600)"):
        await until(lambda: len(starts(tmp_path)) == 1)
    assert is_gone(starts(tmp_path)[0])


async def test_whoever_waits_for_a_module_goes_on_once_it_is_compiled(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    script = line(NONE) + "asked = sys.stdin.readline()\n" + line(ONE) + "time.sleep(600)"
    async with running(monkeypatch, tmp_path, script) as compiler:
        await until(lambda: compiler.report is not None)
        assert compiler.missing(["one", "no_kernels"]) == {"one"}
        async with patience(30):
            await compiler.until_compiled(["one", "no_kernels"])
        assert compiler.missing(["one", "two"]) == {"two"}


async def test_modules_are_asked_for_by_name(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    script = line(NONE) + f"open({str(tmp_path / 'asked')!r}, 'w').write(sys.stdin.readline())\n" + line(BOTH)
    async with running(monkeypatch, tmp_path, script) as compiler:
        async with patience(30):
            await compiler.until_compiled(["two"])
        assert (tmp_path / "asked").read_text() == '["two"]\n'


async def test_a_killed_one_is_started_again_and_asked_again(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    script = (
        line(ONE)
        + "asked = sys.stdin.readline()\nif number == 1: os.kill(os.getpid(), 9)\n"
        + line(BOTH)
        + "sys.exit(0)"
    )
    async with running(monkeypatch, tmp_path, script) as compiler:
        async with patience(30):
            await compiler.until_compiled(["two"])
        await until(lambda: compiler.is_over)
    assert len(starts(tmp_path)) == 2


async def test_one_that_fails_again_and_again_is_given_up(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async with running(monkeypatch, tmp_path, "sys.exit(3)") as compiler:
        async with patience(60):
            await compiler.until_compiled(["one"])
        assert compiler.is_over
    assert len(starts(tmp_path)) == kernel_compiler.ATTEMPTS
    assert "status 3" in caplog.text


async def test_nobody_waits_for_a_module_that_cannot_be_compiled(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    failed = CompileReport(("one", "two"), ("one",), failed=("two",))
    async with running(monkeypatch, tmp_path, line(failed) + "sys.exit(1)") as compiler:
        async with patience(30):
            await compiler.until_compiled(["two"])
        await until(lambda: compiler.is_over)
    assert len(starts(tmp_path)) == 1


async def test_nothing_is_missing_if_the_process_has_nothing_to_do(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    async with running(monkeypatch, tmp_path, "sys.exit(0)") as compiler:
        assert compiler.missing(["one"]) == {"one"}  # it is not known yet
        async with patience(30):
            await compiler.until_compiled(["one"])
        assert compiler.report is None


PREPARE = """
from engine.runtimes.compilation import kernel_compiler
from engine.runtimes.compilation import kernel_modules

recorder = kernel_modules.record_compilations()
kernel_compiler.prepare()
print(len(recorder.buffer))
"""


def compiled_by_another_process() -> int:
    """Prepare in a separate process; return the number of kernels that it compiled."""
    command = [sys.executable, "-c", PREPARE]
    result = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True, timeout=120)
    return int(result.stdout)


def test_compiled_kernels_are_loaded_without_waiting_for_a_compiler() -> None:
    compiled_by_another_process()
    with exclusive(kernel_compiler.stamp_of_stores().with_suffix(".lock")):
        assert compiled_by_another_process() == 0


def dispatchers(module):
    return [found for found in vars(module).values() if hasattr(found, "signatures") and hasattr(found, "py_func")]


def test_imported_modules_are_warmed_and_compiled(monkeypatch):
    import ppaas.localization.kernels
    from ppaas.maps.kernels import distance

    for module in loaded():
        if module not in (distance, ppaas.localization.kernels):
            monkeypatch.delitem(sys.modules, module.__name__)
    assert loaded() == [ppaas.localization.kernels, distance]
    warm_loaded()
    assert any(kernel.signatures for kernel in dispatchers(distance))
