"""Planning for a robot that moves: around what it sees, and telling errors that will pass from those that will not."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np

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
from ppaas.geometry import Pose2D, Poses
from ppaas.maps.grid import GridInfo
from ppaas.navigation.blocked_path_memory import BlockedPathMemory
from ppaas.navigation.parameters import MoveBaseParameters
from ppaas.nodes.base import Context, Job
from ppaas.nodes.move_base.client_paths import rest_for
from ppaas.nodes.move_base.surroundings import Surroundings
from ppaas.nodes.planner_server.planner_queue import PlannerQueue
from ppaas.planners.base import Planner, PlanRequest, PlanResult
from ppaas.planners.field.way_out import plan_way_out
from ppaas.planners.through_poses import plan_through
from ppaas.planners.weights import passable
from ppaas.plans.reuse.crossed_cells import crossed_by
from ppaas.plans.reuse.processor import PlanProcessor
from ppaas.plugins import parameters_in_use
from ppaas.thread_budget import Threads

GIVEN = "follow_path"
"""Name of the planner in plans that are paths of clients."""

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


@dataclass(frozen=True, slots=True)
class Waiting:
    """The robot should wait for the given reason, and ask for a plan again."""

    reason: str


@dataclass(frozen=True, slots=True)
class Outdated:
    """There was a plan, but the map was replaced meanwhile, and it is blocked on the new one."""


Planned = PlanResult | Detour | Waiting | NoPlan | Outdated | PPaaSError
"""Result of a plan request."""


def plan_for_robot(
    processor: PlanProcessor, planner: Planner, static: Costmap, current: Costmap, request: PlanRequest, *,
    reuse: bool, through: Sequence[Pose2D] = (), leaving: Costmap | None = None,
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
    leaving : Costmap, optional
        Costs by which the robot leaves a keep-out zone that it is in.
    """

    def on(costmap: Costmap, plan: Callable[[PlanRequest], PlanResult]) -> PlanResult:
        def whole(part: PlanRequest) -> PlanResult:
            return plan_through(plan, through, part)

        return whole(request) if leaving is None else plan_way_out(whole, costmap, leaving, request)

    try:
        return on(current, lambda part: processor.plan(planner, current, part, reuse=reuse))
    except BLOCKED as error:
        final = current is static or _is_blocked(lambda: on(static, lambda part: planner.plan(static, part)))
        return NoPlan(error, final=final)
    except FINAL as error:
        return NoPlan(error, final=True)
    except PlanningError as error:
        return NoPlan(error, final=False)


def _is_blocked(plan: Callable[[], PlanResult]) -> bool:
    try:
        plan()
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
    surroundings : Surroundings
        Costmap of the map, and observed obstacles.
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
        surroundings: Surroundings,
        parameters: MoveBaseParameters,
        *,
        threads: Threads,
        processor: PlanProcessor,
    ) -> None:
        self._processor = processor
        self._planner = planner
        self._surroundings = surroundings
        self._open_costs = passable(bool(parameters_in_use(planner).get("allow_unknown", True)))
        self._parameters = parameters
        self._threads = threads
        self._now = context.elapsed
        self._queue = PlannerQueue(context)
        self._job: Job | None = None
        self._blocked_paths = BlockedPathMemory()

    def head_for(self, goal: Pose2D) -> None:
        """Set the goal, which may be the last one that has moved."""
        self._blocked_paths.head_for(goal)

    def use_map(self, before: GridInfo, processor: PlanProcessor, *, other_version: bool) -> None:
        """Continue on the new map of the surroundings.

        Parameters
        ----------
        before : GridInfo
            Geometry of the map before.
        processor : PlanProcessor
            Finds stored plans for the new map.
        other_version : bool
            Whether it is another version of a published map: then the planner forgets what it has prepared.
        """
        self._blocked_paths.carry(before, self._surroundings.static)
        self._processor = processor
        if other_version:
            self._planner = self._planner.fresh()

    def is_blocked(self, poses: Poses) -> bool:
        """Return whether a plan (n, 7) is blocked now, beyond the first free cell: a robot may have to leave others."""
        current = self._surroundings.seen()
        rows, columns = crossed_by(current.info, poses[:, :2]).cells.T
        inside = (rows >= 0) & (rows < current.info.height) & (columns >= 0) & (columns < current.info.width)
        free = np.zeros(len(rows), np.bool_)
        free[inside] = self._open_costs[current.data[rows[inside], columns[inside]]]
        return bool(not free[np.argmax(free) :].all())

    def request(
        self, start: Pose2D, goal: Pose2D, done: Callable[[Planned], None], through: Sequence[Pose2D] = ()
    ) -> None:
        """Plan around observed obstacles, through poses; ``done`` is called with the result."""
        p, processor, planner = self._parameters, self._processor, self._planner
        static, current, leaving = self._surroundings.static, self._marked(), self._surroundings.way_out()

        def work(cancelled: Callable[[], bool]) -> PlanResult | NoPlan:
            request = PlanRequest(start, goal, p.default_tolerance, p.planner_timeout, cancelled, self._threads())
            return plan_for_robot(
                processor, planner, static, current, request, reuse=p.reuse_plans, through=through, leaving=leaving
            )

        def planned(result: PlanResult | NoPlan | PPaaSError) -> None:
            if leaving is not None:
                done(result)
            elif static is self._surroundings.static:
                done(self._followed(result, current, start))
            else:
                done(self._on_new_map(result, start))

        self._job = self._queue.submit(work, planned)

    def along(self, start: Pose2D, poses: Poses, done: Callable[[Planned], None]) -> None:
        """Return the rest of a path (n, 7) that a client has given, if it is free; ``done`` is called with it."""
        try:
            rest = rest_for(poses, start)
        except PPaaSError as error:
            done(NoPlan(error, final=True))
            return
        if self.is_blocked(rest):
            done(NoValidPath("the path is blocked"))
            return
        length = float(np.hypot(*np.diff(rest[:, :2], axis=0).T).sum())
        done(PlanResult(np.empty((0, 2), np.int32), rest, 0.0, length, 0, 0.0, GIVEN))

    def _marked(self) -> Costmap:
        return self._blocked_paths.mark(self._surroundings.seen(), self._now())

    def _followed(self, result: PlanResult | NoPlan | PPaaSError, current: Costmap, start: Pose2D) -> Planned:
        longer = self._blocked_paths.take(result, current, start, self._now())
        return Detour(longer) if longer > 0.0 else result

    def _on_new_map(self, result: PlanResult | NoPlan | PPaaSError, start: Pose2D) -> Planned:
        """Return the result of planning on a map that was replaced meanwhile, if it is valid on the new one.

        Such a plan is not stored, since it belongs to neither version.
        """
        if isinstance(result, NoPlan):
            return NoPlan(result.error, final=False)
        if not isinstance(result, PlanResult):
            return result
        if self.is_blocked(result.poses):
            return Outdated()
        current = self._marked()
        cells = crossed_by(current.info, result.poses[:, :2]).cells.astype(np.int32)
        return self._followed(msgspec.structs.replace(result, cells=cells, id="", reused=""), current, start)

    def cancel(self) -> None:
        """Cancel the current plan, if there is one."""
        if self._job is not None:
            self._job.cancel()
            self._job = None
