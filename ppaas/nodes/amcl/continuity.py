"""Continuity checks of scans and odometry: late scans, clocks that are set back, and odometry that is reset."""

import logging

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.transforms.planar import CACHE_TIME

logger = logging.getLogger(__name__)

LATE = 1.0
"""Age relative to the newest odometry above which a scan is rejected, since the robot has moved on [s]."""

LONGEST_GAP = 5.0
"""Distance from the odometry of the checkpoint above which odometry was reset in the meantime [m]."""

SLACK, FASTEST = 1.0, 5.0
"""Odometry was reset if it jumped by more than `SLACK` [m] plus what `FASTEST` [m/s] allows."""


class Continuity:
    """Stamp and odometry of the last scan that was used."""

    def __init__(self) -> None:
        self.odom: Pose2D | None = None
        self._stamp: float | None = None

    def check_stamp(self, stamp: float, newest: float | None) -> None:
        """Reject a scan that is late or older than the last one.

        A clock that was set back by more than the time that tf keeps is accepted.

        Parameters
        ----------
        stamp : float
            Stamp of the scan [s].
        newest : float or None
            Stamp of the newest odometry, if there is any [s].

        Raises
        ------
        InvalidInput
            The scan is late, or older than the last one.
        """
        if newest is not None and LATE < newest - stamp <= CACHE_TIME:
            raise InvalidInput(
                f"the scan was taken {newest - stamp:.1f} s before the newest odometry: send scans sooner, and stamp "
                "both with the same clock"
            )
        if self._stamp is None or stamp >= self._stamp:
            return
        if stamp >= self._stamp - CACHE_TIME:
            raise InvalidInput(
                f"the stamp of the scan is {self._stamp - stamp:.3f} s before that of the last one: send scans in the "
                "order in which they were taken"
            )
        logger.warning("the clock of the scans was set back by %.3f s; continuing from there", self._stamp - stamp)
        self._stamp = None

    def note(self, odom: Pose2D, stamp: float) -> Pose2D | None:
        """Record a scan that is used; return the odometry of the last one if it was reset since, otherwise None."""
        last, before = self.odom, self._stamp
        self.odom, self._stamp = odom, stamp
        if last is None:
            return None
        apart = odom.distance_to(last)
        if apart <= SLACK + FASTEST * (stamp - before if before is not None else 0.0):
            return None
        logger.warning("odometry jumped by %.2f m: taken as a reset of the odometry, not as a motion", apart)
        return last
