"""Service ``ppaas_msgs/ComputeCosts``: costs of paths from each start to each goal."""

import math
from collections.abc import Callable

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.ppaas_msgs import ComputeCostsRequest, ComputeCostsResponse
from ppaas.nodes.base import Context, Job, Reply
from ppaas.nodes.message_checks import finite_pose
from ppaas.nodes.planner_server.path_services import MAX_TIMEOUT
from ppaas.nodes.planner_server.planner_queue import PlannerQueue
from ppaas.nodes.planner_server.variants import Variants, parameters_of
from ppaas.planners.base import PlanRequest
from ppaas.planners.watch import Watch
from ppaas.thread_budget import Threads

MAX_ENDS = 1_000
"""Largest number of starts, and of goals, in a request."""

MAX_COSTS = 50_000
"""Largest number of costs in a response, less than 1 MiB of text."""

DECIMALS = 3
"""Decimals of a cost."""


class CostService:
    """Computes the costs of paths from each start to each goal, one request after the other.

    Parameters
    ----------
    context : Context
        Context of the node that offers the service.
    variants : Variants
        Costmaps of the map by parameters.
    threads : callable
        Returns the largest number of threads that kernels may use now.
    """

    def __init__(self, context: Context, variants: Variants, threads: Threads) -> None:
        self._variants = variants
        self._threads = threads
        self._queue = PlannerQueue(context)

    def compute(self, request: ComputeCostsRequest, reply: Reply) -> Job:
        """Compute costs, and reply with them or with the error.

        Returns
        -------
        Job
            Handle to cancel the request.

        Raises
        ------
        InvalidInput
            A pose is invalid, there are too many, or the timeout or a parameter is out of range.
        Unavailable
            Too many requests are waiting.
        """
        if not 0.0 < request.timeout <= MAX_TIMEOUT:
            raise InvalidInput(f"timeout must be above 0 and at most {MAX_TIMEOUT:g} s, not {request.timeout}")
        starts, goals = _places(request.starts, "start"), _places(request.goals, "goal")
        if len(starts) * len(goals) > MAX_COSTS:
            raise InvalidInput(f"a request may ask for at most {MAX_COSTS} costs, not {len(starts)}×{len(goals)}")

        parameters = parameters_of(request.parameters)
        unknown = self._variants.allows_unknown(parameters)

        def work(cancelled: Callable[[], bool]) -> ComputeCostsResponse:
            from ppaas.planners.batch.cost_matrix import cost_matrix  # noqa: PLC0415 - its kernels are not for every container

            costmap = self._variants.variant(parameters).costmap
            origin = costmap.info.origin
            watch = Watch(PlanRequest(origin, origin, timeout=request.timeout, cancelled=cancelled))
            costs = cost_matrix(
                costmap, starts, goals, threads=self._threads(), check=watch.check, allow_unknown=unknown
            )
            return ComputeCostsResponse(_text(costs), watch.seconds())

        return self._queue.submit(work, reply)


def _places(poses: list[Pose], what: str) -> NDArray[np.float64]:
    if len(poses) > MAX_ENDS:
        raise InvalidInput(f"a request may have at most {MAX_ENDS} {what}s, not {len(poses)}")
    places = [finite_pose(pose, f"{what} {number}")[:2] for number, pose in enumerate(poses)]
    return np.array(places, dtype=np.float64).reshape(-1, 2)


def _text(costs: NDArray[np.float64]) -> str:
    rows = [[cost if math.isfinite(cost) else None for cost in row] for row in costs.round(DECIMALS).tolist()]
    return msgspec.json.encode(rows).decode()
