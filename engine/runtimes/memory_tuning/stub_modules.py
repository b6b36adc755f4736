"""Keeps from memory what numba and uvloop load in any case and hardly use, 3 MB of it.

numba makes pictures of code as HTML, and knows two classes of numpy as arguments of kernels: masked arrays, which it
refuses, and polynomials. uvloop looks for TLS, which nobody speaks in a container. While one of them looks for such a
module it is shown an empty one; who asks later gets the real one.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType, SimpleNamespace

from engine.runtimes.memory_tuning.switch import LEAN

UNUSED_EXTRAS = ("_hashlib", "cffi", "scipy", "ssl", "typing_extensions", "yaml")
"""What numba, msgspec and Python's own library load where it is installed. Nothing of ours needs them for it, and they
take 14 MB. Without OpenSSL Python makes sums by itself, and asyncio has no TLS: a container speaks to its machine only.
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
    """Let nothing load the unused extras; afterwards everything may, such as a plug-in that needs them itself."""
    hidden = [name for name in UNUSED_EXTRAS if LEAN and name not in sys.modules]
    sys.modules.update(dict.fromkeys(hidden))  # type: ignore[arg-type]  # None: the import system finds no such module
    try:
        yield
    finally:
        for name in hidden:
            if sys.modules.get(name, name) is None:
                del sys.modules[name]


@contextmanager
def stubbed(*names: str) -> Iterator[None]:
    """Show stand-ins for modules, as far as they are not loaded yet; one that is kept from being loaded remains so.

    Parameters
    ----------
    *names : str
        Of the four of this module. That for polynomials is enough to import numba and not to compile anything.
    """
    shown = [_Stub(name) for name in names if LEAN and sys.modules.get(name) is None]
    try:
        yield
    finally:
        for stand_in in shown:
            stand_in.hide()


class _Stub:
    """A stand-in that is found where the real module would be."""

    def __init__(self, name: str) -> None:
        self._module = ModuleType(name)
        vars(self._module).update(_CONTENT[name])
        parent, _, self._own_name = name.rpartition(".")
        self._kept_away = name in sys.modules
        self._parent = sys.modules.get(parent)  # an attribute of its package, once that was loaded
        sys.modules[name] = self._module
        if self._parent is not None:
            setattr(self._parent, self._own_name, self._module)

    def hide(self) -> None:
        name = self._module.__name__
        if sys.modules.get(name) is self._module:
            del sys.modules[name]
            if self._kept_away:
                sys.modules[name] = None  # type: ignore[assignment]  # so the import system finds no such module
        if self._parent is not None and getattr(self._parent, self._own_name) is self._module:
            delattr(self._parent, self._own_name)
