"""Preload of the fork server: modules that every container would otherwise import itself.

Importing this module does the work. A failed import ends the fork server and prints the reason, so that no container
finds a module or kernel missing later. ``first_start`` compiles the kernels that every container uses, and modules
loaded after this one load them. ``engine.runtimes.compilation.rest_compiler`` compiles all other kernels.
"""

import gc
import os
import sys
import traceback

gc.disable()  # until ``freeze``: imports make next to no garbage, and searching it takes a tenth of the time
ENVIRONMENT = dict(os.environ)
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_name] = "1"  # a fork does not copy a pool of threads

try:
    from engine.runtimes.compilation import threading_layer
    from engine.runtimes.memory_tuning import process_memory, stub_modules

    process_memory.trim_early()
    with stub_modules.without_extras():
        import asyncio  # noqa: F401

        import msgspec  # noqa: F401
        import numpy as np  # noqa: F401

        with stub_modules.stubbed(stub_modules.TLS):
            import uvloop  # noqa: F401

        threading_layer.choose()
        with stub_modules.stubbed(stub_modules.HTML, stub_modules.POLYNOMIAL):
            import numba  # noqa: F401

        from engine.container.warm_up import first_start
        from engine.runtimes.compilation import kernel_modules
        from engine.runtimes.memory_tuning import cached_kernels

        first_start.compile_missing(threading_layer.chosen())
        cached_kernels.load_without_compiler()
        COMPILED = kernel_modules.record_compilations()
except ImportError:  # the fork server ignores failed imports silently
    traceback.print_exc()
    sys.exit(1)
