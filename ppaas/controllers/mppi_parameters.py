"""Parameters of the path integral controller: limits named as in base_local_planner, all others as in Nav2's MPPI."""

from typing import ClassVar

from ppaas.controllers.drive_parameters import DriveParameters
from ppaas.errors import InvalidParameter

LEAST_SAMPLES, MOST_SAMPLES = 8, 1 << 16
MOST_STEPS = 1 << 10
MOST_DELAY = 2.0
"""Largest ``command_delay`` [s]; a robot with a longer one must not be driven remotely."""

_BOUNDS = (
    ("batch_size", LEAST_SAMPLES, MOST_SAMPLES), ("time_steps", 1, MOST_STEPS), ("iteration_count", 1, 100),
    ("command_delay", 0.0, MOST_DELAY),
)  # fmt: skip


class MppiParameters(DriveParameters, frozen=True, kw_only=True):
    """Parameters in addition to the ones that all local planners have. Costs are in seconds of travel time.

    Parameters
    ----------
    batch_size : int
        Number of command sequences tried in each cycle.
    time_steps : int
        Number of commands in a sequence.
    model_dt : float
        Duration of each command [s].
    iteration_count : int
        Number of improvements of the sequence in each cycle.
    temperature : float
        Cost above the cheapest sequence at which a sequence's weight falls to 1/e [s].
    gamma : float
        Cost of changing the sequence of the last cycle, relative to the temperature.
    vx_std, wz_std : float
        Standard deviations of the commands tried [m/s, rad/s].
    command_delay : float
        Time until a command reaches the motors [s]; the commands sent during that time are taken into account.
    motor_lag : float
        Time constant with which the motors follow [s].
    collision_cost : float
        Cost of a sequence that touches an obstacle [s].
    collision_margin_distance : float
        Distance to the centre of an occupied cell below which the robot touches it [m].
    critical_weight, critical_distance : float
        Cost rate at zero clearance [s/s], and the clearance from which it is zero [m].
    repulsion_weight : float
        Cost rate of full speed beside an obstacle [s/s].
    inflation_length : float
        Clearance at which that rate falls to 1/e [m].
    prefer_forward_weight : float
        Cost rate of reversing at a speed of ``max_vel_x`` [s/s]: the laser may not see behind.
    turn_weight : float
        Weight of the time of a turn towards the path at the end of a sequence.
    moving_weight, moving_distance : float
        Cost rate of touching a moving obstacle while standing or driving beside it [s/s], five times as high when
        driving towards it at full speed; and the distance from which it is zero [m].
    seed : int
        Seed of the deviations, which are drawn once.

    Raises
    ------
    InvalidParameter
        A value is not a number, not finite or out of range; the text names the parameter.
    """

    POSITIVE: ClassVar[frozenset[str]] = DriveParameters.POSITIVE | {
        "batch_size", "time_steps", "model_dt", "temperature", "vx_std", "wz_std", "critical_distance",
        "inflation_length", "moving_distance",
    }  # fmt: skip

    batch_size: int = 600
    time_steps: int = 30
    model_dt: float = 0.05
    iteration_count: int = 1
    temperature: float = 0.05
    gamma: float = 0.015
    vx_std: float = 0.4
    wz_std: float = 0.8
    command_delay: float = 0.1
    motor_lag: float = 0.0
    collision_cost: float = 100.0
    collision_margin_distance: float = 0.03
    critical_weight: float = 1.5
    critical_distance: float = 0.08
    repulsion_weight: float = 12.0
    inflation_length: float = 0.1
    prefer_forward_weight: float = 5.0
    turn_weight: float = 1.0
    moving_weight: float = 20.0
    moving_distance: float = 0.3
    seed: int = 0

    def __post_init__(self) -> None:
        """Check the ranges."""
        super().__post_init__()
        if not self.min_vel_x < self.max_vel_x:
            raise InvalidParameter("min_vel_x must be below max_vel_x")
        for name, least, most in _BOUNDS:
            if not least <= getattr(self, name) <= most:
                raise InvalidParameter(f"{name} must be from {least:g} to {most:g}, not {getattr(self, name)}")
