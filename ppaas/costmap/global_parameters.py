"""Parameters of the global costmap, the costmap of a whole map that planners plan on.

This module does not load the kernels, since processes that only pass parameters on use it too.
"""

from ppaas.errors import InvalidParameter
from ppaas.maps.grid import OCCUPIED, OCCUPIED_THRESHOLD
from ppaas.parameters import Parameters

INFLATION_RADIUS = 0.55
"""Default inflation radius [m]."""

COST_SCALING_FACTOR = 10.0
"""Default decay rate of costs with the distance from an obstacle [1/m]."""

MAX_RADIUS = 100.0
"""Limit of a robot's radius and of the inflation radius [m]."""

MAX_FACTOR = 1e6
"""Limit of the cost scaling factor [1/m]."""


class CostParameters(Parameters, frozen=True):
    """Parameters of the costs of a map, named as in costmap_2d.

    Parameters
    ----------
    inflation_radius : float
        Distance from obstacles up to which cells have a cost [m].
    cost_scaling_factor : float
        Rate at which costs decay with the distance from an obstacle [1/m].
    lethal_cost_threshold : int
        Occupancy from which a cell of the map is an obstacle, 1 to 100.
    """

    inflation_radius: float = INFLATION_RADIUS
    cost_scaling_factor: float = COST_SCALING_FACTOR
    lethal_cost_threshold: int = OCCUPIED_THRESHOLD

    def __post_init__(self) -> None:
        """Check the ranges."""
        for name, most in (("inflation_radius", MAX_RADIUS), ("cost_scaling_factor", MAX_FACTOR)):
            if not 0.0 <= getattr(self, name) <= most:
                raise InvalidParameter(f"{name} must be from 0 to {most:g}, not {getattr(self, name)}")
        if not 1 <= self.lethal_cost_threshold <= OCCUPIED:
            raise InvalidParameter(
                f"lethal_cost_threshold must be from 1 to {OCCUPIED}, not {self.lethal_cost_threshold}"
            )

    @property
    def costs(self) -> "CostParameters":
        """These parameters alone, without the ones of subclasses."""
        return CostParameters(self.inflation_radius, self.cost_scaling_factor, self.lethal_cost_threshold)

    @property
    def changed(self) -> dict[str, float]:
        """The parameters of the costs that differ from their defaults, by name."""
        usual = CostParameters()
        names = CostParameters.__struct_fields__
        return {name: getattr(self, name) for name in names if getattr(self, name) != getattr(usual, name)}


class StaticLayerParameters(Parameters, frozen=True):
    """Parameters of the layer that is the map, named as in costmap_2d.

    Parameters
    ----------
    track_unknown_space : bool
        Whether unknown cells of the map are unknown to the robot; otherwise they are free.
    """

    track_unknown_space: bool = True


class GlobalCostmapParameters(CostParameters, frozen=True):
    """Parameters of the global costmap: of its costs, and the size of the robot.

    They are the same in a robot's file, in a request for a path, and on the command line.

    Parameters
    ----------
    robot_radius : float, optional
        Radius of the robot for the costmap and the controller [m]; default: the radius of the URDF or the model.
    footprint : tuple of (x, y)
        Corners of the outline [m]; without ``robot_radius``, the radius is the circumscribed circle's.
    """

    robot_radius: float | None = None
    footprint: tuple[tuple[float, float], ...] = ()
