"""The Path Plan Processor of a container: a plan that is kept where that is sooner, else one that is computed."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import msgspec

from ppaas.clock import Clock, monotonic
from ppaas.costmap.costmap import Costmap
from ppaas.errors import PlanCancelled, PlanningError
from ppaas.planners.base import Planner, PlanRequest, PlanResult
from ppaas.plans.history import (
    PlannerHistory,
    bucket_of,
    compared_row,
    complexity,
    computed_row,
    failed_row,
    found_row,
)
from ppaas.plans.reuse.criteria import MARGIN, ReuseVerdict, by_time
from ppaas.plans.reuse.measured_times import LEAST, Times
from ppaas.plans.reuse.plan_ids import PlanIds
from ppaas.plans.reuse.stitching import BOUND, LiveAndBareCostmaps, Offer, offer
from ppaas.plans.stored import (
    BARE_MAP,
    ROBOT_RADIUS,
    Conditions,
    EmptyLibrary,
    PlanLibrary,
    PlanQuery,
    own_parameters,
)
from ppaas.plugins import parameters_in_use

Note = Callable[[PlannerHistory], None]

_Made = tuple[Conditions, PlanIds]

REFUSED_FOR = 1.0
"""Seconds for which it stays refused to look for plans as complex as one that is computed sooner."""


def discard_note(row: PlannerHistory) -> None:
    """Be the note of a home that keeps no history."""


@dataclass(frozen=True, slots=True)
class ReuseScope:
    """On what a container plans.

    Parameters
    ----------
    map, version : str
        Which it is.
    bare : Costmap
        Of the map alone.
    robot_radius : float
        Of the robot for which it is inflated [m].
    filters : mapping
        What else says where the robot is not to be, by name: costs are the same only for who has the same.
    """

    map: str
    version: str
    bare: Costmap
    robot_radius: float
    filters: Mapping[str, Any] = field(default_factory=dict)


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


@dataclass(frozen=True, slots=True)
class ReuseSetup:
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
    filters : mapping
        What keeps the robot out of places of the map, by name.
    """

    map: str = ""
    version: str = ""
    library: PlanLibrary = field(default_factory=EmptyLibrary)
    times: Times = field(default_factory=Times)
    note: Note = discard_note
    filters: Mapping[str, Any] = field(default_factory=dict)

    def processor(
        self, bare: Costmap, robot_radius: float, parameters: ReuseParameters = ReuseParameters()
    ) -> "PlanProcessor":
        """Return a processor on the costmap of the map alone, for a robot of this radius [m]."""
        standing = ReuseScope(self.map, self.version, bare, robot_radius, self.filters)
        return PlanProcessor(standing, self.library, self.times, self.note, parameters=parameters)


class PlanProcessor:
    """Plans with any planner, and looks first for a plan that is kept where that is expected to be sooner.

    Several threads may use it, each with a planner of its own.

    Parameters
    ----------
    standing : ReuseScope
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
        standing: ReuseScope,
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
        self.verdict = ReuseVerdict(False, "kept")
        self._made: dict[Planner, tuple[_Made, _Made]] = {}
        self._refused: dict[tuple[str, str, str, int], float] = {}

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
        if reuse and self._clock() >= self._refused.get(key, -math.inf):
            found = self._found(planner, costmap, request, cells)
            if found is not None:
                self._note(found_row(key, found.origin))
                return found
            if self.verdict.is_for_long:
                self._refused[key] = self._clock() + REFUSED_FOR
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
        """Return a computed plan with its conditions and id."""
        conditions, identity = self._made_under(planner)[bare]
        return msgspec.structs.replace(result, conditions=conditions, id=identity.of(result))

    def _made_under(self, planner: Planner) -> tuple[_Made, _Made]:
        """Return what plans have in common that a planner makes around what is seen, and on the bare map."""
        known = self._made.get(planner)
        if known is None:
            standing = self._standing
            # As they come back from JSON, so that they can be compared with those that are kept.
            own = msgspec.json.decode(msgspec.json.encode({**parameters_in_use(planner), **standing.filters}))
            own[ROBOT_RADIUS] = standing.robot_radius
            seen, bare = own | {BARE_MAP: False}, own | {BARE_MAP: True}
            place = standing.map, standing.version, planner.name
            known = (seen, PlanIds(*place, seen)), (bare, PlanIds(*place, bare))
            self._made[planner] = known
        return known

    def _found(self, planner: Planner, costmap: Costmap, request: PlanRequest, cells: float) -> PlanResult | None:
        """Return a kept plan, if it pays to look for one and there is one that will do."""
        computation = self._times.computation.expect(planner.name, cells)
        margin = self._parameters.margin
        quick = computation is not None and computation.lower < margin * LEAST.upper
        verdict = self.verdict = by_time(LEAST if quick else self._times.transmission(cells), computation, margin)
        if computation is None or not verdict.taken or not (request.start.is_finite() and request.goal.is_finite()):
            return None
        if not self._library.may_wait():
            raise PlanCancelled("this is begun again where it may wait for plans that are kept")
        began = self._clock()
        made = self._look(planner, costmap, request, computation.lower / margin)
        if made is None:
            return None
        conditions = self._made_under(planner)[False][0]
        result = PlanResult(
            cells=made.cells, poses=made.poses, cost=made.cost, length=made.length, expanded=0,
            seconds=self._clock() - began, planner=planner.name, origin=made.origin, reused=made.source,
            conditions=conditions,
        )  # fmt: skip
        own = made.source if made.as_kept else self._identity_of(made, planner).of(result)
        return msgspec.structs.replace(result, id=own)

    def _identity_of(self, made: Offer, planner: Planner) -> PlanIds:
        conditions, standing = self._made_under(planner)[False][0], self._standing
        return PlanIds(standing.map, standing.version, planner.name, conditions, origin=made.origin, reused=made.source)

    def _look(self, planner: Planner, costmap: Costmap, request: PlanRequest, within: float) -> Offer | None:
        standing, p = self._standing, self._parameters
        question = PlanQuery(
            request.start, request.goal, standing.version, planner.name,
            own_parameters(self._made_under(planner)[False][0]),
            standing.robot_radius, p.tolerance, kinematic=planner.traits.kinematic,
        )  # fmt: skip
        found = self._library.find(question, within)
        if not found:
            self.verdict = ReuseVerdict(False, "late" if found is None else "kept", {"within": within})
            return None
        ground = LiveAndBareCostmaps(
            costmap, standing.bare, allow_unknown=question.parameters.get("allow_unknown", True)
        )
        for stored in found:
            began = self._clock()
            made, self.verdict = offer(stored, question, ground, planner.traits, p.bound)
            self._times.checking.note(stored.poses.nbytes, self._clock() - began)
            if made is not None:
                return made
        return None
