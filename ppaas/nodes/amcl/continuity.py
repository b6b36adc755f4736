"""What breaks in a stream of scans and odometry: clocks that are set back, and bases that begin anew."""

import logging

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.transforms.planar import CACHE_TIME

logger = logging.getLogger(__name__)

LATE = 1.0
"""A scan that was taken longer than this before the newest odometry tells of a place that the robot has left [s]."""

LONGEST_GAP = 5.0
"""A robot whose odometry is farther than this from where it was at the checkpoint [m] has reset its odometry."""

SLACK, FASTEST = 1.0, 5.0
"""Odometry that is farther from the last than this [m], and than this speed [m/s] brings it, began anew."""


class Continuity:
    """The last scan that was used, and where odometry was then."""

    def __init__(self) -> None:
        self.odom: Pose2D | None = None
        self._stamp: float | None = None

    def check_stamp(self, stamp: float, newest: float | None) -> None:
        """Refuse a scan that is older than the last one, or late.

        A clock that was set back by more than tf keeps is believed.

        Parameters
        ----------
        stamp : float
            Of the scan [s].
        newest : float or None
            Of the newest odometry, if there is any [s].

        Raises
        ------
        InvalidInput
            It is older, or late.
        """
        if newest is not None and LATE < newest - stamp <= CACHE_TIME:
            raise InvalidInput(
                f"a scan was taken {newest - stamp:.1f} s before the newest odometry: send it sooner, and stamp both "
                "by one clock"
            )
        if self._stamp is None or stamp >= self._stamp:
            return
        if stamp >= self._stamp - CACHE_TIME:
            raise InvalidInput(
                f"the stamp of a scan is {self._stamp - stamp:.3f} s before that of the last one: scans must be "
                "sent in the order they were taken"
            )
        logger.warning("the clock of the scans went back by %.3f s: going on from there", self._stamp - stamp)
        self._stamp = None

    def note(self, odom: Pose2D, stamp: float) -> Pose2D | None:
        """Take note of a scan that is used; return where odometry was before, if it began anew since the last one."""
        last, before = self.odom, self._stamp
        self.odom, self._stamp = odom, stamp
        if last is None:
            return None
        apart = odom.distance_to(last)
        if apart <= SLACK + FASTEST * (stamp - before if before is not None else 0.0):
            return None
        logger.warning("odometry jumped by %.2f m: the base began anew, and its robot is where it was", apart)
        return last
