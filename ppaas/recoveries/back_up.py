"""Recovery ``back_up``: backs up a short distance (``nav2_behaviors/back_up.hpp``, ``drive_on_heading.hpp``)."""

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


class BackUpRecovery(Recovery):
    """Drives straight back while the local costmap behind the robot is free.

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
        """Record the pose and the time."""
        self._from = request.pose
        self._began = request.now

    def step(self, request: RecoveryRequest) -> Velocity | None:
        """Back up until the distance is driven.

        Raises
        ------
        RecoveryFailed
            There is an obstacle behind the robot, or the time limit has passed.
        """
        p = self.parameters
        driven = request.pose.distance_to(self._from)
        if driven >= p.backup_dist:
            return None
        if request.now - self._began > p.time_allowance:
            raise RecoveryFailed(f"backed up only {driven:.2f} m of {p.backup_dist:g} m in {p.time_allowance:g} s")
        back = Velocity(-p.backup_speed, 0.0)
        ahead = min(p.simulate_ahead_time, (p.backup_dist - driven) / p.backup_speed)
        if not is_free(request.costmap, request.pose, back, ahead, request.fits):
            raise RecoveryFailed(f"the space behind is not free after {driven:.2f} m of {p.backup_dist:g} m")
        return back
