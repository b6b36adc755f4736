"""Finds the kernels of the domain and calls each of them once."""

import importlib
import pkgutil
from types import ModuleType

from numba.core import event

import ppaas


def modules() -> list[ModuleType]:
    """Import all modules of the ``kernels`` packages of the domain, and return them by name.

    Raises
    ------
    ImportError
        One of them, or a package on the way, cannot be imported.
    """
    walk = pkgutil.walk_packages(ppaas.__path__, "ppaas.", onerror=importlib.import_module)
    names = sorted(found.name for found in walk if "kernels" in found.name.split("."))
    return [importlib.import_module(name) for name in names]


def record_compilations() -> event.RecordingListener:
    """Return what records, from now on, each kernel that is compiled instead of loaded from the cache."""
    recorder = event.RecordingListener()  # type: ignore[no-untyped-call]
    event.register("numba:compile", recorder)  # type: ignore[no-untyped-call]
    return recorder


def warm_all() -> tuple[str, ...]:
    """Call ``warm`` of every kernels module that offers it, and return the names of these modules.

    Raises
    ------
    ImportError
        A module cannot be imported.
    """
    warmable = [module for module in modules() if hasattr(module, "warm")]
    for module in warmable:
        module.warm()
    return tuple(module.__name__ for module in warmable)
