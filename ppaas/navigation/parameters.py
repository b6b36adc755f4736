"""Parameters of Move Base, and the sequence of recovery behaviours that they give."""

import math
from typing import Any

from ppaas.errors import InvalidParameter
from ppaas.parameters import Parameters
from ppaas.plans.stored import LARGEST_TOLERANCE

MAX_RECOVERIES = 32
"""Largest number of recovery behaviours in the list."""


class RecoveryBehavior(Parameters, frozen=True):
    """One entry of Move Base's list of recovery behaviours.

    Parameters
    ----------
    name : str
        Name in status texts, and key of the behaviour's own parameters.
    type : str
        Name or ROS alias of a plug-in.
    """

    name: str
    type: str


class MoveBaseParameters(Parameters, frozen=True):
    """Parameters of Move Base, named as in move_base, in hertz, seconds, metres and radians.

    One default differs from move_base's: the robot plans again once a second instead of only when control fails, so
    that new obstacles are taken into account.

    Parameters
    ----------
    base_global_planner, base_local_planner : str
        Names or ROS aliases of plug-ins.
    planner_frequency, controller_frequency : float
        Rate of planning while driving (0: only when control fails), and of velocities [Hz].
    planner_patience, controller_patience : float
        Time for which planning or control may fail before recovery begins [s].
    max_planning_retries : int
        Number of plans that may fail before recovery begins; −1 means as many as planner_patience allows.
    oscillation_timeout, oscillation_distance : float
        A robot that stays within this distance [m] for this time [s] oscillates; 0 disables the check.
    recovery_behavior_enabled : bool
        Whether recovery behaviours run at all.
    recovery_behaviors : list of {name, type}, optional
        Behaviours in the order in which they are tried; one may occur several times. The default is move_base's:
        ``conservative_reset``, ``rotate_recovery``, ``aggressive_reset``, ``rotate_recovery``.
    clearing_rotation_allowed : bool
        Whether the default list includes ``rotate_recovery``.
    conservative_reset_dist : float
        Distance beyond which ``conservative_reset`` of the default list clears obstacles [m].
    transform_tolerance : float
        Largest age of the robot's pose and laser scan, above which it is stopped [s].
    default_tolerance : float
        Distance from a blocked goal within which a free position is accepted instead [m].
    planner_timeout : float
        Time limit of a plan [s].
    reuse_plans : bool
        Whether a stored plan may be used where that is faster than planning.
    reuse_tolerance : float
        Largest distance of the ends of such a plan from the robot and the goal [m]; the gaps are closed.
    reuse_bound : float
        Largest part by which the cost of such a plan may exceed the lowest cost.
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
    """Check that each behaviour has a name, that a name has one type, and that the list is not too long.

    Raises
    ------
    InvalidParameter
        One of these does not hold.
    """
    types: dict[str, str] = {}
    for each in behaviors:
        if not each.name:
            raise InvalidParameter(f"recovery_behaviors: the behaviour of type {each.type!r} has no name")
        if types.setdefault(each.name, each.type) != each.type:
            raise InvalidParameter(f"recovery_behaviors: {each.name!r} has two types; rename one of them")
    if len(behaviors) > MAX_RECOVERIES:
        raise InvalidParameter(f"recovery_behaviors: at most {MAX_RECOVERIES} are allowed, not {len(behaviors)}")


CONSERVATIVE = RecoveryBehavior("conservative_reset", "clear_costmap_recovery")
ROTATE = RecoveryBehavior("rotate_recovery", "rotate_recovery")
AGGRESSIVE = RecoveryBehavior("aggressive_reset", "clear_costmap_recovery")


def recovery_behaviors(parameters: MoveBaseParameters) -> tuple[RecoveryBehavior, ...]:
    """Return the behaviours in order (``loadRecoveryBehaviors``, ``loadDefaultRecoveryBehaviors``)."""
    if not parameters.recovery_behavior_enabled:
        return ()
    if parameters.recovery_behaviors is not None:
        return parameters.recovery_behaviors
    if not parameters.clearing_rotation_allowed:
        return CONSERVATIVE, AGGRESSIVE
    return CONSERVATIVE, ROTATE, AGGRESSIVE, ROTATE


def recovery_defaults(parameters: MoveBaseParameters) -> dict[str, dict[str, Any]]:
    """Return the parameters that move_base presets for the behaviours of its default list, by their names."""
    if parameters.recovery_behaviors is not None:
        return {}
    return {
        CONSERVATIVE.name: {"reset_distance": parameters.conservative_reset_dist},
        AGGRESSIVE.name: {"reset_distance": 0.0},
    }
