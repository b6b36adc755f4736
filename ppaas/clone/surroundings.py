"""Surroundings of a clone: creates the local costmap and the memory of obstacles for a robot's body."""

from ppaas.costmap.global_parameters import CostParameters
from ppaas.costmap.inflation_layer import COST_SCALING_FACTOR, INFLATION_RADIUS
from ppaas.costmap.local_costmap import LocalCostmap
from ppaas.costmap.map_layers import MapLayers
from ppaas.costmap.obstacle_layer import RAYTRACE_RANGE
from ppaas.costmap.obstacle_memory import ObstacleMemory
from ppaas.errors import InvalidParameter
from ppaas.nodes.frames import FrameNames
from ppaas.nodes.move_base.people import RecentPeople, SocialLayerParameters
from ppaas.nodes.move_base.surroundings import Surroundings
from ppaas.parameters import Parameters
from ppaas.perception.tracking import MovingObjects
from ppaas.robot_model.known_models import RobotModel

MAX_PUBLISH_FREQUENCY = 10.0
"""Limit of the rate at which the local costmap is published [Hz]."""


class LocalCostmapParameters(Parameters, frozen=True):
    """Parameters of the local costmap, named as in costmap_2d [m, 1/m].

    ``footprint_padding`` is added to the robot's radius around observed obstacles: the centre of a cell is marked, so
    an obstacle may be half a cell nearer than marked. ``obstacle_range`` is 2.5 m in costmap_2d, less than
    ``raytrace_range``; here it is larger, because beams that clear cells but may not mark them would erase obstacles.
    ``publish_frequency`` is the rate at which subscribers get the costmap and the footprint [Hz]; 0 for never.
    """

    width: float = 6.0
    height: float = 6.0
    footprint_padding: float = 0.03
    inflation_radius: float = INFLATION_RADIUS
    cost_scaling_factor: float = COST_SCALING_FACTOR
    obstacle_range: float = 3.2
    raytrace_range: float = RAYTRACE_RANGE
    publish_frequency: float = 1.0

    def __post_init__(self) -> None:
        """Check the range of the rate; the window checks the others."""
        if not 0.0 <= self.publish_frequency <= MAX_PUBLISH_FREQUENCY:
            raise InvalidParameter(
                f"publish_frequency must be from 0 to {MAX_PUBLISH_FREQUENCY:g} Hz, not {self.publish_frequency}"
            )


def surroundings_of(
    layers: MapLayers,
    body: RobotModel,
    parameters: LocalCostmapParameters,
    social: SocialLayerParameters,
    *,
    costs: CostParameters,
    tolerance: float,
    names: FrameNames,
    by_robot: bool = False,
) -> Surroundings:
    """Return the surroundings of a robot with this body on the map of these layers.

    ``costs`` are the map's costs, which remembered obstacles get too; with ``by_robot`` the robot localizes itself.
    """
    radius = body.robot_radius + parameters.footprint_padding
    window = LocalCostmap(
        layers,
        width=parameters.width,
        height=parameters.height,
        robot_radius=radius,
        inflation_radius=parameters.inflation_radius,
        cost_scaling_factor=parameters.cost_scaling_factor,
        obstacle_range=parameters.obstacle_range,
        raytrace_range=parameters.raytrace_range,
        social=social.proxemics(),
        footprint=() if body.inner_radius is None else body.footprint,
        inner_radius=None if body.inner_radius is None else body.inner_radius + parameters.footprint_padding,
    )
    memory = ObstacleMemory(
        layers,
        robot_radius=radius,
        inflation_radius=costs.inflation_radius,
        cost_scaling_factor=costs.cost_scaling_factor,
    )
    surroundings = Surroundings(
        window, memory, body.robot_radius,
        people=RecentPeople(social), moving=MovingObjects(layers), tolerance=tolerance, names=names,
    )  # fmt: skip
    if by_robot:
        surroundings.expect_no_scans()
    return surroundings
