"""Loaded in the fork server before it is frozen: importing this module rehearses the life of a container."""

import logging
import sys
import traceback

from ppaas.errors import PPaaSError

try:
    from engine.rehearsal import load_plugins, rehearse
    from engine.runtimes import child, hot_code, kernels, stand_ins, warming  # noqa: F401

    load_plugins()
    with stand_ins.instead_of(stand_ins.MASKED):
        kernels.warm_loaded()  # what is not in the cache is compiled before a robot waits for it
        hot_code.move(rehearse)
except ImportError:  # of these the fork server would say nothing
    traceback.print_exc()
    sys.exit(1)
except (OSError, TimeoutError, PPaaSError):
    logging.getLogger(__name__).warning("containers start slowly: their rehearsal failed", exc_info=True)
