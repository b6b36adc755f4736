"""The parameters of the path integral controller: limits as base_local_planner names them, all else as Nav2's MPPI."""

from dataclasses import dataclass
from typing import ClassVar

from ppaas.controllers.drive_parameters import DriveParameters
from ppaas.errors import InvalidParameter

LEAST_SAMPLES, MOST_SAMPLES = 8, 1 << 16
MOST_STEPS = 1 << 10
MOST_DELAY = 2.0
"""A robot whose commands take longer [s] is not to be driven from afar."""

_BOUNDS = (
    ("batch_size", LEAST_SAMPLES, MOST_SAMPLES), ("time_steps", 1, MOST_STEPS), ("iteration_count", 1, 100),
    ("command_delay", 0.0, MOST_DELAY),
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class MppiParameters(DriveParameters):
    """What can be set, beside what all local planners have.

    Parameters
    ----------
    batch_size : int
        Sequences of commands that are tried each cycle.
    time_steps : int
        Commands of a sequence.
    model_dt : float
        How long each is kept [s].
    iteration_count : int
        How often a cycle improves the sequence.
    temperature : float
        How much dearer than the cheapest a sequence may be to count still [s].
    gamma : float
        What it costs to change the sequence kept from the last cycle, as a part of the temperature.
    vx_std, wz_std : float
        Standard deviations of the commands tried [m/s, rad/s].
    command_delay : float
        Until a command reaches the motors [s]; what was commanded in that time before is counted in.
    motor_lag : float
        Time constant with which the motors follow [s].
    collision_cost : float
        Of a sequence that touches something [s].
    collision_margin_distance : float
        Nearer than this to the middle of an occupied cell is touching it [m].
    critical_weight, critical_distance : float
        Seconds that a second without any clearance costs, and the clearance from which it costs nothing [m].
    repulsion_weight : float
        Seconds that a second at full speed costs beside an obstacle.
    inflation_length : float
        Clearance by which that falls to 1/e [m].
    prefer_forward_weight : float
        Seconds that a second backwards would cost at the speed of ``max_vel_x``: the laser may not see there.
    turn_weight : float
        What the seconds of a turn towards the way onwards count at the end of a sequence.
    moving_weight, moving_distance : float
        Seconds that a second costs in which it would touch one that moves, while it stands or drives on beside (driving
        up to it at full speed costs five times as much), and the distance from which it costs nothing [m].
    seed : int
        Of the commands tried; they are drawn once.

    Raises
    ------
    InvalidParameter
        One is no number, not finite or out of range; the text names it.
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
        DriveParameters.__post_init__(self)
        if not self.min_vel_x < self.max_vel_x:
            raise InvalidParameter("min_vel_x must be below max_vel_x")
        for name, least, most in _BOUNDS:
            if not least <= getattr(self, name) <= most:
                raise InvalidParameter(f"{name} must be from {least:g} to {most:g}, not {getattr(self, name)}")
