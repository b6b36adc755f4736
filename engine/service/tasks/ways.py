"""Lengths of the ways between robots and tasks, by the cost matrix of a planning container."""

import asyncio
import logging
import math
from collections.abc import Awaitable, Callable

from engine.service.planning.requests import CostAnswer, CostRequest
from engine.specs.containers import MapVersion
from ppaas.decoding import from_json
from ppaas.errors import PPaaSError
from ppaas.tasks.assignment import Distance, straight
from ppaas.tasks.dispatcher import Dispatcher
from ppaas.tasks.records import Place

logger = logging.getLogger(__name__)

TIMEOUT = 4.0
"""Time to wait for the costs [s]; a decision that comes later is worse than one by distances in a straight line."""

Costs = Callable[[str, MapVersion, CostRequest], Awaitable[CostAnswer]]
"""Computes the costs for a user on a version of a map."""


async def no_ways(_dispatcher: Dispatcher, _now: float) -> Distance:
    """Return straight lines: without robots there is nothing to measure."""
    return straight


async def ways(costs: Costs, user: str, version: MapVersion, dispatcher: Dispatcher, now: float) -> Distance:
    """Return the lengths of the ways from robots to tasks; straight lines if no planning container answers in time.

    Parameters
    ----------
    costs : callable
        Computes a matrix of costs.
    user : str
    version : MapVersion
    dispatcher : Dispatcher
        Has the robots and the tasks.
    now : float
        Time [s since the epoch].
    """
    starts = tuple(dict.fromkeys(candidate.place for candidate in dispatcher.candidates(now)))
    goals = tuple(dict.fromkeys(task.target for task in dispatcher.undecided(now)))
    try:
        async with asyncio.timeout(TIMEOUT):
            answer = await costs(user, version, CostRequest(starts, goals, TIMEOUT))
    except (PPaaSError, TimeoutError) as error:
        logger.debug("tasks on map %r are assigned by straight lines: %s", version.id, error)
        return straight
    rows = from_json(bytes(answer.costs), list[list[float | None]])
    known: dict[tuple[Place, Place], float] = {
        (start, goal): math.inf if cost is None else cost
        for start, row in zip(starts, rows, strict=True)
        for goal, cost in zip(goals, row, strict=True)
    }
    return lambda start, goal: known.get((start, goal), straight(start, goal))
