"""Threading layer of numba's parallel kernels, TBB or none, and the number of their threads.

Containers are forked from a process that has run kernels already, and they call kernels from several threads at once.
Of numba's three threading layers only *tbb* supports both: *omp* dies in the child, and *workqueue* aborts the process
as soon as two threads call kernels, even with one thread each. So where TBB cannot be loaded, ``parallel=True`` is
removed from every kernel before it is compiled: it runs serially, with the same result, on every platform.

Call ``choose`` before the first import of a kernel: so this module imports numba nowhere else than in functions.
"""

import contextlib
import ctypes
import functools
import importlib.util
import os
import sys
from collections.abc import Callable
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path
from typing import Any, Literal

from ppaas.kernel_cache.shipped import ignore_shipped
from ppaas.kernel_cache.target import export_target

Layer = Literal["tbb", "serial"]

_TBB = "libtbb.so.12"
_chosen: list[Layer] = []


def choose() -> Layer:
    """Configure numba for this process and its forks. Call it once, before any kernel is imported.

    Raises
    ------
    RuntimeError
        numba was imported before, so kernels may have been compiled already.
    """
    if "numba" in sys.modules:
        raise RuntimeError("numba is imported already; choose the threading layer before")
    # Without it numba would count the CPUs of a container's affinity at its next compilation, and refuse the change.
    os.environ["NUMBA_NUM_THREADS"] = str(len(os.sched_getaffinity(0)))
    export_target()
    if _load_tbb():
        os.environ["NUMBA_THREADING_LAYER"] = "tbb"
        _chosen.append("tbb")
    else:
        _run_serially()
        _chosen.append("serial")
    return _chosen[-1]


def chosen() -> Layer:
    """Return the layer that was chosen in this process, or in the process that it is forked from.

    Raises
    ------
    RuntimeError
        No layer was chosen.
    """
    if not _chosen:
        raise RuntimeError("no threading layer was chosen; call choose() before kernels are imported")
    return _chosen[-1]


def _load_tbb() -> bool:
    """Load TBB and numba's library that needs it, without numba, which takes a quarter of a second."""
    for path in (
        Path(sys.prefix, "lib", _TBB),
        Path(_TBB),
    ):  # PyPI's wheel puts it outside the search path of the loader
        with contextlib.suppress(OSError):
            ctypes.CDLL(str(path), mode=ctypes.RTLD_GLOBAL)
            for library in _numba_on_tbb():
                ctypes.CDLL(str(library))
                return True
    return False


def _numba_on_tbb() -> list[Path]:
    """Return numba's extension module for TBB, if this build of numba has it."""
    numba = importlib.util.find_spec("numba")
    places = (numba and numba.submodule_search_locations) or []
    return [
        file
        for place in places
        for suffix in EXTENSION_SUFFIXES
        if (file := Path(place, "np", "ufunc", f"tbbpool{suffix}")).exists()
    ]


def _run_serially() -> None:
    os.environ["NUMBA_NUM_THREADS"] = "1"
    # The default cache may contain code compiled for threads, and its keys do not distinguish the two.
    cache = os.environ.get("NUMBA_CACHE_DIR") or str(Path("~/.cache/ppaas").expanduser())
    os.environ["NUMBA_CACHE_DIR"] = str(Path(cache, "serial"))
    ignore_shipped()  # those are compiled for threads, too
    import numba  # noqa: PLC0415

    numba.njit = _without_parallel(numba.njit)
    numba.jit = _without_parallel(numba.jit)


def _without_parallel(decorator: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(decorator)
    def serial(*arguments: Any, **options: Any) -> Any:
        return decorator(*arguments, **(options | {"parallel": False} if "parallel" in options else options))

    return serial


def use_threads(threads: int) -> None:
    """Set the number of threads of the parallel kernels that the calling thread starts.

    Each thread that calls kernels must set it for itself. The number is limited to the CPUs of the machine, and to one
    where kernels run serially.
    """
    import numba  # noqa: PLC0415

    numba.set_num_threads(min(threads, vars(numba.config)["NUMBA_NUM_THREADS"]))


class KernelThreads:
    """Number of threads that the kernels of this container may use; it changes with the container's size.

    Parameters
    ----------
    count : int
        Number at the start.
    """

    def __init__(self, count: int) -> None:
        self.count = count

    def __call__(self) -> int:
        """Return the number, and set it for the kernels that the calling thread starts."""
        use_threads(self.count)
        return self.count
