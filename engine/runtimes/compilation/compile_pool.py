"""Compiles kernels into the cache on all processors, in processes that end with this one."""

import gc
import importlib
import multiprocessing
import os
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import resource_tracker
from pathlib import Path
from types import ModuleType

from engine.runtimes.compilation import stamp, threading_layer


def compile_all(names: Callable[[], Iterable[str]]) -> list[str]:
    """Compile kernels.

    Parameters
    ----------
    names : callable
        Returns the names of the kernel modules. It is called in a process of the pool, so it must be picklable.

    Returns
    -------
    list of str
        Index files of the compiled kernels in the cache.

    Raises
    ------
    Exception
        The error of a kernel that cannot be compiled.
    """
    spawning = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(len(os.sched_getaffinity(0)), spawning, _begin) as pool:
        modules = pool.submit(_largest_first, names).result()
        files = [file for files in pool.map(_compile, modules) for file in files]
    _end_tracker()
    return files


def _end_tracker() -> None:
    """End the resource tracker of the pool.

    Otherwise it exits after this process and becomes a zombie of the process that adopts orphans: the agent.
    """
    gc.collect()  # resources that are released later would start it again
    resource_tracker._resource_tracker._stop()  # type: ignore[attr-defined]


def _begin() -> None:
    """Prepare a process of the pool. It exits with its parent: if that is killed, it would wait for work for ever."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    threading_layer.choose()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _largest_first(names: Callable[[], Iterable[str]]) -> list[str]:
    """Return the modules that have a ``warm`` function, the largest first: they take longest."""
    modules = map(importlib.import_module, names())
    warmable = [module for module in modules if hasattr(module, "warm")]
    return [module.__name__ for module in sorted(warmable, key=_size, reverse=True)]


def _size(module: ModuleType) -> int:
    return Path(str(module.__file__)).stat().st_size


def _compile(name: str) -> list[str]:
    module = importlib.import_module(name)
    module.warm()
    return list(stamp.cache_files(module))
