"""The remaining kernels are compiled in the background, once."""

import asyncio
import os
import re
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from engine.runtimes.compilation import rest_compiler
from engine.runtimes.compilation.rest_compiler import compiling_the_rest
from engine.runtimes.process.runtime import _adopt_orphans
from tests.support.engine.processes import has_ended, is_gone
from tests.support.sources import ROOT
from tests.support.waiting import until


@pytest.fixture
def begun(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the file in which a compiler that never ends writes its process id."""
    file = tmp_path / "begun"
    script = f"import os, time; open({str(file)!r}, 'w').write(str(os.getpid()) + ' '); time.sleep(600)"
    monkeypatch.setattr(rest_compiler, "COMMAND", (sys.executable, "-c", script))
    return file


def pid_in(file: Path) -> int:
    """Return the process id in a file, or 0 if it is not complete yet."""
    text = file.read_text() if file.exists() else ""
    return int(text) if text.endswith(" ") else 0


async def test_compiler_ends_with_its_context(begun: Path) -> None:
    async with compiling_the_rest():
        await until(lambda: pid_in(begun))
        assert not is_gone(pid_in(begun))
    assert is_gone(pid_in(begun))


async def test_a_compiler_that_fails_is_only_logged(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(rest_compiler, "COMMAND", (sys.executable, "-c", "raise SystemExit(3)"))
    async with compiling_the_rest():
        await until(lambda: "status 3" in caplog.text)


def package_that(folder: Path, warms: str) -> None:
    """Create a package of one kernel module whose ``warm`` runs a line of Python."""
    package = folder / "ppaas" / "kernels"
    package.mkdir(parents=True)
    (folder / "ppaas" / "__init__.py").write_text("")
    (package / "__init__.py").write_text("")
    (package / "one.py").write_text(
        f"import os, time\nfrom numba import njit\n\n@njit(cache=True)\ndef one():\n    return 1\n\n"
        f"def warm():\n    one()\n    {warms}\n"
    )


async def compiler_of(folder: Path) -> asyncio.subprocess.Process:
    """Start a compiler of the kernels of that package, with its own cache."""
    script = (
        "import os, sys\n"
        "os.nice = lambda _: 0\n"  # at low priority it may wait for minutes beside other tests
        "import engine.processes.background\n"
        "from engine.runtimes.compilation import stamp, threading_layer\n"
        "for name in [name for name in sys.modules if name.split('.')[0] == 'ppaas']: del sys.modules[name]\n"
        f"sys.path.insert(0, {str(folder)!r})\n"
        "import engine.runtimes.compilation.rest_compiler as compiler\n"
        "compiler.main()\n"
    )
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder / "cache")}
    return await asyncio.create_subprocess_exec(sys.executable, "-c", script, env=environment)


async def test_two_compilers_compile_each_kernel_once(tmp_path: Path) -> None:
    """Both processes see the same cache."""
    calls = tmp_path / "calls"
    package_that(tmp_path, f"open({str(calls)!r}, 'a').write('warm ')")
    processes = [await compiler_of(tmp_path) for _ in range(2)]
    assert [await process.wait() for process in processes] == [0, 0]
    assert calls.read_text() == "warm "


async def test_a_compiler_leaves_no_orphans(tmp_path: Path) -> None:
    package_that(tmp_path, "pass")
    before = {child.pid for child in psutil.Process().children()}
    _adopt_orphans(True)
    try:
        compiler = await compiler_of(tmp_path)
        assert await compiler.wait() == 0
        assert {child.pid for child in psutil.Process().children()} <= before
    finally:
        _adopt_orphans(False)


async def test_the_pool_of_a_killed_compiler_exits_as_well(tmp_path: Path) -> None:
    begun = tmp_path / "begun"
    package_that(tmp_path, f"open({str(begun)!r}, 'w').write(f'{{os.getpid()}} '); time.sleep(600)")
    compiler = await compiler_of(tmp_path)
    await until(lambda: pid_in(begun) > 0)
    helpers = [child.pid for child in psutil.Process(compiler.pid).children(recursive=True)]
    assert pid_in(begun) in helpers
    compiler.kill()
    await compiler.wait()
    await until(lambda: all(map(has_ended, helpers)))


def test_the_docker_image_contains_the_imports_of_the_compiler() -> None:
    print_all = (
        "import sys, engine.runtimes.compilation.rest_compiler\n"
        "print(*(name for name in sys.modules if name.startswith('engine.')))"
    )
    command = (sys.executable, "-c", print_all)
    loaded = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    stage = (ROOT / "docker/engine.Dockerfile").read_text().partition("AS kernels")[2].partition("\nRUN")[0]
    copied = [word for line in re.findall(r"^COPY (.*)", stage, re.MULTILINE) for word in line.split()[:-1]]
    files = {Path(*name.split(".")) for name in loaded}
    assert "engine/runtimes/compilation" in copied
    copies = {file: {f"{file}.py", f"{file}/__init__.py", *map(str, [file, *file.parents])} for file in files}
    assert not {file for file, may_be in copies.items() if not may_be & set(copied)}
