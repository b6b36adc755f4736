"""Parameters of Move Base."""

import math

from ppaas.errors import InvalidParameter
from ppaas.parameters import Parameters
from ppaas.plans.stored import LARGEST_TOLERANCE

MAX_RECOVERIES = 32
"""Most recovery behaviours in a row."""


class RecoveryBehavior(Parameters, frozen=True):
    """One of Move Base's recovery behaviours.

    Parameters
    ----------
    name : str
        What it is called in status texts, and what its own parameters are given under.
    type : str
        Name or ROS alias of a plug-in.
    """

    name: str
    type: str


class MoveBaseParameters(Parameters, frozen=True):
    """Parameters of Move Base with the names of move_base; hertz, seconds, metres, radians.

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
    recovery_behavior_enabled : bool
        Whether to recover at all.
    recovery_behaviors : list of {name, type}, optional
        What to try, in order. One may come again, under its name or under another. Without the list those of
        move_base: ``conservative_reset``, ``rotate_recovery``, ``aggressive_reset``, ``rotate_recovery``.
    clearing_rotation_allowed : bool
        Whether those of move_base include turning on the spot.
    conservative_reset_dist : float
        The first of those of move_base clears obstacles farther away than this [m].
    transform_tolerance : float
        How old the robot's pose may be, and its laser scan, before it is stopped [s].
    default_tolerance : float
        If the goal is blocked, a free place within this distance will do [m].
    planner_timeout : float
        Longest time for one plan [s].
    reuse_plans : bool
        Whether a plan that is kept will do where it comes sooner than one that is computed.
    reuse_tolerance : float
        How far the ends of such a plan may be from the robot and the goal [m]; they are joined.
    reuse_bound : float
        By how much of the cheapest cost such a plan may be dearer.
    """

    base_global_planner: str = "dijkstra"
    base_local_planner: str = "dwa"
    planner_frequency: float = 1.0
    controller_frequency: float = 20.0
    planner_patience: float = 5.0
    controller_patience: float = 15.0
    max_planning_retries: int = -1
    oscillation_timeout: float = 0.0
    oscillation_distance: float = 0.5
    recovery_behavior_enabled: bool = True
    recovery_behaviors: tuple[RecoveryBehavior, ...] | None = None
    clearing_rotation_allowed: bool = True
    conservative_reset_dist: float = 3.0
    transform_tolerance: float = 1.0
    default_tolerance: float = 0.0
    planner_timeout: float = 5.0
    reuse_plans: bool = True
    reuse_tolerance: float = 0.25
    reuse_bound: float = 0.05

    def __post_init__(self) -> None:
        """Check the ranges."""
        for name in ("controller_frequency", "transform_tolerance", "planner_timeout"):
            if not (math.isfinite(getattr(self, name)) and getattr(self, name) > 0.0):
                raise InvalidParameter(f"{name} must be above 0, not {getattr(self, name)}")
        from_zero = (
            "planner_frequency", "planner_patience", "controller_patience", "oscillation_timeout",
            "oscillation_distance", "conservative_reset_dist", "default_tolerance", "reuse_tolerance", "reuse_bound",
        )  # fmt: skip
        for name in from_zero:
            if not (math.isfinite(getattr(self, name)) and getattr(self, name) >= 0.0):
                raise InvalidParameter(f"{name} must be finite and not negative, not {getattr(self, name)}")
        if self.reuse_tolerance > LARGEST_TOLERANCE:
            raise InvalidParameter(f"reuse_tolerance must be at most {LARGEST_TOLERANCE} m, not {self.reuse_tolerance}")
        check_behaviors(self.recovery_behaviors or ())


def check_behaviors(behaviors: tuple[RecoveryBehavior, ...]) -> None:
    """Check that each has a name, that names mean one thing, and that there is an end to them.

    Raises
    ------
    InvalidParameter
        Not so.
    """
    types: dict[str, str] = {}
    for each in behaviors:
        if not each.name:
            raise InvalidParameter(f"recovery_behaviors: that of type {each.type!r} has no name")
        if types.setdefault(each.name, each.type) != each.type:
            raise InvalidParameter(f"recovery_behaviors: {each.name!r} is of two types; give one another name")
    if len(behaviors) > MAX_RECOVERIES:
        raise InvalidParameter(f"recovery_behaviors: at most {MAX_RECOVERIES} may be tried, not {len(behaviors)}")
