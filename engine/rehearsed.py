"""Loaded in the fork server before it is frozen: importing this module rehearses the life of a container."""

import logging
import sys
import traceback

from ppaas.errors import PPaaSError

try:
    from engine.rehearsal import ROBOT, rehearse
    from engine.runtimes import kernels
    from ppaas.controllers.registry import CONTROLLERS
    from ppaas.planners.registry import PLANNERS

    PLANNERS.load(ROBOT.base_global_planner)
    CONTROLLERS.load(ROBOT.base_local_planner)
    kernels.warm_loaded()  # what is not in the cache is compiled before a robot waits for it
    rehearse()
except ImportError:  # of these the fork server would say nothing
    traceback.print_exc()
    sys.exit(1)
except (OSError, TimeoutError, PPaaSError):
    logging.getLogger(__name__).warning("containers start slowly: their rehearsal failed", exc_info=True)
