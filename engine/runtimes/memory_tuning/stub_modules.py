"""Stub modules: replace modules that numba and uvloop always import and hardly use, which saves 3 MB.

numba renders code as HTML, and accepts two classes of numpy as arguments of kernels: masked arrays, which it refuses,
and polynomials. uvloop imports TLS, which is not used in a container. While they import such a module they get a stub;
later imports get the real module.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType, SimpleNamespace

from engine.runtimes.memory_tuning.switch import LEAN

UNUSED_EXTRAS = ("_hashlib", "cffi", "scipy", "ssl", "typing_extensions", "yaml")
"""Optional modules that numba, msgspec and the standard library import if they are installed.

We do not use the features that need them, and they take 14 MB. Without OpenSSL, hashlib uses its own implementations,
and asyncio has no TLS: a container only talks to its machine.
"""

HTML, MASKED, POLYNOMIAL, TLS = "html", "numpy.ma", "numpy.polynomial", "ssl"
_TLS_ERRORS = ("CertificateError", "SSLError", "SSLSyscallError", "SSLWantReadError", "SSLZeroReturnError")

_CONTENT: dict[str, dict[str, object]] = {
    HTML: {},
    MASKED: {"MaskedArray": type("MaskedArray", (), {})},
    POLYNOMIAL: {"polynomial": SimpleNamespace(Polynomial=type("Polynomial", (), {}))},
    TLS: {name: type(name, (OSError,), {}) for name in _TLS_ERRORS}
    | {name: type(name, (), {}) for name in ("MemoryBIO", "SSLContext", "create_default_context")}
    | {"SSL_ERROR_WANT_READ": 2, "SSL_ERROR_WANT_WRITE": 3, "SSL_ERROR_SYSCALL": 5},
}


@contextmanager
def without_extras() -> Iterator[None]:
    """Hide the unused extras from imports; afterwards they can be imported again, as by a plug-in that needs them."""
    hidden = [name for name in UNUSED_EXTRAS if LEAN and name not in sys.modules]
    sys.modules.update(dict.fromkeys(hidden))  # type: ignore[arg-type]  # None hides it from the import system
    try:
        yield
    finally:
        for name in hidden:
            if sys.modules.get(name, name) is None:
                del sys.modules[name]


@contextmanager
def stubbed(*names: str) -> Iterator[None]:
    """Put stubs in place of modules that are not imported yet; a module that was hidden is hidden again afterwards.

    Parameters
    ----------
    *names : str
        Names of modules, out of the four of this module. The stub for polynomials is enough to import numba, but not to
        compile kernels.
    """
    stubs = [_Stub(name) for name in names if LEAN and sys.modules.get(name) is None]
    try:
        yield
    finally:
        for stub in stubs:
            stub.remove()


class _Stub:
    def __init__(self, name: str) -> None:
        self._module = ModuleType(name)
        vars(self._module).update(_CONTENT[name])
        parent, _, self._own_name = name.rpartition(".")
        self._was_hidden = name in sys.modules
        self._parent = sys.modules.get(parent)  # after an import, a module is an attribute of its package
        sys.modules[name] = self._module
        if self._parent is not None:
            setattr(self._parent, self._own_name, self._module)

    def remove(self) -> None:
        name = self._module.__name__
        if sys.modules.get(name) is self._module:
            del sys.modules[name]
            if self._was_hidden:
                sys.modules[name] = None  # type: ignore[assignment]  # hides it from the import system
        if self._parent is not None and getattr(self._parent, self._own_name) is self._module:
            delattr(self._parent, self._own_name)
