"""Parameters of Move Base."""

import math

from ppaas.errors import InvalidParameter
from ppaas.nodes.base import Parameters


class MoveBaseParameters(Parameters, frozen=True):
    """Parameters of Move Base with the names of move_base and rotate_recovery; hertz, seconds, metres, radians.

    Two defaults differ from move_base's: a robot across a network is controlled at 10 Hz instead of 20, and it plans
    anew once a second instead of only when control fails, so that it takes note of obstacles that came later.

    Parameters
    ----------
    base_global_planner, base_local_planner : str
        Names or ROS aliases of plug-ins.
    planner_frequency, controller_frequency : float
        How often to plan while driving (0: only when control fails), and how often to send a velocity [Hz].
    planner_patience, controller_patience : float
        How long plans or velocities may fail before recovery begins [s].
    max_planning_retries : int
        How many plans may fail before recovery begins; −1: as many as planner_patience allows.
    oscillation_timeout, oscillation_distance : float
        A robot that does not leave this distance [m] for so long oscillates [s]; 0: it never does.
    recovery_behavior_enabled, clearing_rotation_allowed : bool
        Whether to recover at all, and by turning on the spot.
    conservative_reset_dist : float
        The first recovery clears obstacles farther away than this [m].
    max_rotational_vel, min_rotational_vel, acc_lim_th : float
        Limits for turning on the spot [rad/s, rad/s, rad/s²].
    rotation_patience : float
        How long turning on the spot may take before it is given up [s].
    transform_tolerance : float
        How old the robot's pose may be, and its laser scan, before it is stopped [s].
    default_tolerance : float
        If the goal is blocked, a free place within this distance will do [m].
    planner_timeout : float
        Longest time for one plan [s].
    """

    base_global_planner: str = "dijkstra"
    base_local_planner: str = "dwa"
    planner_frequency: float = 1.0
    controller_frequency: float = 10.0
    planner_patience: float = 5.0
    controller_patience: float = 15.0
    max_planning_retries: int = -1
    oscillation_timeout: float = 0.0
    oscillation_distance: float = 0.5
    recovery_behavior_enabled: bool = True
    clearing_rotation_allowed: bool = True
    conservative_reset_dist: float = 3.0
    max_rotational_vel: float = 1.0
    min_rotational_vel: float = 0.4
    acc_lim_th: float = 3.2
    rotation_patience: float = 20.0
    transform_tolerance: float = 1.0
    default_tolerance: float = 0.0
    planner_timeout: float = 5.0

    def __post_init__(self) -> None:
        """Check the ranges."""
        above = (
            "controller_frequency", "max_rotational_vel", "acc_lim_th", "transform_tolerance", "planner_timeout",
            "rotation_patience",
        )  # fmt: skip
        for name in above:
            if not (math.isfinite(getattr(self, name)) and getattr(self, name) > 0.0):
                raise InvalidParameter(f"{name} must be above 0, not {getattr(self, name)}")
        from_zero = (
            "planner_frequency", "planner_patience", "controller_patience", "oscillation_timeout",
            "oscillation_distance", "conservative_reset_dist", "min_rotational_vel", "default_tolerance",
        )  # fmt: skip
        for name in from_zero:
            if not (math.isfinite(getattr(self, name)) and getattr(self, name) >= 0.0):
                raise InvalidParameter(f"{name} must be finite and not negative, not {getattr(self, name)}")
        if self.min_rotational_vel > self.max_rotational_vel:
            raise InvalidParameter("min_rotational_vel must not be above max_rotational_vel")
