"""Kernels are compiled in the background, each once, those first that somebody waits for."""

import asyncio
import importlib
import io
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import msgspec
import psutil

import ppaas
from engine.processes.child_process import adopt_orphans
from engine.processes.instances import SHARED_MEMORY, name_of, sweep_stale
from engine.runtimes.compilation import rest_compiler
from engine.runtimes.compilation.compile_pool import CompileReport
from tests.support.engine.processes import has_ended
from tests.support.sources import ROOT
from tests.support.waiting import until


def pid_in(file: Path) -> int:
    """Return the process id in a file, or 0 if it is not complete yet."""
    text = file.read_text() if file.exists() else ""
    return int(text) if text.endswith(" ") else 0


def package_that(folder: Path, **warms: str) -> None:
    """Create a package of kernel modules, by their names; the ``warm`` of each runs a line of Python."""
    package = folder / "ppaas" / "kernels"
    package.mkdir(parents=True)
    (folder / "ppaas" / "__init__.py").write_text("")
    for imported in ("decoding.py", "kernel_cache"):  # by the compiler
        (folder / "ppaas" / imported).symlink_to(ROOT / "ppaas" / imported)
    (package / "__init__.py").write_text("")
    for name, warm in warms.items():
        (package / f"{name}.py").write_text(
            f"import os, time\nfrom numba import njit\n\n@njit(cache=True)\ndef one():\n    return 1\n\n"
            f"def warm():\n    one()\n    {warm}\n"
        )


async def compiler_of(folder: Path, *, processors: int = 2) -> asyncio.subprocess.Process:
    """Start a compiler of the kernels of that package, with its own cache; it reports to this process."""
    script = (
        "import os, sys\n"
        "import engine.processes.background\n"
        "from engine.runtimes.compilation import compile_pool, stamp, threading_layer\n"
        "compile_pool.LOWEST_PRIORITY = 1\n"  # at the lowest it may wait for minutes beside other tests
        f"os.sched_getaffinity = lambda _: set(range({processors}))\n"
        "for name in [name for name in sys.modules if name.split('.')[0] == 'ppaas']: del sys.modules[name]\n"
        f"sys.path.insert(0, {str(folder)!r})\n"
        "import engine.runtimes.compilation.rest_compiler as compiler\n"
        "compiler.main()\n"
    )
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder / "cache")}
    command, pipe = (sys.executable, "-c", script, str(os.getpid())), asyncio.subprocess.PIPE
    return await asyncio.create_subprocess_exec(*command, env=environment, stdin=pipe, stdout=pipe)


def held_by(file: Path) -> str:
    """Return a line of Python that waits until a file is gone."""
    return f"[time.sleep(0.05) for _ in iter(lambda: os.path.exists({str(file)!r}), False)]"


async def reports_of(compiler: asyncio.subprocess.Process) -> list[CompileReport]:
    """Return all reports of a compiler, once it has ended."""
    output, _ = await compiler.communicate()
    return [msgspec.json.decode(line, type=CompileReport) for line in output.splitlines()]


def test_kernels_of_all_packages_are_found() -> None:
    """A module that has a function to compile it, and kernels, is found by its text."""
    found = rest_compiler._modules(Path(ppaas.__path__[0]))
    assert {"maps", "costmap", "planners", "controllers", "localization"} <= {name.split(".")[1] for name in found}
    assert all(hasattr(importlib.import_module(name), "warm") for name in found)


async def test_two_compilers_compile_each_kernel_once(tmp_path: Path) -> None:
    """Both processes see the same cache."""
    calls = tmp_path / "calls"
    package_that(tmp_path, one=f"open({str(calls)!r}, 'a').write('warm ')")
    processes = [await compiler_of(tmp_path) for _ in range(2)]
    assert [await process.wait() for process in processes] == [0, 0]
    assert calls.read_text() == "warm "


async def test_a_compiler_leaves_no_orphans(tmp_path: Path) -> None:
    package_that(tmp_path, one="pass")
    before = {child.pid for child in psutil.Process().children()}
    adopt_orphans(True)
    try:
        compiler = await compiler_of(tmp_path)
        assert await compiler.wait() == 0
        assert {child.pid for child in psutil.Process().children()} <= before
    finally:
        adopt_orphans(False)


async def test_the_pool_of_a_killed_compiler_exits_as_well(tmp_path: Path) -> None:
    begun = tmp_path / "begun"
    package_that(tmp_path, one=f"open({str(begun)!r}, 'w').write(f'{{os.getpid()}} '); time.sleep(600)")
    compiler = await compiler_of(tmp_path)
    await until(lambda: pid_in(begun) > 0)
    helpers = [child.pid for child in psutil.Process(compiler.pid).children(recursive=True)]
    assert pid_in(begun) in helpers
    compiler.kill()
    await compiler.wait()
    await until(lambda: all(map(has_ended, helpers)))


async def test_semaphores_of_a_compiler_killed_with_its_resource_tracker_are_swept(tmp_path: Path) -> None:
    begun = tmp_path / "begun"
    package_that(tmp_path, one=f"open({str(begun)!r}, 'w').write(f'{{os.getpid()}} '); time.sleep(600)")
    compiler = await compiler_of(tmp_path)
    await until(lambda: pid_in(begun) > 0)
    every = [psutil.Process(compiler.pid), *psutil.Process(compiler.pid).children(recursive=True)]
    semaphores = set(SHARED_MEMORY.glob(f"sem.ppaas-{name_of(compiler.pid)}-*"))
    for process in every:
        process.suspend()  # otherwise one may clean up after another
    for process in every:
        process.kill()
    await compiler.wait()
    await until(lambda: all(has_ended(process.pid) for process in every))
    assert semaphores and semaphores <= set(sweep_stale())


async def test_reports_name_what_is_compiled_of_all(tmp_path: Path) -> None:
    package_that(tmp_path, one="pass", two="pass")
    reports = await reports_of(await compiler_of(tmp_path))
    both = {"ppaas.kernels.one", "ppaas.kernels.two"}
    assert all(set(report.modules) == both for report in reports)
    assert set(reports[-1].compiled) == both
    assert reports[-1].compiling == ()


def test_people_read_the_progress_in_steps_and_its_end() -> None:
    output, modules = io.BytesIO(), tuple(f"ppaas.kernels.{number}" for number in range(23))
    progress = rest_compiler._Progress(output)
    for done in range(24):
        progress(CompileReport(modules, modules[:done]))
    counts = [line.split()[1] for line in output.getvalue().decode().splitlines()]
    assert counts == ["9", "19", "23"]


async def test_a_module_that_cannot_be_compiled_does_not_keep_others_from_it(tmp_path: Path) -> None:
    package_that(tmp_path, one="raise ValueError('of a kernel')", two="pass")
    compiler = await compiler_of(tmp_path)
    reports = await reports_of(compiler)
    assert compiler.returncode == 1
    assert (reports[-1].failed, reports[-1].compiled) == (("ppaas.kernels.one",), ("ppaas.kernels.two",))


async def test_a_killed_compiler_is_continued_with_what_is_missing(tmp_path: Path) -> None:
    calls, waits = tmp_path / "calls", tmp_path / "waits"
    call = f"open({str(calls)!r}, 'a').write(__name__[-5:] + ' ')"
    waits.touch()
    package_that(
        tmp_path,
        first=call,
        other=f"{call}; {held_by(waits)}",
    )
    compiler = await compiler_of(tmp_path)
    notes = tmp_path / "cache"
    await until(lambda: bool(list(notes.rglob("ppaas.kernels.first.json"))))
    compiler.kill()
    await compiler.wait()
    waits.unlink()
    reports = await reports_of(await compiler_of(tmp_path))
    assert len(reports[-1].compiled) == 2
    assert calls.read_text().split().count("first") == 1


async def test_modules_that_somebody_waits_for_come_first(tmp_path: Path) -> None:
    """The largest is compiled first otherwise."""
    calls, begun, waits = tmp_path / "calls", tmp_path / "begun", tmp_path / "waits"
    waits.touch()
    call = f"open({str(calls)!r}, 'a').write(__name__ + ' ')"
    wait = f"open({str(begun)!r}, 'w'); {held_by(waits)}"
    package_that(tmp_path, largest=f"{call}; {wait}", second=f"{call}; {'1; ' * 30}1", third=call)
    compiler = await compiler_of(tmp_path, processors=1)
    await until(begun.exists)
    assert compiler.stdin is not None
    compiler.stdin.write(b'["ppaas.kernels.third"]\n')
    await until(lambda: "third" in calls.read_text())
    assert "second" not in calls.read_text()
    waits.unlink()
    await reports_of(compiler)
    assert [name.rpartition(".")[2] for name in calls.read_text().split()] == ["largest", "third", "second"]


def test_the_docker_image_contains_the_imports_of_the_compiler(tmp_path: Path) -> None:
    stage = (ROOT / "docker" / "engine.Dockerfile").read_text().partition(" AS kernels\n")[2].partition("\nFROM ")[0]
    for source, target in re.findall(r"^COPY (\S+) (\S+)$", stage, re.MULTILINE):
        if source.endswith(".py"):
            (tmp_path / target).mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / source, tmp_path / target)
        else:
            shutil.copytree(ROOT / source, tmp_path / target, ignore=shutil.ignore_patterns("__pycache__"))
    (module,) = re.findall(r"python -m (\S+)$", stage, re.MULTILINE)
    imported = (
        f"import sys; sys.path[:] = [{str(tmp_path)!r}, *(path for path in sys.path if path != {str(ROOT)!r})]; "
        f"import {module} as compiler; print(compiler.__file__)"
    )
    done = subprocess.run([sys.executable, "-P", "-c", imported], capture_output=True, text=True, check=False, cwd="/")
    assert done.stdout.startswith(str(tmp_path)), done.stderr
