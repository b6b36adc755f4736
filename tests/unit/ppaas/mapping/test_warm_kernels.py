"""The kernels of mapping are compiled before the first scan: none is compiled for other types when a log is mapped."""

import importlib
import pkgutil

import ppaas.mapping.closures.kernels
import ppaas.mapping.graph.kernels
import ppaas.mapping.kernels
from benchmarks.mapping.small_worlds import ring_drive
from ppaas.mapping.pipeline.offline import map_log

PACKAGES = (ppaas.mapping.kernels, ppaas.mapping.graph.kernels, ppaas.mapping.closures.kernels)


def modules():
    for package in PACKAGES:
        for found in pkgutil.iter_modules(package.__path__, f"{package.__name__}."):
            yield importlib.import_module(found.name)


def signatures():
    return {
        (module.__name__, name): list(kernel.signatures)
        for module in modules()
        for name, kernel in vars(module).items()
        if hasattr(kernel, "py_func") and kernel.py_func.__module__ == module.__name__
    }


def test_mapping_uses_no_kernel_that_warm_has_not_compiled():
    for module in modules():
        if hasattr(module, "warm"):
            module.warm()
    warm = signatures()
    made = map_log(ring_drive().log)
    made.grid()
    assert made.mapper.counts.closures > 0
    assert signatures() == warm
