"""Planning for a robot that moves: around what it sees, and telling errors that will pass from those that will not."""

from collections.abc import Callable
from dataclasses import dataclass

from ppaas.costmap.costmap import Costmap
from ppaas.errors import (
    GoalOccupied,
    GoalOutsideMap,
    InvalidInput,
    InvalidPlanner,
    NoValidPath,
    PlanningError,
    PPaaSError,
    StartOutsideMap,
)
from ppaas.geometry import Pose2D
from ppaas.navigation.blocked_path_memory import BlockedPathMemory
from ppaas.navigation.parameters import MoveBaseParameters
from ppaas.nodes.base import Context, Job
from ppaas.nodes.planner_server.planner_queue import PlannerQueue
from ppaas.planners.base import Planner, PlanRequest, PlanResult
from ppaas.plans.reuse.processor import PlanProcessor
from ppaas.thread_budget import Threads

FINAL = (GoalOutsideMap, StartOutsideMap, InvalidPlanner, InvalidInput)
"""Errors that neither clearing obstacles nor turning on the spot can change."""

BLOCKED = (GoalOccupied, NoValidPath)
"""Errors that an obstacle may be the cause of: final if they hold on the bare map too."""


@dataclass(frozen=True, slots=True)
class NoPlan:
    """Why there is no plan, and whether that is final."""

    error: PPaaSError
    final: bool


@dataclass(frozen=True, slots=True)
class Detour:
    """There is a plan, so much longer than the way before [m] that it is better to wait for that."""

    longer: float

    @property
    def reason(self) -> str:
        """What the robot waits for."""
        return f"the way is blocked, and the next one is {self.longer:.1f} m longer"


Planned = PlanResult | Detour | NoPlan | PPaaSError
"""What comes of a request."""


def plan_for_robot(
    processor: PlanProcessor, planner: Planner, static: Costmap, current: Costmap, request: PlanRequest, *, reuse: bool
) -> PlanResult | NoPlan:
    """Plan around the obstacles seen; if they block the way, ask the bare map whether it is theirs to block.

    Parameters
    ----------
    processor : PlanProcessor
        Looks first for a plan that is kept, where that pays and ``reuse`` says so.
    planner : Planner
        Asked once, or twice if the way is blocked.
    static, current : Costmap
        The map alone, and with what the robot has seen; the same object if it has seen nothing new.
    """
    try:
        return processor.plan(planner, current, request, reuse=reuse)
    except BLOCKED as error:
        return NoPlan(error, final=current is static or _is_blocked(planner, static, request))
    except FINAL as error:
        return NoPlan(error, final=True)
    except PlanningError as error:
        return NoPlan(error, final=False)


def _is_blocked(planner: Planner, static: Costmap, request: PlanRequest) -> bool:
    try:
        planner.plan(static, request)
    except BLOCKED:
        return True
    except PlanningError:
        return False
    return False


class RobotPlanner:
    """Plans for the goal under way, one plan after the other.

    Parameters
    ----------
    context : Context
        Of the node that drives.
    planner : Planner
        Used by nobody else.
    static : Costmap
        Of the map alone.
    parameters : MoveBaseParameters
        How long to plan, and how near to the goal will do.
    threads : callable
        Returns the most threads that kernels may use now.
    processor : PlanProcessor
        By which plans that are kept are found.
    """

    def __init__(
        self,
        context: Context,
        planner: Planner,
        static: Costmap,
        parameters: MoveBaseParameters,
        *,
        threads: Threads,
        processor: PlanProcessor,
    ) -> None:
        self._processor = processor
        self._planner = planner
        self._static = static
        self._parameters = parameters
        self._threads = threads
        self._now = context.now
        self._queue = PlannerQueue(context)
        self._job: Job | None = None
        self._shut = BlockedPathMemory()

    def head_for(self, goal: Pose2D) -> None:
        """Take note of another goal, or where it has moved to."""
        self._shut.head_for(goal)

    def request(self, start: Pose2D, goal: Pose2D, seen: Costmap, done: Callable[[Planned], None]) -> None:
        """Plan on a costmap with what the robot sees; ``done`` gets what comes of it."""
        p = self._parameters
        current = self._shut.mark(seen, self._now())

        def work(cancelled: Callable[[], bool]) -> PlanResult | NoPlan:
            request = PlanRequest(start, goal, p.default_tolerance, p.planner_timeout, cancelled, self._threads())
            return plan_for_robot(self._processor, self._planner, self._static, current, request, reuse=p.reuse_plans)

        def planned(result: PlanResult | NoPlan | PPaaSError) -> None:
            longer = self._shut.take(result, current, start, self._now())
            done(Detour(longer) if longer > 0.0 else result)

        self._job = self._queue.submit(work, planned)

    def cancel(self) -> None:
        """Give the plan under way up, if there is one."""
        if self._job is not None:
            self._job.cancel()
            self._job = None
