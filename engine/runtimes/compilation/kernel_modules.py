"""Finds the kernel modules that a process has imported, and calls their kernels once."""

import importlib
import pkgutil
import sys
from types import ModuleType

from numba.core import event

import ppaas
from ppaas.kernel_cache.sources import KERNELS


def record_compilations() -> event.RecordingListener:
    """Return a recorder of all kernels that are compiled, instead of loaded from the cache, from now on."""
    recorder = event.RecordingListener()  # type: ignore[no-untyped-call]
    event.register("numba:compile", recorder)  # type: ignore[no-untyped-call]
    return recorder


def loaded() -> list[ModuleType]:
    """Return the kernel modules that this process has imported, in the order of their names."""
    return [module for name, module in sorted(sys.modules.items()) if _holds_kernels(name)]


def warm_loaded() -> None:
    """Call ``warm`` of all imported kernel modules that have it."""
    for module in loaded():
        if hasattr(module, "warm"):
            module.warm()


def warm_package(package: ModuleType) -> list[ModuleType]:
    """Import all modules of one package of kernels, call ``warm`` of each, and return them.

    Kernels in the cache are loaded, all others are compiled.
    """
    found = pkgutil.iter_modules(package.__path__, f"{package.__name__}.")
    modules = [importlib.import_module(module.name) for module in found]
    for module in modules:
        if hasattr(module, "warm"):
            module.warm()
    return modules


def _holds_kernels(name: str) -> bool:
    packages = name.split(".")
    return packages[0] == ppaas.__name__ and KERNELS in packages
