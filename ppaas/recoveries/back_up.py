"""Recovery ``back_up``: backs up a short distance (``nav2_behaviors/back_up.hpp``)."""

from typing import Any, ClassVar

from ppaas.parameters import Parameters, read_parameters
from ppaas.recoveries.base import NotNegative, Positive
from ppaas.recoveries.straight import StraightRecovery


class BackUpParameters(Parameters, frozen=True):
    """Parameters of ``back_up``, with the names and values of Nav2's behaviour tree.

    Parameters
    ----------
    backup_dist : float
        Distance [m].
    backup_speed : float
        Speed [m/s].
    time_allowance : float
        Time limit [s].
    simulate_ahead_time : float
        Time ahead for which the robot must be free of collisions [s].
    """

    backup_dist: Positive = 0.3
    backup_speed: Positive = 0.15
    time_allowance: Positive = 10.0
    simulate_ahead_time: NotNegative = 2.0


class BackUpRecovery(StraightRecovery):
    """Drives straight back while the local costmap behind the robot is free.

    Parameters
    ----------
    **parameters
        The fields of `BackUpParameters`.
    """

    name: ClassVar[str] = "back_up"
    purpose: ClassVar[str] = "Backs up by backup_dist, as far as the costmap behind the robot is free."

    def __init__(self, **parameters: Any) -> None:
        p = self.parameters = read_parameters(BackUpParameters, self.name, parameters)
        super().__init__(
            p.backup_dist, -p.backup_speed, time_allowance=p.time_allowance, simulate_ahead_time=p.simulate_ahead_time
        )
