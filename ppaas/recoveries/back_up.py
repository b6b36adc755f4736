"""Backs up a little, if there is room behind (``nav2_behaviors/back_up.hpp``, ``drive_on_heading.hpp``)."""

from typing import Any, ClassVar

from ppaas.controllers.base import Velocity
from ppaas.geometry import Pose2D
from ppaas.parameters import Parameters, read_parameters
from ppaas.recoveries.base import NotNegative, Positive, Recovery, RecoveryFailed, RecoveryRequest
from ppaas.recoveries.free_motion import is_free


class BackUpParameters(Parameters, frozen=True):
    """Parameters of ``back_up``, with the names and values of Nav2's behaviour tree.

    Parameters
    ----------
    backup_dist : float
        How far [m].
    backup_speed : float
        How fast [m/s].
    time_allowance : float
        How long it may take before it is given up [s].
    simulate_ahead_time : float
        How far ahead the way must be free [s].
    """

    backup_dist: Positive = 0.3
    backup_speed: Positive = 0.15
    time_allowance: Positive = 10.0
    simulate_ahead_time: NotNegative = 2.0


class BackUpRecovery(Recovery):
    """Drives straight backwards, and only where the local costmap is free.

    Parameters
    ----------
    **parameters
        The fields of `BackUpParameters`.
    """

    name: ClassVar[str] = "back_up"
    purpose: ClassVar[str] = "Backs up by backup_dist, as far as the costmap behind the robot is free."

    def __init__(self, **parameters: Any) -> None:
        self.parameters = read_parameters(BackUpParameters, self.name, parameters)
        self._from = Pose2D(0.0, 0.0)
        self._began = 0.0

    def start(self, request: RecoveryRequest) -> None:
        """Take note of the place."""
        self._from = request.pose
        self._began = request.now

    def step(self, request: RecoveryRequest) -> Velocity | None:
        """Back up, until far enough.

        Raises
        ------
        RecoveryFailed
            The way back is not free, or it takes too long.
        """
        p = self.parameters
        gone = request.pose.distance_to(self._from)
        if gone >= p.backup_dist:
            return None
        if request.now - self._began > p.time_allowance:
            raise RecoveryFailed(f"backed up {gone:.2f} m of {p.backup_dist:g} m in {p.time_allowance:g} s")
        back = Velocity(-p.backup_speed, 0.0)
        ahead = min(p.simulate_ahead_time, (p.backup_dist - gone) / p.backup_speed)
        if not is_free(request.costmap, request.pose, back, ahead):
            raise RecoveryFailed(f"the way back is not free after {gone:.2f} m of {p.backup_dist:g} m")
        return back
