"""Variants of a planning container: costmaps and planners for requests with their own parameters."""

from collections.abc import Mapping
from typing import Any

import msgspec

from ppaas.bounded import BoundedDict
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

MOST_PLANNERS = 2
"""Number of planners with parameters that are kept; each may hold a prepared map."""

MOST_COSTMAPS = 2
"""Number of costmaps with other parameters that are kept."""

ALLOW_UNKNOWN = "allow_unknown"

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
        self._planners: BoundedDict[tuple[str, bytes], Planner] = BoundedDict(MOST_PLANNERS)
        self._variants: BoundedDict[tuple[float, CostParameters], Variant] = BoundedDict(MOST_COSTMAPS)

    @property
    def usual(self) -> Variant:
        """The variant of requests without parameters."""
        return self._usual

    def planner(self, name: str, given: Given) -> Planner:
        """Return a planner with these parameters; ``Variants`` describes the errors."""
        costs, own = split(given)
        key = PLANNERS.own_name(name), msgspec.json.encode((costs, own), order="sorted")
        made = self._planners[key] = self._planners.get(key) or planner_with(_body(costs), name, own)
        return made

    def allows_unknown(self, given: Given) -> bool:
        """Return whether costs lead through unknown cells; ``Variants`` describes the errors."""
        _body(split(given)[0])
        return allows_unknown(given)

    def variant(self, given: Given) -> Variant:
        """Return the costmap for these parameters; ``Variants`` describes the errors."""
        parameters = split(given)[0]
        key = _body(parameters).robot_radius, costmap_parameters({COSTMAP: parameters}).costs
        if key == self._usual_key:
            return self._usual
        made = self._variants[key] = self._variants.get(key) or self._make(*key)
        return made

    def _make(self, radius: float, costs: CostParameters) -> Variant:
        costmap = recosted(self._layers, radius, costs)
        changed = costs.changed
        return Variant(costmap, self._reuse.processor(costmap, radius, filters={COSTMAP: changed} if changed else {}))


def _body(costs: Mapping[str, Any]) -> RobotModel:
    return robot_body(PLANNING_MODEL, None, {COSTMAP: costs})
