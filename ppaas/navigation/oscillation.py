"""Telling whether a robot goes to and fro without getting anywhere."""

from ppaas.geometry import Pose2D


class Oscillation:
    """Watches how long a robot has not left its place.

    Parameters
    ----------
    distance : float
        What counts as leaving [m].
    timeout : float
        How long it may stay [s]; 0: for ever.
    """

    def __init__(self, distance: float, timeout: float) -> None:
        self._distance = distance
        self._timeout = timeout
        self._place: Pose2D | None = None
        self._since = 0.0

    def reset(self, now: float) -> None:
        """Begin to count anew."""
        self._since = now

    def has_left(self, now: float, pose: Pose2D) -> bool:
        """Take the robot's pose, and tell whether it has left its place since the last one it kept to."""
        if self._place is not None and pose.distance_to(self._place) < self._distance:
            return False
        self._place = pose
        self._since = now
        return True

    def timed_out(self, now: float) -> bool:
        """Tell whether it has stayed for too long."""
        return self._timeout > 0.0 and now - self._since > self._timeout
