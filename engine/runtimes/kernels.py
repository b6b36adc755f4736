"""Finds the kernels of the domain and calls each of them once."""

import importlib
import pkgutil
import sys
from types import ModuleType

from numba.core import event

import ppaas
from engine.runtimes.kernel_stamp import KERNELS


def modules() -> list[ModuleType]:
    """Import all modules of the ``kernels`` packages of the domain, and return them by name.

    Raises
    ------
    ImportError
        One of them, or a package on the way, cannot be imported.
    """
    walk = pkgutil.walk_packages(ppaas.__path__, "ppaas.", onerror=importlib.import_module)
    names = sorted(found.name for found in walk if _holds_kernels(found.name))
    return [importlib.import_module(name) for name in names]


def record_compilations() -> event.RecordingListener:
    """Return what records, from now on, each kernel that is compiled instead of loaded from the cache."""
    recorder = event.RecordingListener()  # type: ignore[no-untyped-call]
    event.register("numba:compile", recorder)  # type: ignore[no-untyped-call]
    return recorder


def loaded() -> list[ModuleType]:
    """Return the modules of kernels that this process has loaded, by name."""
    return [module for name, module in sorted(sys.modules.items()) if _holds_kernels(name)]


def warm_all() -> list[ModuleType]:
    """Call ``warm`` of every kernels module that offers it, and return these modules.

    Raises
    ------
    ImportError
        A module cannot be imported.
    """
    return _warm(modules())


def warm_loaded() -> list[ModuleType]:
    """Do so with the modules alone that this process has loaded."""
    return _warm(loaded())


def _warm(found: list[ModuleType]) -> list[ModuleType]:
    warmable = [module for module in found if hasattr(module, "warm")]
    for module in warmable:
        module.warm()
    return warmable


def _holds_kernels(name: str) -> bool:
    packages = name.split(".")
    return packages[0] == ppaas.__name__ and KERNELS in packages
