"""What the fork server loads before it forks the first container: everything a container would else load itself.

Importing this module does the work. Any failure ends the fork server with its reason: a container must never find
out later that a kernel is missing. Where all kernels are known to be compiled, only what comes after this module loads
any: those that every container uses.
"""

import os
import sys
import traceback
from pathlib import Path

ENVIRONMENT = dict(os.environ)
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_name] = "1"  # a pool of threads in the fork server would be lost in its children

try:
    from engine.runtimes import memory, threading_layer

    memory.give_back_early()
    with memory.without_extras():
        LAYER = threading_layer.choose()

        import asyncio  # noqa: F401

        import msgspec  # noqa: F401
        import numpy as np  # noqa: F401
        import uvloop  # noqa: F401

        import ppaas
        from engine.runtimes import compiled, kernel_stamp, kernels

        compiled.load_without_compiler()
        COMPILED = kernels.record_compilations()
        _stamp = kernel_stamp.stamp_file(Path(ppaas.__path__[0]), LAYER)
        ALL_LOADED = not kernel_stamp.all_compiled(_stamp)
        if ALL_LOADED:
            kernel_stamp.note(_stamp, kernels.warm_all())
except ImportError:  # of these the fork server would say nothing
    traceback.print_exc()
    sys.exit(1)
