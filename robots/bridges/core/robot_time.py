"""Clock of the robot, by the stamps of its odometry: stamps of what the bridge sends are in the robot's time."""

from collections.abc import Mapping

from ppaas.clock import Clock


class RobotTime:
    """Estimate of the robot's clock.

    Parameters
    ----------
    clock : callable
        Monotonic clock [s].
    epoch : callable
        Clock of this computer [s since the epoch], for as long as the robot's is unknown.
    """

    def __init__(self, clock: Clock, epoch: Clock) -> None:
        self._clock, self._epoch = clock, epoch
        self._stamp: float | None = None
        self._at = 0.0

    def heard(self, stamp: Mapping[str, int], now: float) -> None:
        """Take a stamp of the robot that arrived at the time ``now`` [s]; zero is none."""
        seconds = stamp["sec"] + stamp["nanosec"] * 1e-9
        if seconds:
            self._stamp, self._at = seconds, now

    def now(self) -> dict[str, int]:
        """Return the time of the robot as a stamp."""
        seconds = self._epoch() if self._stamp is None else self._stamp + self._clock() - self._at
        return {"sec": int(seconds), "nanosec": int(seconds % 1.0 * 1e9)}
