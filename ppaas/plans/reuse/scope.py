"""Scope and parameters of plan reuse: the map and robot of a container, and the conditions for a stored plan."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from ppaas.costmap.costmap import Costmap
from ppaas.plans.history import PlannerHistory
from ppaas.plans.reuse.criteria import MARGIN
from ppaas.plans.reuse.stitching import BOUND

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
