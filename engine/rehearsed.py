"""Loaded in the fork server before it is frozen: importing this module rehearses the life of a container."""

import logging
import sys
import traceback

from ppaas.errors import PPaaSError

try:
    from engine.rehearsal import rehearse

    rehearse()
except ImportError:  # of these the fork server would say nothing
    traceback.print_exc()
    sys.exit(1)
except (OSError, TimeoutError, PPaaSError):
    logging.getLogger(__name__).warning("containers start slowly: their rehearsal failed", exc_info=True)
