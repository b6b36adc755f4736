"""The parameters of the dynamic window, with the names and mostly the defaults of dwa_local_planner."""

from dataclasses import dataclass
from typing import ClassVar

from ppaas.controllers.drive_parameters import DriveParameters
from ppaas.errors import InvalidParameter


@dataclass(frozen=True, slots=True, kw_only=True)
class DwaParameters(DriveParameters):
    """What can be set, beside what all local planners have.

    Parameters
    ----------
    sim_time : float
        How far rollouts look ahead [s].
    sim_granularity : float
        Step of a rollout [m].
    vx_samples, vth_samples : int
        Forward and turning speeds tried.
    path_distance_bias, goal_distance_bias : float
        What a metre off the path, and a metre still to go, count.
    occdist_scale : float
        What a unit of the highest cost met counts.
    forward_point_distance : float
        A point so far in front of the robot should be on the path too [m].
    cost_slowdown : float
        Part of the speed that is taken off where the cost is highest, 0 to 1.
    rotate_threshold : float
        It turns on the spot if the path leads off by more than this [rad].
    robot_radius : float
        Of its disc [m]. Without a footprint collisions are read off the inflated costmap; this sets how far ahead it
        looks for the way the path leads, and how far it may go to leave an inscribed cell.

    Raises
    ------
    InvalidParameter
        One is no number, not finite or out of range; the text names it.
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
        DriveParameters.__post_init__(self)
        if self.cost_slowdown >= 1.0:
            raise InvalidParameter(f"cost_slowdown must be below 1, not {self.cost_slowdown}: the robot would stop")
