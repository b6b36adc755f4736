"""Keeps from memory what numba loads in any case and hardly uses, 2 MB of it.

It makes pictures of code as HTML, and knows two classes of numpy as arguments of kernels: masked arrays, which it
refuses, and polynomials. While it looks for one of these modules it is shown an empty one; who asks later gets the
real one.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType, SimpleNamespace

HTML, MASKED, POLYNOMIAL = "html", "numpy.ma", "numpy.polynomial"

_CONTENT: dict[str, dict[str, object]] = {
    HTML: {},
    MASKED: {"MaskedArray": type("MaskedArray", (), {})},
    POLYNOMIAL: {"polynomial": SimpleNamespace(Polynomial=type("Polynomial", (), {}))},
}


@contextmanager
def instead_of(*names: str) -> Iterator[None]:
    """Show stand-ins for modules, as far as they are not loaded yet.

    Parameters
    ----------
    *names : str
        Of the three of this module. That for polynomials is enough to import numba and not to compile anything.
    """
    shown = [_Shown(name) for name in names if name not in sys.modules]
    try:
        yield
    finally:
        for stand_in in shown:
            stand_in.hide()


class _Shown:
    """A stand-in that is found where the real module would be."""

    def __init__(self, name: str) -> None:
        self._module = ModuleType(name)
        vars(self._module).update(_CONTENT[name])
        parent, _, self._own_name = name.rpartition(".")
        self._parent = sys.modules.get(parent)  # an attribute of its package, once that was loaded
        sys.modules[name] = self._module
        if self._parent is not None:
            setattr(self._parent, self._own_name, self._module)

    def hide(self) -> None:
        if sys.modules.get(self._module.__name__) is self._module:
            del sys.modules[self._module.__name__]
        if self._parent is not None and getattr(self._parent, self._own_name) is self._module:
            delattr(self._parent, self._own_name)
