"""Kernel modules are found in all packages, and called once to compile them."""

import sys

from engine.runtimes.compilation.kernel_modules import loaded, modules, warm_loaded


def dispatchers(module):
    return [found for found in vars(module).values() if hasattr(found, "signatures") and hasattr(found, "py_func")]


def test_kernels_of_all_packages_are_found():
    packages = {module.__name__.split(".")[1] for module in modules()}
    assert {"maps", "costmap", "planners", "controllers", "localization"} <= packages


def test_imported_modules_are_warmed_and_compiled(monkeypatch):
    import ppaas.localization.kernels
    from ppaas.maps.kernels import distance

    for module in loaded():
        if module not in (distance, ppaas.localization.kernels):
            monkeypatch.delitem(sys.modules, module.__name__)
    assert loaded() == [ppaas.localization.kernels, distance]
    warm_loaded()
    assert any(kernel.signatures for kernel in dispatchers(distance))
