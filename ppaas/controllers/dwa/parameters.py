"""Parameters of the dynamic window approach, with the names and most defaults of dwa_local_planner."""

from typing import ClassVar

from ppaas.controllers.drive_parameters import DriveParameters
from ppaas.errors import InvalidParameter


class DwaParameters(DriveParameters, frozen=True, kw_only=True):
    """Parameters in addition to the ones that all local planners have.

    Parameters
    ----------
    sim_time : float
        Duration of rollouts [s].
    sim_granularity : float
        Step of a rollout [m].
    vx_samples, vth_samples : int
        Number of forward and turning speeds tried.
    path_distance_bias, goal_distance_bias : float
        Weights of the distance to the path, and of the remaining distance along it [1/m].
    occdist_scale : float
        Weight of the highest cost on the rollout.
    forward_point_distance : float
        Distance in front of the robot of a second point that should be on the path [m].
    cost_slowdown : float
        Part by which the speed is reduced where the cost is highest, from 0 to below 1.
    rotate_threshold : float
        Angle to the path above which the robot turns in place [rad].
    robot_radius : float
        Radius of the robot [m]. Without a footprint, collisions are read from the inflated costmap; the radius then
        sets how far ahead the direction of the path is taken, and how far the robot may drive to leave an inscribed
        cell.

    Raises
    ------
    InvalidParameter
        A value is not a number, not finite or out of range; the text names the parameter.
    """

    POSITIVE: ClassVar[frozenset[str]] = DriveParameters.POSITIVE | {
        "min_vel_trans", "sim_time", "sim_granularity", "vx_samples", "vth_samples",
    }  # fmt: skip

    sim_time: float = 1.7
    sim_granularity: float = 0.025
    vx_samples: int = 8
    vth_samples: int = 20
    path_distance_bias: float = 32.0
    goal_distance_bias: float = 24.0
    occdist_scale: float = 0.1
    forward_point_distance: float = 0.2
    cost_slowdown: float = 0.5

    def __post_init__(self) -> None:
        """Check the ranges."""
        super().__post_init__()
        if self.cost_slowdown >= 1.0:
            raise InvalidParameter(
                f"cost_slowdown must be below 1, not {self.cost_slowdown}: the robot would stop near obstacles"
            )
