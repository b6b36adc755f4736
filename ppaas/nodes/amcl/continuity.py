"""Continuity checks of scans and odometry: late scans, clocks that are set back, and odometry that is reset."""

import logging
import math

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D

logger = logging.getLogger(__name__)

LATE = 1.0
"""Age relative to the newest odometry above which a scan is rejected, since the robot has moved on [s]."""

LONGEST_GAP = 5.0
"""Distance from the odometry of a checkpoint up to which a robot may have driven since, whatever the time [m]."""

SLACK, FASTEST = 1.0, 5.0
"""Odometry was reset if it jumped by more than `SLACK` [m] plus what `FASTEST` [m/s] allows."""

SILENCE, ORIGIN = 2.0, 0.05
"""A robot has restarted if no scan came for `SILENCE` [s], and its odometry is then within `ORIGIN` [m, rad] of zero
and more than `SLACK` away from the last."""

MOST_LASERS = 100
"""Largest number of lasers whose last stamps are known."""


def has_driven(metres: float, seconds: float | None) -> bool:
    """Return whether a robot whose odometry has changed since a checkpoint has driven; else odometry was reset.

    Parameters
    ----------
    metres : float
        Distance from the odometry of the checkpoint [m].
    seconds : float, optional
        Time since by the robot's clock [s]; None if it is not known.
    """
    return metres <= LONGEST_GAP or (seconds is not None and _can_drive(metres, seconds))


def _can_drive(metres: float, seconds: float) -> bool:
    return metres <= SLACK + FASTEST * max(seconds, 0.0)


class Continuity:
    """Stamps and odometry of the last scans that were used."""

    def __init__(self) -> None:
        self.odom: Pose2D | None = None
        self.stamp: float | None = None
        self._at = 0.0
        self._lasers: dict[str, float] = {}

    def check_stamp(self, stamp: float, newest: float | None, laser: str = "") -> None:
        """Reject a scan that is late or older than the last one of the same laser.

        If the clock was set back, the newest odometry is older than the last scan, too; then the scan is accepted.
        Scans of several lasers may come in any order.

        Parameters
        ----------
        stamp : float
            Stamp of the scan [s].
        newest : float or None
            Stamp of the newest odometry, if there is any [s].
        laser : str
            Frame of the laser.

        Raises
        ------
        InvalidInput
            The scan is late, or older than the last one.
        """
        if newest is not None and newest - stamp > LATE:
            raise InvalidInput(
                f"the scan was taken {newest - stamp:.1f} s before the newest odometry: send scans sooner, and stamp "
                "both with the same clock"
            )
        last = self._lasers.get(laser)
        if last is None or stamp >= last:
            return
        if newest is None or newest >= last:
            raise InvalidInput(
                f"the stamp of the scan is {last - stamp:.3f} s before that of the last one: send scans in the order "
                "in which they were taken"
            )
        logger.warning("the clock of the scans was set back by %.3f s; continuing from there", last - stamp)
        self._lasers.clear()

    def has_restarted(self, odom: Pose2D, now: float) -> bool:
        """Return whether the robot has restarted since the last scan, maybe elsewhere; call it before `note`.

        Parameters
        ----------
        odom : Pose2D
            Odometry at the time of the scan.
        now : float
            Time by the executor's clock [s].
        """
        if self.odom is None or now - self._at < SILENCE:
            return False
        begins = math.hypot(odom.x, odom.y) < ORIGIN and abs(odom.theta) < ORIGIN
        return begins and odom.distance_to(self.odom) > SLACK

    def note(self, odom: Pose2D, stamp: float, now: float, laser: str = "") -> Pose2D | None:
        """Record a scan that is used; return the odometry of the last one if it was reset since, otherwise None.

        Parameters
        ----------
        odom : Pose2D
            Odometry at the time of the scan.
        stamp : float
            Stamp of the scan [s].
        now : float
            Time by the executor's clock, since a robot that restarts also sets its own [s].
        laser : str
            Frame of the laser.
        """
        last, before = self.odom, self._at
        self.odom, self.stamp, self._at = odom, stamp, now
        if laser in self._lasers or len(self._lasers) < MOST_LASERS:
            self._lasers[laser] = stamp
        if last is None:
            return None
        apart = odom.distance_to(last)
        if _can_drive(apart, now - before):
            return None
        logger.warning("odometry jumped by %.2f m: taken as a reset of the odometry, not as a motion", apart)
        return last
