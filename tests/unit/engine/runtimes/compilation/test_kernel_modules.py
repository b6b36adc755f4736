"""Imported kernel modules are called once to compile them."""

import sys

from engine.runtimes.compilation.kernel_modules import loaded, warm_loaded


def dispatchers(module):
    return [found for found in vars(module).values() if hasattr(found, "signatures") and hasattr(found, "py_func")]


def test_imported_modules_are_warmed_and_compiled(monkeypatch):
    import ppaas.localization.kernels
    from ppaas.maps.kernels import distance

    for module in loaded():
        if module not in (distance, ppaas.localization.kernels):
            monkeypatch.delitem(sys.modules, module.__name__)
    assert loaded() == [ppaas.localization.kernels, distance]
    warm_loaded()
    assert any(kernel.signatures for kernel in dispatchers(distance))
