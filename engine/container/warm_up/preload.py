"""What the fork server loads before it forks the first container: everything a container would else load itself.

Importing this module does the work. Any failure ends the fork server with its reason: a container must never find
out later that a kernel is missing. Kernels are loaded by what comes after this module, as far as every container uses
them; ``first_start`` has them compiled here, and ``engine.runtimes.compilation.rest_compiler`` sees to the others.
"""

import os
import sys
import traceback

ENVIRONMENT = dict(os.environ)
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_name] = "1"  # a pool of threads in the fork server would be lost in its children

try:
    from engine.runtimes.compilation import threading_layer
    from engine.runtimes.memory_tuning import allocator, stub_modules

    allocator.trim_early()
    with stub_modules.without_extras():
        import asyncio  # noqa: F401

        import msgspec  # noqa: F401
        import numpy as np  # noqa: F401

        with stub_modules.stubbed(stub_modules.TLS):
            import uvloop  # noqa: F401

        with stub_modules.stubbed(stub_modules.HTML, stub_modules.POLYNOMIAL):
            threading_layer.choose()

        from engine.container.warm_up import first_start
        from engine.runtimes.compilation import kernel_modules
        from engine.runtimes.memory_tuning import cached_kernels

        first_start.compile_missing(threading_layer.chosen())
        cached_kernels.load_without_compiler()
        COMPILED = kernel_modules.record_compilations()
except ImportError:  # of these the fork server would say nothing
    traceback.print_exc()
    sys.exit(1)
