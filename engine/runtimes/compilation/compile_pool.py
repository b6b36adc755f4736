"""Compiles kernels into the cache on all processors, in processes that end with this one.

One process at a time compiles into a cache: the others wait for it, or for the modules that they need. Modules that
somebody waits for come first, at normal priority.
"""

import contextlib
import gc
import importlib
import logging
import multiprocessing
import os
import threading
import time
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import resource_tracker
from pathlib import Path
from types import ModuleType

import msgspec

from engine.processes.imports import without_collection
from engine.processes.instances import name_semaphores, sweep_stale
from engine.runtimes.compilation import stamp, threading_layer
from engine.runtimes.compilation.stamp import ModuleNotes

logger = logging.getLogger(__name__)

LOOK = 0.25
"""Period at which marks of wanted modules, and notes of another compiler, are read [s]."""

LOWEST_PRIORITY = 19

_SPAWNING = multiprocessing.get_context("spawn")


class CompileReport(msgspec.Struct, frozen=True):
    """Progress of a compilation.

    Parameters
    ----------
    modules : tuple of str
        All kernel modules that are to be compiled.
    compiled, failed : tuple of str
        Those that are compiled, and those that cannot be.
    compiling : tuple of str
        Those that this process compiles now; empty if it waits for another one.
    """

    modules: tuple[str, ...]
    compiled: tuple[str, ...]
    failed: tuple[str, ...] = ()
    compiling: tuple[str, ...] = ()


Report = Callable[[CompileReport], None]


def compile_all(
    names: Callable[[], Iterable[str]] | list[str],
    notes: ModuleNotes,
    *,
    urgent: bool = True,
    report: Report = lambda _: None,
) -> list[str]:
    """Compile kernels, unless another process does so.

    Parameters
    ----------
    names : callable or list of str
        Names of the kernel modules, those that take longest first; or a function that returns them in any order. It is
        called in a separate process, so it must be picklable.
    notes : ModuleNotes
        Notes of the cache.
    urgent : bool
        Whether somebody waits for all of them; if not, those that nobody waits for are compiled at the lowest priority.
    report : callable
        Called with the progress, again and again.

    Returns
    -------
    list of str
        Index files of the compiled kernels in the cache.

    Raises
    ------
    Exception
        The error of the first kernel that cannot be compiled, after all others are.
    """
    sweep_stale()  # semaphores of killed compilers
    name_semaphores()
    with contextlib.ExitStack() as stack:
        pools = {0: stack.enter_context(_pool(0))}
        modules = names if isinstance(names, list) else _largest_first(names)
        if urgent:
            notes.want(modules)
        while not notes.compiled().keys() >= set(modules):
            with notes.turn() as mine:
                if mine:
                    nice = 0 if urgent else LOWEST_PRIORITY
                    _Compilation(modules, notes, report, lambda at: _opened(pools, at, stack), nice=nice).run()
                    break
            report(CompileReport(tuple(modules), tuple(notes.compiled())))
            time.sleep(LOOK)
        report(CompileReport(tuple(modules), tuple(modules)))
    _end_tracker()
    return [file for module in modules for file in notes.compiled()[module]]


def _opened(pools: dict[int, ProcessPoolExecutor], nice: int, stack: contextlib.ExitStack) -> ProcessPoolExecutor:
    if nice not in pools:
        pools[nice] = stack.enter_context(_pool(nice))
    return pools[nice]


class _Compilation:
    """Compilation of modules by this process, while it is its turn."""

    def __init__(
        self,
        modules: list[str],
        notes: ModuleNotes,
        report: Report,
        pool_of: Callable[[int], ProcessPoolExecutor],
        *,
        nice: int,
    ) -> None:
        self._modules = modules
        self._notes = notes
        self._report = report
        self._pool_of = pool_of
        self._usual = nice
        self._most = len(os.sched_getaffinity(0))
        self._running: dict[Future[list[str]], tuple[str, int]] = {}
        self._failed: dict[str, BaseException] = {}

    def run(self) -> None:
        """Compile all modules; raise the error of the first that cannot be compiled."""
        while self._start_some() or self._running:
            ended, _ = wait(self._running, LOOK, FIRST_COMPLETED)
            for future in ended:
                self._note(future, self._running.pop(future)[0])
            missing = self._missing()
            now = tuple(sorted({module for module, _ in self._running.values()} & set(missing)))
            self._report(CompileReport(tuple(self._modules), tuple(self._notes.compiled()), tuple(self._failed), now))
            if not missing:
                break  # some may still be compiled for the second time
        for error in self._failed.values():
            raise error

    def _missing(self) -> list[str]:
        known = self._notes.compiled().keys() | self._failed.keys()
        return [module for module in self._modules if module not in known]

    def _start_some(self) -> bool:
        """Start to compile as many modules as there are processors at each priority; return whether some are missing.

        One that is compiled at low priority is begun again at normal priority as soon as somebody waits for it.
        """
        missing, wanted = self._missing(), self._notes.wanted()
        for nice, modules in ((0, [module for module in missing if module in wanted]), (self._usual, missing)):
            begun = {module for module, at in self._running.values() if at <= nice}
            free = self._most - sum(at == nice for _, at in self._running.values())
            for module in [module for module in modules if module not in begun][: max(free, 0)]:
                self._running[self._pool_of(nice).submit(_compile, module)] = module, nice
        return bool(missing)

    def _note(self, future: Future[list[str]], module: str) -> None:
        error = future.exception()
        if error is None:
            self._notes.note(module, future.result())
        elif isinstance(error, BrokenProcessPool):
            raise error  # a process was killed: the process that started this one starts it again
        else:
            logger.error("the kernels of %s cannot be compiled", module, exc_info=error)
            self._failed[module] = error


def _pool(nice: int) -> ProcessPoolExecutor:
    return ProcessPoolExecutor(len(os.sched_getaffinity(0)), _SPAWNING, _begin, (nice,))


def _end_tracker() -> None:
    """End the resource tracker of the pool.

    Otherwise it exits after this process and becomes a zombie of the process that adopts orphans: the agent.
    """
    gc.collect()  # resources that are released later would start it again
    resource_tracker._resource_tracker._stop()  # type: ignore[attr-defined]


def _begin(nice: int) -> None:
    _end_with_parent_soon()
    os.nice(nice)
    threading_layer.choose()
    with without_collection():
        importlib.import_module("numba")


def _end_with_parent_soon() -> None:
    """Exit as soon as the parent does: if that is killed, this process would wait for work for ever."""
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _largest_first(names: Callable[[], Iterable[str]]) -> list[str]:
    """Return the modules that have a ``warm`` function, the largest first: they take longest."""
    with ProcessPoolExecutor(1, _SPAWNING, _begin_to_look) as pool:
        return pool.submit(_warmable, names).result()


def _begin_to_look() -> None:
    """Prepare a process that imports kernel modules without compiling kernels whose argument types are declared."""
    from numba.core import config  # noqa: PLC0415 - most processes that import this module do not need it

    _end_with_parent_soon()
    config.DISABLE_JIT = True  # type: ignore[attr-defined]


def _warmable(names: Callable[[], Iterable[str]]) -> list[str]:
    modules = map(importlib.import_module, names())
    warmable = [module for module in modules if hasattr(module, "warm")]
    return [module.__name__ for module in sorted(warmable, key=_size, reverse=True)]


def _size(module: ModuleType) -> int:
    return Path(str(module.__file__)).stat().st_size


def _compile(name: str) -> list[str]:
    module = importlib.import_module(name)
    module.warm()
    return list(stamp.cache_files(module))
