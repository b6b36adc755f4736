"""The Path Plan Processor of a container: a plan that is kept where that is sooner, else one that is computed."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import msgspec

from ppaas.clock import Clock, monotonic
from ppaas.costmap.costmap import Costmap
from ppaas.errors import PlanCancelled, PlanningError
from ppaas.planners.base import Planner, PlanRequest, PlanResult
from ppaas.plans.criteria import MARGIN, Verdict, by_time
from ppaas.plans.estimates import ComputationTimes, Estimate, LinkTimes
from ppaas.plans.history import (
    PlannerHistory,
    bucket_of,
    compared_row,
    complexity,
    computed_row,
    failed_row,
    found_row,
)
from ppaas.plans.identity import plan_id
from ppaas.plans.stitching import BOUND, Ground, Offer, offer
from ppaas.plans.stored import BARE_MAP, ROBOT_RADIUS, Conditions, EmptyLibrary, PlanLibrary, Question, own_parameters
from ppaas.plugins import parameters_in_use

BYTES_PER_CELL = 64.0
"""Of an answer, for each cell between start and goal: a pose has 56 bytes, and no path is straight."""

TOLD_PER_CELL = 1.4e-6
"""Seconds, for each cell between start and goal, until a plan is told to whoever asked, as JSON: some 110 bytes a pose.

That way is not measured here. Computed plans go it as well, so what is saved is less than what planning takes.
"""

CHECKING = 2e-4
CHECKED_PER_SECOND = 1e9
"""What is believed of checking a plan before it was measured: how long any takes [s], and bytes of poses [1/s]."""

Note = Callable[[PlannerHistory], None]


def unnoted(row: PlannerHistory) -> None:
    """Be the note of a home that keeps no history."""


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
        """Return how long it will take until a kept plan of this complexity is there, was checked and is told."""
        size = cells * BYTES_PER_CELL
        link, checking = self.link.expect(size), self.checking.expect(size)
        told = cells * TOLD_PER_CELL
        lower, upper = link.lower + checking.lower + told, link.upper + checking.upper + told
        return Estimate(link.mean + checking.mean + told, lower, upper, link.samples)


@dataclass(frozen=True, slots=True)
class Keeping:
    """What a home has of the plans that were made before, and whom it tells what became of requests.

    Parameters
    ----------
    map, version : str
        Of the map that it stands in.
    library : PlanLibrary
        Where plans are kept.
    times : Times
        What was measured.
    note : callable
        Told what became of each request.
    """

    map: str = ""
    version: str = ""
    library: PlanLibrary = field(default_factory=EmptyLibrary)
    times: Times = field(default_factory=Times)
    note: Note = unnoted

    def processor(
        self, bare: Costmap, robot_radius: float, parameters: ReuseParameters = ReuseParameters()
    ) -> "PlanProcessor":
        """Return a processor on the costmap of the map alone, for a robot of this radius [m]."""
        standing = Standing(self.map, self.version, bare, robot_radius)
        return PlanProcessor(standing, self.library, self.times, self.note, parameters=parameters)


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
        self._conditions: dict[Planner, tuple[Conditions, Conditions]] = {}

    def plan(self, planner: Planner, costmap: Costmap, request: PlanRequest, *, reuse: bool = True) -> PlanResult:
        """Return a plan that is kept, if it is expected to be there sooner, or compute one; raises as a planner does.

        Parameters
        ----------
        planner : Planner
            Who computes it, and whose like a kept one must be.
        costmap : Costmap
            As it is now; that of the map alone is known by being the same object.
        request : PlanRequest
            What to plan.
        reuse : bool
            Whether a kept plan will do.
        """
        cells, key = self._key(planner, request)
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
        return self._named(result, planner, bare=costmap is self._standing.bare)

    def compared(self, planner: Planner, request: PlanRequest, length: float, cheapest: float) -> None:
        """Take note of how long a computed plan is, and how long the cheapest one for the same request [m]."""
        self._note(compared_row(self._key(planner, request)[1], length, cheapest))

    def _key(self, planner: Planner, request: PlanRequest) -> tuple[float, tuple[str, str, str, int]]:
        """Return the complexity of a request, and what it is counted under."""
        standing = self._standing
        cells = complexity(request.start, request.goal, standing.bare.info.resolution)
        return cells, (standing.map, standing.version, planner.name, bucket_of(cells))

    def _named(self, result: PlanResult, planner: Planner, *, bare: bool) -> PlanResult:
        """Return a plan with its conditions and id."""
        made = replace(result, conditions=self._made_under(planner)[bare])
        return replace(made, id=plan_id(self._standing.map, self._standing.version, made))

    def _made_under(self, planner: Planner) -> tuple[Conditions, Conditions]:
        """Return the conditions of plans that a planner makes around what is seen, and on the bare map."""
        known = self._conditions.get(planner)
        if known is None:
            # As they come back from JSON, so that they can be compared with those that are kept.
            own = msgspec.json.decode(msgspec.json.encode(parameters_in_use(planner)))
            own[ROBOT_RADIUS] = self._standing.robot_radius
            known = self._conditions[planner] = own | {BARE_MAP: False}, own | {BARE_MAP: True}
        return known

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
        result = PlanResult(
            cells=made.cells, poses=made.poses, cost=made.cost, length=made.length, expanded=0,
            seconds=self._clock() - began, planner=planner.name, origin=made.origin, reused=made.source,
        )  # fmt: skip
        named = self._named(result, planner, bare=False)
        return replace(named, id=made.source) if made.as_kept else named

    def _look(self, planner: Planner, costmap: Costmap, request: PlanRequest, within: float) -> Offer | None:
        standing, p = self._standing, self._parameters
        question = Question(
            request.start, request.goal, standing.version, planner.name, own_parameters(self._made_under(planner)[0]),
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
