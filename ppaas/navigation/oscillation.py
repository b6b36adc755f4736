"""Oscillation check: detects a robot that moves without getting anywhere."""

from ppaas.geometry import Pose2D


class Oscillation:
    """Measures how long a robot has stayed within a distance of one place.

    Parameters
    ----------
    distance : float
        Distance at which it has left the place [m].
    timeout : float
        Time for which it may stay [s]; 0 means forever.
    """

    def __init__(self, distance: float, timeout: float) -> None:
        self._distance = distance
        self._timeout = timeout
        self._place: Pose2D | None = None
        self._since = 0.0

    def reset(self, now: float) -> None:
        """Restart the timeout."""
        self._since = now

    def has_left(self, now: float, pose: Pose2D) -> bool:
        """Update the robot's pose; return whether it has left its last place."""
        if self._place is not None and pose.distance_to(self._place) < self._distance:
            return False
        self._place = pose
        self._since = now
        return True

    def timed_out(self, now: float) -> bool:
        """Return whether it has stayed longer than the timeout."""
        return self._timeout > 0.0 and now - self._since > self._timeout
