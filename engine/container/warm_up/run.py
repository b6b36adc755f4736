"""Warms up the fork server before it is frozen: importing this module runs a scripted container session once."""

import logging
import sys
import traceback

from ppaas.errors import PPaaSError

try:
    from engine.container.warm_up.plugins import load_plugins
    from engine.container.warm_up.scripted_session import warm_up
    from engine.runtimes.compilation import kernel_modules
    from engine.runtimes.fork_server import child, early_start  # noqa: F401  # each child would import them first
    from engine.runtimes.memory_tuning import process_memory, stub_modules

    load_plugins()
    with stub_modules.stubbed(stub_modules.MASKED):
        kernel_modules.warm_loaded()  # kernels missing in the cache are compiled before a robot needs them
        process_memory.compact(warm_up)
except ImportError:  # the fork server ignores failed imports silently
    traceback.print_exc()
    sys.exit(1)
except (OSError, TimeoutError, PPaaSError):
    logging.getLogger(__name__).warning(
        "the warm-up of the fork server failed: containers will start slowly", exc_info=True
    )
