"""Loads cached kernels without numba's compiler.

Three changes to numba's loader, by which a kernel that is in the cache takes less memory:

- Before numba reads its cache it initializes its whole compiler, which takes a quarter of a second and 10 MB of the
  memory that all containers share. Compiled code only needs numba's runtime.
- With the code comes LLVM bitcode, for kernels that are compiled later and call this one. numba unpacks it to 6 MB of
  objects. Here it is written to a file without a name, and read when another kernel is linked with it. It cannot be
  read from the cache again: another process may have compiled the same kernel meanwhile, under other symbol names.
- A kernel names the modules of numba that its parts were written in, and numba imports them: 5 MB more. Only code that
  runs as Python reads them.

A kernel that is not in the cache is compiled as usual: numba then initializes its compiler and reads the bitcode.

Without docstrings (``-OO``) the bytecode of a function may differ, and numba's cache keys contain the bytecode. A
kernel that was compiled with docstrings is loaded all the same: an index file belongs to one function of one source
file.
"""

import errno
import functools
import os
import sys
import tempfile
from collections.abc import Callable
from typing import IO, Any

import llvmlite.binding as llvm
from numba.core import environment
from numba.core.base import BaseContext
from numba.core.caching import Cache, IndexDataCacheFile
from numba.core.codegen import CPUCodeLibrary
from numba.core.runtime.nrt import rtsys

from engine.runtimes.memory_tuning.switch import LEAN


def load_without_compiler() -> None:
    """Make numba load its compiler only when it compiles. Call it before any kernel is called; again does nothing."""
    loading: Callable[..., Any] = Cache.load_overload
    if not LEAN or hasattr(loading, "__wrapped__"):
        return

    @functools.wraps(loading)
    def load_overload(cache: Cache, signature: Any, context: BaseContext) -> Any:
        vars(context)["refresh"] = functools.partial(rtsys.initialize, context)
        try:
            loaded = loading(cache, signature, context)
        finally:
            vars(context).pop("refresh", None)  # another thread may have removed it
        if loaded is None:
            return None
        return loaded._replace(type_annotation="", metadata={})  # its documentation is not used here

    Cache.load_overload = load_overload  # type: ignore[method-assign]
    CPUCodeLibrary._unserialize = classmethod(_without_bitcode)  # type: ignore[method-assign,assignment]
    if sys.flags.optimize > 1:
        IndexDataCacheFile.load = _load_documented_too  # type: ignore[method-assign]
    environment._rebuild_env = _environment_without_module


_with_module = environment._rebuild_env


def _environment_without_module(module: str, constants: list[Any], name: str) -> environment.Environment:
    """Return the run-time environment of a part of a kernel, without importing its module of numba."""
    known = environment.lookup_environment(name)  # type: ignore[no-untyped-call]
    if known is not None or module in sys.modules or not module.startswith("numba."):
        return _with_module(module, constants, name)  # type: ignore[no-any-return, no-untyped-call]
    made = environment.Environment({"__name__": module})
    made.consts[:] = constants
    made.env_name = name
    environment.Environment._memo[name] = made
    return made


_load: Callable[..., Any] = IndexDataCacheFile.load


def _load_documented_too(file: IndexDataCacheFile, key: tuple[Any, Any, tuple[str, str]]) -> Any:
    """Return the cache entry of a signature, target and closure, for any bytecode."""
    found = _load(file, key)
    if found is not None:
        return found
    signature, target, (_, closure) = key
    documented = (
        other
        for other in file._load_index()  # type: ignore[no-untyped-call]
        if other[0] == signature and other[1] == target and other[2][1] == closure
    )
    return next((found for other in documented if (found := _load(file, other)) is not None), None)


_unserialize: Callable[..., CPUCodeLibrary] = CPUCodeLibrary._unserialize.__func__  # type: ignore[attr-defined]


def _without_bitcode(kind: type[CPUCodeLibrary], codegen: Any, state: tuple[str, str, Any]) -> CPUCodeLibrary:
    """Return a library that reads its bitcode only when another library is linked with it."""
    library = _unserialize(kind, codegen, state)
    module: llvm.ModuleRef | None = library._shared_module
    if module is None:
        return library
    _, bitcode = state[2]
    try:
        read_back = _spill_file.put(bitcode)
    except OSError:  # no disk space: the bitcode stays in memory
        return library

    def read() -> llvm.ModuleRef:
        library._shared_module = llvm.parse_bitcode(read_back())
        del vars(library)["_get_module_for_linking"]
        return library._shared_module

    library._shared_module = None
    vars(library)["_get_module_for_linking"] = read
    module.close()
    return library


class _SpillFile:
    """A file without a name, which the system removes with the last process that has it open."""

    def __init__(self) -> None:
        self._file: IO[bytes] | None = None
        os.register_at_fork(after_in_child=self._begin_another)

    def put(self, content: bytes) -> Callable[[], bytes]:
        """Append bytes to the file; return a function that reads them, here and in processes forked from this one."""
        if self._file is None:
            self._file = tempfile.TemporaryFile(buffering=0)  # noqa: SIM115  # open as long as this process
        file, begin, size = self._file, self._file.seek(0, os.SEEK_END), len(content)
        if file.write(content) < size:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return lambda: os.pread(file.fileno(), size, begin)  # must not hold a reference to the content

    def _begin_another(self) -> None:
        self._file = None  # parent and child would write to the same offset


_spill_file = _SpillFile()
