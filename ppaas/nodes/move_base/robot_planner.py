"""Planning for a robot that moves: around what it sees, and telling errors that will pass from those that will not."""

from collections.abc import Callable, Sequence
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
from ppaas.planners.through_poses import plan_through
from ppaas.plans.reuse.processor import PlanProcessor
from ppaas.thread_budget import Threads

FINAL = (GoalOutsideMap, StartOutsideMap, InvalidPlanner, InvalidInput)
"""Errors that no recovery behaviour can change."""

BLOCKED = (GoalOccupied, NoValidPath)
"""Errors that an observed obstacle may have caused; they are final if they occur on the map alone too."""


@dataclass(frozen=True, slots=True)
class NoPlan:
    """Planning failed; ``final`` means that no recovery behaviour can change that."""

    error: PPaaSError
    final: bool


@dataclass(frozen=True, slots=True)
class Detour:
    """There is a plan, but the robot should first wait for the blocked path, which is ``longer`` metres shorter."""

    longer: float

    @property
    def reason(self) -> str:
        """Text for the status of the goal."""
        return f"the path is blocked, and the detour is {self.longer:.1f} m longer"


Planned = PlanResult | Detour | NoPlan | PPaaSError
"""Result of a plan request."""


def plan_for_robot(
    processor: PlanProcessor, planner: Planner, static: Costmap, current: Costmap, request: PlanRequest, *,
    reuse: bool, through: Sequence[Pose2D] = (),
) -> PlanResult | NoPlan:  # fmt: skip
    """Plan around observed obstacles; if they block the path, check on the map alone whether the error is final.

    Parameters
    ----------
    processor : PlanProcessor
        Uses a stored plan if that is faster and ``reuse`` is true.
    planner : Planner
        Called once, or twice if the path is blocked.
    static, current : Costmap
        Costmap of the map alone, and with observed obstacles; the same object if there are none.
    through : sequence of Pose2D
        Poses that the path passes.
    """
    try:
        return plan_through(lambda part: processor.plan(planner, current, part, reuse=reuse), through, request)
    except BLOCKED as error:
        return NoPlan(error, final=current is static or _is_blocked(planner, static, request, through))
    except FINAL as error:
        return NoPlan(error, final=True)
    except PlanningError as error:
        return NoPlan(error, final=False)


def _is_blocked(planner: Planner, static: Costmap, request: PlanRequest, through: Sequence[Pose2D]) -> bool:
    try:
        plan_through(lambda part: planner.plan(static, part), through, request)
    except BLOCKED:
        return True
    except PlanningError:
        return False
    return False


class RobotPlanner:
    """Makes the plans for the active goal, one after the other.

    Parameters
    ----------
    context : Context
        Context of the node that drives.
    planner : Planner
        Must not be used by others.
    static : Costmap
        Costmap of the map alone.
    parameters : MoveBaseParameters
        Time limit, tolerance and reuse of plans.
    threads : callable
        Returns the largest number of threads that kernels may use now.
    processor : PlanProcessor
        Finds stored plans.
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
        self._now = context.elapsed
        self._queue = PlannerQueue(context)
        self._job: Job | None = None
        self._blocked_paths = BlockedPathMemory()

    def head_for(self, goal: Pose2D) -> None:
        """Set the goal, which may be the last one that has moved."""
        self._blocked_paths.head_for(goal)

    def request(
        self, start: Pose2D, goal: Pose2D, seen: Costmap, done: Callable[[Planned], None],
        through: Sequence[Pose2D] = (),
    ) -> None:  # fmt: skip
        """Plan on a costmap with observed obstacles, through poses; ``done`` is called with the result."""
        p = self._parameters
        current = self._blocked_paths.mark(seen, self._now())

        def work(cancelled: Callable[[], bool]) -> PlanResult | NoPlan:
            request = PlanRequest(start, goal, p.default_tolerance, p.planner_timeout, cancelled, self._threads())
            return plan_for_robot(
                self._processor, self._planner, self._static, current, request, reuse=p.reuse_plans, through=through
            )

        def planned(result: PlanResult | NoPlan | PPaaSError) -> None:
            longer = self._blocked_paths.take(result, current, start, self._now())
            done(Detour(longer) if longer > 0.0 else result)

        self._job = self._queue.submit(work, planned)

    def cancel(self) -> None:
        """Cancel the current plan, if there is one."""
        if self._job is not None:
            self._job.cancel()
            self._job = None
