"""Clock of a robot, compared with the cloud's by the times at which its reports arrive."""

from ppaas.people.robot_tracks.clock_offsets import ClockOffset

LATENCY = 0.1
"""Usual time between a measurement and the arrival of its report [s]."""
SLOWEST = 0.35
"""Least latency of reports above which the robot's clock is taken to be late [s]."""
EARLIEST = -0.02
"""Least latency of reports below which the robot's clock is taken to be early [s]."""
WINDOW = 10.0
"""Time over which the least latency is taken, at least [s]."""
OLDEST = 2.0
"""Limit of the age of a measurement [s]."""


class RobotClock:
    """Offset of the clock of a robot.

    Stamps of a clock that agrees with the cloud's to some 0.3 s are taken unchanged: a delay of the network looks the
    same. A clock that is off by more is corrected so that the fastest reports have the usual latency.
    """

    def __init__(self) -> None:
        self._fastest = ClockOffset(WINDOW)

    def measured_at(self, stamp: float, now: float) -> float:
        """Return the time of a measurement by the cloud's clock [s].

        Parameters
        ----------
        stamp : float
            Its time by the robot's clock [s].
        now : float
            Time of arrival by the cloud's clock [s].
        """
        self._fastest.note(stamp, now)
        return min(max(stamp + self.offset, now - OLDEST), now)

    @property
    def offset(self) -> float:
        """Time to add to stamps [s]; 0 for a clock that agrees."""
        least = self._fastest.seconds
        return 0.0 if EARLIEST <= least <= SLOWEST else least - LATENCY
