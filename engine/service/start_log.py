"""Start log: shows the operator of a cloud what it waits for while it starts, and which kernels it compiles then."""

import asyncio
import logging
from collections.abc import Callable

from engine.specs.start_state import StartState

logger = logging.getLogger(__name__)

USUAL_START = 3.0
"""Time after which a start is reported as slow [s]."""

PERIOD = 3.0
"""Time between two lines while the cloud is starting [s]."""

LATER_PERIOD = 15.0
"""Time between two lines while the kernels of further planners are compiled [s]."""


async def log_start(state_of: Callable[[], StartState]) -> None:
    """Log the state of a cloud until it is ready and all its kernels are compiled, each line once.

    Parameters
    ----------
    state_of : callable
        Returns the state of the cloud.
    """
    await asyncio.sleep(USUAL_START)
    logged = ""
    was_slow = False
    while (state := state_of()).text:
        line = _line(state)
        if line != logged:
            logger.info("%s", line)
            logged = line
        was_slow = True
        await asyncio.sleep(LATER_PERIOD if state.ready else PERIOD)
    if was_slow:
        logger.info("the cloud is ready, and all kernels are compiled")


def _line(state: StartState) -> str:
    if not state.ready:
        return f"{state.text}. The first start on a computer compiles the kernels, which takes some minutes"
    return f"the cloud is ready: {state.kernels} for further planners; requests that need them wait for them"
