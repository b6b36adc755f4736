"""Kernels that are in the cache are loaded without what numba compiles with, and nothing of it is kept for them.

Before numba looks into its cache it loads all that it would compile with, which takes a quarter of a second and 10 MB
of the memory that all containers share. Only its runtime is needed for code that is compiled. With that code comes the
bitcode from which other kernels could be compiled, which numba unpacks to 6 MB of objects; it is read again where
something is linked with it. And a kernel names the modules of numba that its parts were written in, which only code
that runs as Python looks into: 5 MB more. What is not in the cache is compiled as ever: whatever compiles loads the
compiler itself, and reads what it asks for.

Bytecode may differ where Python leaves documentation out (``-OO``), and numba looks for a kernel by its bytecode too. A
kernel that was compiled with its documentation is taken all the same: an index is of one function of one source file.
"""

import functools
import sys
from collections.abc import Callable
from typing import Any

import llvmlite.binding as llvm
from numba.core import environment
from numba.core.base import BaseContext
from numba.core.caching import Cache, IndexDataCacheFile
from numba.core.codegen import CPUCodeLibrary
from numba.core.runtime.nrt import rtsys


def load_without_compiler() -> None:
    """Let numba load what it compiles with only when it compiles; call it once, before any kernel is called."""
    loading: Callable[..., Any] = Cache.load_overload

    @functools.wraps(loading)
    def load_overload(cache: Cache, signature: Any, context: BaseContext) -> Any:
        vars(context)["refresh"] = functools.partial(rtsys.initialize, context)
        try:
            loaded = loading(cache, signature, context)
        finally:
            del vars(context)["refresh"]
        if loaded is None:
            return None
        _leave_in_cache(loaded.library, cache, signature)
        return loaded._replace(type_annotation="", metadata={})  # what it tells of itself, for nobody here to read

    Cache.load_overload = load_overload  # type: ignore[method-assign]
    if sys.flags.optimize > 1:
        IndexDataCacheFile.load = _load_documented_too  # type: ignore[method-assign]
    environment._rebuild_env = _environment_without_module


_with_module = environment._rebuild_env


def _environment_without_module(module: str, constants: list[Any], name: str) -> environment.Environment:
    """Return what a part of a kernel takes at run time, without loading the module of numba that it was written in."""
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
    """Return what lies in the cache for a signature, target and closure, whatever the bytecode."""
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


def _leave_in_cache(library: CPUCodeLibrary, cache: Cache, signature: Any) -> None:
    """Let go of a library's bitcode, and read it again when something is linked with it."""
    module: llvm.ModuleRef = library._get_module_for_linking()  # type: ignore[no-untyped-call]

    def read() -> llvm.ModuleRef:
        key = cache._index_key(signature, library.codegen)  # type: ignore[no-untyped-call]
        found = cache._cache_file.load(key)  # type: ignore[no-untyped-call]
        if found is None:
            raise RuntimeError(f"kernels were taken from the cache or changed in it since {library.name}: start anew")
        (_, _, (_, bitcode)), *_ = found
        library._shared_module = llvm.parse_bitcode(bitcode)
        del vars(library)["_get_module_for_linking"]
        return library._shared_module

    library._shared_module = None
    vars(library)["_get_module_for_linking"] = read
    module.close()
