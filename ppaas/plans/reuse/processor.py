"""Path Plan Processor of a container: returns a stored plan if that is expected to be faster, else computes one.

Its scope is the map and robot of the container. Equal plans get equal ids, so a plan is stored once however often it is
made.
"""

import hashlib
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any
from weakref import WeakKeyDictionary

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
from ppaas.plans.reuse.stitching import BOUND, LiveAndBareCostmaps, Offer, offer
from ppaas.plans.reuse.time_estimates import FASTEST_RETRIEVAL, Times
from ppaas.plans.stored import (
    BARE_MAP,
    ROBOT_RADIUS,
    Conditions,
    Origin,
    PlanLibrary,
    PlanQuery,
    own_parameters,
)
from ppaas.plugins import parameters_in_use
from ppaas.tracing.spans import span


class PlanIds:
    """Computes the ids of plans made on one map version, by one planner, under the same conditions.

    Parameters
    ----------
    map_id, version, planner : str
        Map, its version, and planner.
    conditions : dict
        Conditions under which the plans are made.
    origin : Origin
        Origin of the plans.
    reused : str
        Id of the stored plan that they were made from; empty for computed plans.
    """

    def __init__(
        self,
        map_id: str,
        version: str,
        planner: str,
        conditions: Conditions,
        *,
        origin: Origin = "computed",
        reused: str = "",
    ) -> None:
        made_from = map_id, version, planner, origin, reused, sorted(conditions.items())
        self._prefix = hashlib.blake2b(msgspec.json.encode(made_from), digest_size=16)

    def of(self, result: PlanResult) -> str:
        """Return the id of a plan: a hash of its conditions, its end poses and the cells that it crosses.

        The poses between follow from these. Hashing them too would take longer than making many a plan.
        """
        digest = self._prefix.copy()
        digest.update(result.poses[:1].tobytes())
        digest.update(result.poses[-1:].tobytes())
        digest.update(result.cells.tobytes())
        return digest.hexdigest()


Note = Callable[[PlannerHistory], None]
"""Called with a history row for each request."""


@dataclass(frozen=True, slots=True)
class ReuseScope:
    """The map and robot that a container plans for.

    Parameters
    ----------
    map, version : str
        Map and its version. Plans for a map without a version are not stored.
    bare : Costmap
        Costmap of the map alone.
    robot_radius : float
        Robot radius for which it is inflated [m].
    filters : mapping
        Masks that restrict the robot and other parameters of its costmap, by name. Two robots have the same costs only
        if these are equal.
    """

    map: str
    version: str
    bare: Costmap
    robot_radius: float
    filters: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ReuseParameters:
    """Conditions for using a stored plan.

    Parameters
    ----------
    tolerance : float
        Largest distance between its ends and the requested ones [m].
    bound : float
        Largest excess cost, as a fraction of the cheapest cost.
    margin : float
        Factor by which getting it must be faster than computing.
    """

    tolerance: float = 0.25
    bound: float = BOUND
    margin: float = MARGIN


DEFAULTS = ReuseParameters()
"""Default conditions."""


_Common = tuple[Conditions, PlanIds]

REFUSAL_TIME = 1.0
"""Time for which searches of a complexity stay off after computing was faster [s]."""


class PlanProcessor:
    """Plans with any planner, and first searches for a stored plan if that is expected to be faster.

    Several threads may use it, each with its own planner.

    Parameters
    ----------
    scope : ReuseScope
        Map and robot.
    library : PlanLibrary
        Source of stored plans.
    times : Times
        Measured times.
    note : callable
        Called with a history row for each request.
    parameters : ReuseParameters
        Conditions for using a stored plan.
    clock : callable
        Monotonic clock [s].
    """

    def __init__(
        self,
        scope: ReuseScope,
        library: PlanLibrary,
        times: Times,
        note: Note,
        *,
        parameters: ReuseParameters = DEFAULTS,
        clock: Clock = monotonic,
    ) -> None:
        self._scope = scope
        self._library = library
        self._times = times
        self._note = note
        self._parameters = parameters
        self._clock = clock
        self.verdict = ReuseVerdict(False, "kept")
        self._by_planner = WeakKeyDictionary[Planner, tuple[_Common, _Common]]()
        self._refused: dict[tuple[str, str, str, int], float] = {}

    def plan(self, planner: Planner, costmap: Costmap, request: PlanRequest, *, reuse: bool = True) -> PlanResult:
        """Return a stored plan if it is expected to be faster, else a computed one; raises the planner's errors.

        Parameters
        ----------
        planner : Planner
            Planner that computes the plan. A stored plan must match it.
        costmap : Costmap
            The current costmap. The costmap of the map alone is recognized by identity.
        request : PlanRequest
            The request.
        reuse : bool
            Whether a stored plan may be returned.

        Raises
        ------
        PlanCancelled
            This thread must not wait for stored plans: run the request again in one that may.
        """
        with span("plan", {"ppaas.planner": planner.name}) as planning:
            result = self._plan(planner, costmap, request, reuse=reuse)
            planning.set({"ppaas.plan.origin": result.origin, "ppaas.plan.length": result.length})
            return result

    def _plan(self, planner: Planner, costmap: Costmap, request: PlanRequest, *, reuse: bool) -> PlanResult:
        cells, key = self._key(planner, request)
        if reuse and self._clock() >= self._refused.get(key, -math.inf):
            found = self._reused(planner, costmap, request, cells)
            if found is not None:
                self._note(found_row(key, found.origin))
                return found
            if self.verdict.is_lasting:
                self._refused[key] = self._clock() + REFUSAL_TIME
        try:
            with span("computation", {"ppaas.planner": planner.name}):
                result = planner.plan(costmap, request)
        except PlanCancelled:
            raise  # a cancellation is no failure of the planner
        except PlanningError:
            self._note(failed_row(key))
            raise
        self._times.computation.note(planner.name, cells, result.seconds)
        self._note(computed_row(key, result.seconds))
        return self._with_id(result, planner, bare=costmap is self._scope.bare)

    def compared(self, planner: Planner, request: PlanRequest, length: float, cheapest: float) -> None:
        """Record the lengths of a computed plan and of the cheapest one for the same request [m]."""
        self._note(compared_row(self._key(planner, request)[1], length, cheapest))

    def _key(self, planner: Planner, request: PlanRequest) -> tuple[float, tuple[str, str, str, int]]:
        """Return the complexity of a request [cells], and the key of its history row."""
        scope = self._scope
        cells = complexity(request.start, request.goal, scope.bare.info.resolution)
        return cells, (scope.map, scope.version, planner.name, bucket_of(cells))

    def _with_id(self, result: PlanResult, planner: Planner, *, bare: bool) -> PlanResult:
        """Return a computed plan with its conditions, and its id if the map has a version."""
        conditions, ids = self._common(planner)[bare]
        own = ids.of(result) if self._scope.version else ""
        return msgspec.structs.replace(result, conditions=conditions, id=own)

    def _common(self, planner: Planner) -> tuple[_Common, _Common]:
        """Return conditions and ids of a planner's plans: on live costmaps, and on the bare map."""
        known = self._by_planner.get(planner)
        if known is None:
            scope = self._scope
            # Through JSON, so that they compare equal with stored conditions.
            own = msgspec.json.decode(msgspec.json.encode({**parameters_in_use(planner), **scope.filters}))
            own[ROBOT_RADIUS] = scope.robot_radius
            seen, bare = own | {BARE_MAP: False}, own | {BARE_MAP: True}
            place = scope.map, scope.version, planner.name
            known = (seen, PlanIds(*place, seen)), (bare, PlanIds(*place, bare))
            self._by_planner[planner] = known
        return known

    def _reused(self, planner: Planner, costmap: Costmap, request: PlanRequest, cells: float) -> PlanResult | None:
        computation = self._times.computation.expect(planner.name, cells)
        margin = self._parameters.margin
        # A plan that is computed faster than any link answers needs no estimate of the link.
        quick = computation is not None and computation.lower < margin * FASTEST_RETRIEVAL.upper
        verdict = self.verdict = by_time(
            FASTEST_RETRIEVAL if quick else self._times.transmission(cells), computation, margin
        )
        if computation is None or not verdict.taken or not (request.start.is_finite() and request.goal.is_finite()):
            return None
        if not self._library.may_wait():
            raise PlanCancelled("this thread cannot wait for stored plans; the request restarts in one that can")
        began = self._clock()
        with span("search for a stored plan"):
            candidate = self._search(planner, costmap, request, computation.lower / margin)
        if candidate is None:
            return None
        conditions = self._common(planner)[False][0]
        result = PlanResult(
            cells=candidate.cells, poses=candidate.poses, cost=candidate.cost, length=candidate.length, expanded=0,
            seconds=self._clock() - began, planner=planner.name, origin=candidate.origin, reused=candidate.source,
            conditions=conditions,
        )  # fmt: skip
        # Unchanged, it is the same plan: another id would store it twice.
        own = candidate.source if candidate.as_kept else self._ids_of(candidate, planner).of(result)
        return msgspec.structs.replace(result, id=own)

    def _ids_of(self, candidate: Offer, planner: Planner) -> PlanIds:
        conditions, scope = self._common(planner)[False][0], self._scope
        return PlanIds(
            scope.map, scope.version, planner.name, conditions, origin=candidate.origin, reused=candidate.source
        )

    def _search(self, planner: Planner, costmap: Costmap, request: PlanRequest, within: float) -> Offer | None:
        scope, p = self._scope, self._parameters
        query = PlanQuery(
            request.start, request.goal, scope.version, planner.name,
            own_parameters(self._common(planner)[False][0]),
            scope.robot_radius, p.tolerance, kinematic=planner.traits.kinematic,
        )  # fmt: skip
        found = self._library.find(query, within)
        if not found:
            self.verdict = ReuseVerdict(False, "late" if found is None else "kept", {"within": within})
            return None
        costmaps = LiveAndBareCostmaps(costmap, scope.bare, allow_unknown=query.parameters.get("allow_unknown", True))
        for stored in found:
            began = self._clock()
            candidate, self.verdict = offer(stored, query, costmaps, planner.traits, p.bound)
            self._times.checking.note(stored.poses.nbytes, self._clock() - began)
            if candidate is not None:
                return candidate
        return None
