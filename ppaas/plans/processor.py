"""The Path Plan Processor of a container: a plan that is kept where that is sooner, else one that is computed."""

from collections.abc import Callable
from dataclasses import dataclass, field

from ppaas.clock import Clock, monotonic
from ppaas.costmap.costmap import Costmap
from ppaas.errors import PlanCancelled, PlanningError
from ppaas.planners.base import Planner, PlanRequest, PlanResult
from ppaas.plans.criteria import MARGIN, Verdict, by_time
from ppaas.plans.estimates import ComputationTimes, Estimate, LinkTimes
from ppaas.plans.history import (
    PlannerHistory,
    bucket_of,
    complexity,
    computed_row,
    failed_row,
    found_row,
)
from ppaas.plans.stitching import BOUND, Ground, Offer, offer
from ppaas.plans.stored import PlanLibrary, Question
from ppaas.plugins import parameters_in_use

BYTES_PER_CELL = 64.0
"""Of an answer, for each cell between start and goal: a pose has 56 bytes, and no path is straight."""

CHECKING = 2e-4
CHECKED_PER_SECOND = 1e9
"""What is believed of checking a plan before it was measured: how long any takes [s], and bytes of poses [1/s]."""

Note = Callable[[PlannerHistory], None]


@dataclass(frozen=True, slots=True)
class Standing:
    """On what a container plans.

    Parameters
    ----------
    map, version : str
        Which it is.
    bare : Costmap
        Of the map alone.
    robot_radius : float
        Of the robot for which it is inflated [m].
    """

    map: str
    version: str
    bare: Costmap
    robot_radius: float


@dataclass(frozen=True, slots=True)
class ReuseParameters:
    """When a kept plan will do.

    Parameters
    ----------
    tolerance : float
        How far its ends may be from those asked for [m].
    bound : float
        By how much of the cheapest cost it may be dearer.
    margin : float
        How many times faster than computing it must be there.
    """

    tolerance: float = 0.25
    bound: float = BOUND
    margin: float = MARGIN


@dataclass(slots=True)
class Times:
    """What was measured, for the estimates of criterion (a)."""

    computation: ComputationTimes = field(default_factory=ComputationTimes)
    link: LinkTimes = field(default_factory=LinkTimes)
    checking: LinkTimes = field(default_factory=lambda: LinkTimes(monotonic, CHECKING, CHECKED_PER_SECOND))

    def transmission(self, cells: float) -> Estimate:
        """Return how long it will take until a kept plan of this complexity is there and was checked."""
        size = cells * BYTES_PER_CELL
        link, checking = self.link.expect(size), self.checking.expect(size)
        lower, upper = link.lower + checking.lower, link.upper + checking.upper
        return Estimate(link.mean + checking.mean, lower, upper, link.samples)


class PlanProcessor:
    """Plans with any planner, and looks first for a plan that is kept where that is expected to be sooner.

    Several threads may use it, each with a planner of its own.

    Parameters
    ----------
    standing : Standing
        The map.
    library : PlanLibrary
        Where plans are kept.
    times : Times
        What was measured.
    note : callable
        Told what became of each request.
    parameters : ReuseParameters
        When a kept plan will do.
    clock : callable
        Monotonic seconds.
    """

    def __init__(
        self,
        standing: Standing,
        library: PlanLibrary,
        times: Times,
        note: Note,
        *,
        parameters: ReuseParameters = ReuseParameters(),
        clock: Clock = monotonic,
    ) -> None:
        self._standing = standing
        self._library = library
        self._times = times
        self._note = note
        self._parameters = parameters
        self._clock = clock
        self.verdict = Verdict(False, "kept")

    def plan(self, planner: Planner, costmap: Costmap, request: PlanRequest, *, reuse: bool = True) -> PlanResult:
        """Return a plan that is kept, if it is expected to be there sooner, or compute one; raises as a planner does.

        Parameters
        ----------
        planner : Planner
            Who computes it, and whose like a kept one must be.
        costmap : Costmap
            As it is now.
        request : PlanRequest
            What to plan.
        reuse : bool
            Whether a kept plan will do.
        """
        cells = complexity(request.start, request.goal, costmap.info.resolution)
        key = self._standing.map, self._standing.version, planner.name, bucket_of(cells)
        if reuse and (found := self._found(planner, costmap, request, cells)) is not None:
            self._note(found_row(key, found.origin))
            return found
        try:
            result = planner.plan(costmap, request)
        except PlanCancelled:
            raise  # it says nothing of the planner
        except PlanningError:
            self._note(failed_row(key))
            raise
        self._times.computation.note(planner.name, cells, result.seconds)
        self._note(computed_row(key, result.seconds))
        return result

    def _found(self, planner: Planner, costmap: Costmap, request: PlanRequest, cells: float) -> PlanResult | None:
        """Return a kept plan, if it pays to look for one and there is one that will do."""
        computation = self._times.computation.expect(planner.name, cells)
        verdict = self.verdict = by_time(self._times.transmission(cells), computation, self._parameters.margin)
        if computation is None or not verdict.taken or not (request.start.is_finite() and request.goal.is_finite()):
            return None
        if not self._library.may_wait():
            raise PlanCancelled("this is begun again where it may wait for plans that are kept")
        began = self._clock()
        made = self._look(planner, costmap, request, computation.lower / self._parameters.margin)
        if made is None:
            return None
        return PlanResult(
            cells=made.cells, poses=made.poses, cost=made.cost, length=made.length, expanded=0,
            seconds=self._clock() - began, planner=planner.name, origin=made.origin, reused=made.source,
        )  # fmt: skip

    def _look(self, planner: Planner, costmap: Costmap, request: PlanRequest, within: float) -> Offer | None:
        standing, p = self._standing, self._parameters
        question = Question(
            request.start, request.goal, standing.version, planner.name, parameters_in_use(planner),
            standing.robot_radius, p.tolerance, kinematic=planner.traits.kinematic,
        )  # fmt: skip
        found = self._library.find(question, within)
        if not found:
            self.verdict = Verdict(False, "late" if found is None else "kept", {"within": within})
            return None
        ground = Ground(costmap, standing.bare, allow_unknown=question.parameters.get("allow_unknown", True))
        for stored in found:
            began = self._clock()
            made, self.verdict = offer(stored, question, ground, planner.traits, p.bound)
            self._times.checking.note(stored.poses.nbytes, self._clock() - began)
            if made is not None:
                return made
        return None
