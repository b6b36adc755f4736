"""Warms up the fork server before it is frozen: importing this module plays the life of a container once."""

import logging
import sys
import traceback

from ppaas.errors import PPaaSError

try:
    from engine.container.warm_up.plugins import load_plugins
    from engine.container.warm_up.scripted_session import warm_up
    from engine.runtimes.compilation import kernel_modules
    from engine.runtimes.fork_server import child, early_start  # noqa: F401  # what each child would load first
    from engine.runtimes.memory_tuning import code_compaction, stub_modules

    load_plugins()
    with stub_modules.stubbed(stub_modules.MASKED):
        kernel_modules.warm_loaded()  # what is not in the cache is compiled before a robot waits for it
        code_compaction.compact(warm_up)
except ImportError:  # of these the fork server would say nothing
    traceback.print_exc()
    sys.exit(1)
except (OSError, TimeoutError, PPaaSError):
    logging.getLogger(__name__).warning("containers start slowly: the warm-up failed", exc_info=True)
