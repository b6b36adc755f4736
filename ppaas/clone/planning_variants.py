"""Variants of a planning container: costmaps and planners for requests with their own parameters."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import msgspec

from ppaas.bounded import BoundedDict
from ppaas.buildings.planning.doors import door_lines, with_doors_shut
from ppaas.clone.outline_planning import planner_of
from ppaas.clone.robot_body import COSTMAP, costmap_parameters, robot_body
from ppaas.costmap.build_layers import recosted
from ppaas.costmap.global_parameters import CostParameters, GlobalCostmapParameters
from ppaas.costmap.map_layers import MapLayers
from ppaas.distribution import BrokenPlugin
from ppaas.errors import InvalidParameter
from ppaas.nodes.planner_server.variants import Given, Variant
from ppaas.planners.base import Planner
from ppaas.planners.registry import PLANNERS
from ppaas.plans.reuse.setup import ReuseSetup
from ppaas.robot_model.known_models import PLANNING_MODEL, RobotModel

if TYPE_CHECKING:
    from collections.abc import Callable

    from ppaas.planners.batch.path_lengths import PathLengths

MOST_PLANNERS = 2
"""Number of planners with parameters that are kept; each may hold a prepared map."""

MOST_COSTMAPS = 2
"""Number of costmaps with other parameters that are kept."""

ALLOW_UNKNOWN = "allow_unknown"

SHUT_DOORS = "shut_doors"
"""Parameter of paths and costs: whether the doors of the map, which are zones of it, count as walls."""

LENGTHS = "lengths"
"""Parameter of costs: whether they are the lengths of shortest paths, from an index of the map, instead [m]."""

_COSTMAP_NAMES = frozenset(GlobalCostmapParameters.__struct_fields__)


def split(given: Given) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the parameters of the global costmap and of the planner, from one table with both."""
    costs = {name: value for name, value in given.items() if name in _COSTMAP_NAMES}
    return costs, {name: value for name, value in given.items() if name not in _COSTMAP_NAMES}


def planner_with(body: RobotModel, name: str, parameters: dict[str, Any]) -> Planner:
    """Return a planner for a robot; errors list the parameters of the costmap too.

    Raises
    ------
    NotFound
        There is no planner of that name.
    InvalidParameter
        A parameter is unknown or invalid.
    BrokenPlugin
        The planner cannot be loaded.
    """
    try:
        return planner_of(body, name, parameters)
    except BrokenPlugin:
        raise
    except InvalidParameter as error:
        raise InvalidParameter(f"{error}; of the costmap: {', '.join(sorted(_COSTMAP_NAMES))}") from error


def allows_unknown(given: Given) -> bool:
    """Return whether the costs of paths lead through unknown cells, true by default.

    Raises
    ------
    InvalidParameter
        The parameter is not true or false, or there are others than it and the costmap's.
    """
    own = split(given)[1]
    allowed = own.pop(ALLOW_UNKNOWN, True)
    if own or not isinstance(allowed, bool):
        known = ", ".join(sorted((ALLOW_UNKNOWN, *_COSTMAP_NAMES)))
        wrong = (
            f"a cost matrix has no parameter {sorted(own)[0]!r}" if own else f"{ALLOW_UNKNOWN} must be true or false"
        )
        raise InvalidParameter(f"{wrong}; known: {known}")
    return allowed


class PlanningVariants:
    """Variants of a map for the planning model. A few are kept, the last used ones.

    Parameters
    ----------
    layers : MapLayers
        The map, inflated for the planning model.
    reuse : ReuseSetup
        Access to stored plans.
    """

    def __init__(self, layers: MapLayers, reuse: ReuseSetup) -> None:
        self._layers = layers
        self._reuse = reuse
        radius = robot_body(PLANNING_MODEL).robot_radius
        self._usual = Variant(layers.costmap, reuse.processor(layers.costmap, radius))
        self._usual_key = (radius, CostParameters())
        self._doors = door_lines(layers.zones)
        self._planners: BoundedDict[tuple[str, bytes], Planner] = BoundedDict(MOST_PLANNERS)
        self._variants: BoundedDict[tuple[float, CostParameters, bool], Variant] = BoundedDict(MOST_COSTMAPS)

    @property
    def usual(self) -> Variant:
        """The variant of requests without parameters."""
        return self._usual

    def planner(self, name: str, given: Given) -> Planner:
        """Return a planner with these parameters; ``Variants`` describes the errors."""
        costs, own = split(_without(given, SHUT_DOORS))
        key = PLANNERS.own_name(name), msgspec.json.encode((costs, own), order="sorted")
        made = self._planners[key] = self._planners.get(key) or planner_with(_body(costs), name, own)
        return made

    def allows_unknown(self, given: Given) -> bool:
        """Return whether costs lead through unknown cells; ``Variants`` describes the errors."""
        _body(split(given)[0])
        return allows_unknown(_without(given, SHUT_DOORS, LENGTHS))

    def lengths(self, given: Given, threads: int, check: "Callable[[], None]") -> "PathLengths | None":
        """Return what measures lengths, where costs are to be lengths; ``Variants`` describes the errors."""
        if not _is_set(given, LENGTHS):
            return None
        # Imported here: its kernels are not for every container.
        from ppaas.planners.batch.path_lengths import PathLengths  # noqa: PLC0415
        from ppaas.planners.hub_labels.planner import HubLabels  # noqa: PLC0415

        planner = self.planner(HubLabels.name, _without(given, LENGTHS))
        assert isinstance(planner, HubLabels)
        return PathLengths(self.variant(given).costmap, planner, threads=threads, check=check)

    def variant(self, given: Given) -> Variant:
        """Return the costmap for these parameters; ``Variants`` describes the errors."""
        parameters, shut = split(given)[0], _is_set(given, SHUT_DOORS) and bool(self._doors)
        key = _body(parameters).robot_radius, costmap_parameters({COSTMAP: parameters}).costs
        if key == self._usual_key and not shut:
            return self._usual
        made = self._variants[*key, shut] = self._variants.get((*key, shut)) or self._make(*key, shut=shut)
        return made

    def _make(self, radius: float, costs: CostParameters, *, shut: bool) -> Variant:
        usual = (radius, costs) == self._usual_key
        costmap = self._usual.costmap if usual else recosted(self._layers, radius, costs)
        filters: dict[str, Any] = {COSTMAP: costs.changed} if costs.changed else {}
        if shut:
            costmap, filters = with_doors_shut(costmap, self._doors), filters | {SHUT_DOORS: True}
        return Variant(costmap, self._reuse.processor(costmap, radius, filters=filters))


def _without(given: Given, *names: str) -> dict[str, Any]:
    """Return parameters without these, which must be true or false."""
    for name in names:
        _is_set(given, name)
    return {name: value for name, value in given.items() if name not in names}


def _is_set(given: Given, name: str) -> bool:
    value = given.get(name, False)
    if not isinstance(value, bool):
        raise InvalidParameter(f"{name} must be true or false")
    return value


def _body(costs: Mapping[str, Any]) -> RobotModel:
    return robot_body(PLANNING_MODEL, None, {COSTMAP: costs})
