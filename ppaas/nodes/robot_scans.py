"""Scans of a robot: level, in its own frame, and kept until odometry has reached their time."""

import logging
import math
from collections.abc import Callable
from typing import Generic, NamedTuple, Protocol, TypeVar

from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.localization.beams import check_scan, excess_of
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.nodes.frames import BASE_FOOTPRINT, FrameListener
from ppaas.perception.level_scans import level_scan
from ppaas.transforms.planar import CACHE_TIME, MAX_TILT, USEFUL_TILT, tf_time

logger = logging.getLogger(__name__)

MOST_WAITING = 100
"""Largest number of scans that wait for transforms, as in amcl's message filter."""

MOST_AHEAD = 1.0
"""Time by which a scan may be ahead of the newest odometry [s]; lidars and bases have separate clocks."""

MOST_WARNED = 32
"""Largest number of lasers that are warned about."""


class RobotScan(NamedTuple):
    """Scan of a level laser.

    Parameters
    ----------
    scan : LaserScan
    laser : Pose2D
        Pose of the laser in the robot's frame.
    stamp : float
        Time of the scan, 0 for the newest odometry's [s].
    at : float
        Time of arrival, by the executor's clock [s].
    """

    scan: LaserScan
    laser: Pose2D
    stamp: float
    at: float

    @property
    def frame(self) -> str:
        """Frame of the laser."""
        return self.scan.header.frame_id.lstrip("/")


class ScanReader:
    """Checks the scans of a robot's lasers, and converts them by where each is mounted.

    Parameters
    ----------
    frames : FrameListener
        Frames of the robot.
    warns : bool
        Whether doubtful scans are logged, once per laser; one node of a robot suffices.
    """

    def __init__(self, frames: FrameListener, *, warns: bool = False) -> None:
        self._frames = frames
        self._warns = warns
        self._warned: set[str] = set()

    def read(self, scan: LaserScan, now: float) -> RobotScan:
        """Return a scan as a level laser would send it.

        Raises
        ------
        InvalidInput
            An angle or limit is not finite, the angles are not a scan's, or the laser is tilted too much.
        TransformError
            Its frame is unknown.
        """
        check_scan(scan)
        mount = self._frames.mount(scan.header.frame_id, now)
        ground = self._frames.height_of(BASE_FOOTPRINT) if mount.tilt > MAX_TILT else 0.0
        level, laser = level_scan(scan, mount, ground)
        if self._warns:
            self._warn(scan, mount.tilt)
        return RobotScan(level, laser, tf_time(scan.header.stamp), now)

    def _warn(self, scan: LaserScan, tilt: float) -> None:
        frame, excess = scan.header.frame_id, excess_of(scan)
        if not (excess or tilt > USEFUL_TILT) or frame in self._warned or len(self._warned) >= MOST_WARNED:
            return
        self._warned.add(frame)
        if excess:
            logger.warning(
                "scans of %r have %d ranges, %+.0f to what angle_max says: angle_min and angle_increment are believed",
                frame, len(scan.ranges), excess,
            )  # fmt: skip
        if tilt > USEFUL_TILT:
            logger.warning("laser %r is tilted by %.0f°: few of its beams see walls", frame, math.degrees(tilt))


class Stamped(Protocol):
    """Data of a sensor."""

    @property
    def stamp(self) -> float:
        """Time of the data, 0 for the newest odometry's [s]."""
        ...

    @property
    def at(self) -> float:
        """Time of arrival, by the executor's clock [s]."""
        ...


S = TypeVar("S", bound=Stamped)


class WaitingData(Generic[S]):
    """Data whose transforms have not come yet, as in tf2's message filter: the oldest is dropped if there is much.

    Data far ahead of the odometry is dropped, too: its clock is another, and when odometry reaches its stamp, the robot
    is elsewhere.

    Parameters
    ----------
    name : str
        Name of the data in texts.
    most : int
        Largest number that waits.

    Attributes
    ----------
    ahead : float
        Time by which scans that were dropped are ahead of the odometry, 0 as long as others are used [s].
    """

    def __init__(self, name: str = "scans", most: int = MOST_WAITING) -> None:
        self.ahead = 0.0
        self._name, self._most = name, most
        self._scans: list[S] = []
        self._newest = float("-inf")

    def add(self, scan: S, newest: float | None) -> None:
        """Add a scan; ``newest`` is the stamp of the newest odometry, None without odometry [s]."""
        ahead = 0.0 if newest is None else scan.stamp - newest
        if ahead > MOST_AHEAD:
            self.ahead = ahead
            return
        self._scans = [*self._scans, scan][-self._most :]

    @property
    def oldest(self) -> float | None:
        """Stamp of the oldest scan that waits [s]; None if none does."""
        return min((scan.stamp for scan in self._scans), default=None)

    @property
    def problem(self) -> str:
        """Reason why scans are dropped, and what to do; empty as long as others are used."""
        if not self.ahead:
            return ""
        return (
            f"{self._name} are stamped {self.ahead:.1f} s ahead of the newest odometry: stamp both with the same clock"
        )

    def process(self, newest: float | None, now: float, use: Callable[[S, float], None]) -> list[PPaaSError]:
        """Use the scans that odometry has reached, and return the errors of those that cannot be used.

        Parameters
        ----------
        newest, now : float
            See `ready`.
        use : callable
            Called with each scan and its time [s].
        """
        errors: list[PPaaSError] = []
        for scan in self.ready(newest, now):
            assert newest is not None
            try:
                use(scan, scan.stamp or newest)
            except PPaaSError as error:
                errors.append(error)
        return errors

    def ready(self, newest: float | None, now: float) -> list[S]:
        """Remove and return the scans that odometry has reached, in the order of their stamps.

        Scans that have waited as long as tf keeps transforms are dropped, and so are those from before the clock of the
        odometry was set back.

        Parameters
        ----------
        newest : float or None
            Stamp of the newest odometry; None without odometry [s].
        now : float
            Time by the executor's clock [s].
        """
        if not self._scans or newest is None:
            return []
        if newest < self._newest:
            self._scans = [scan for scan in self._scans if abs(scan.stamp - newest) < self._newest - newest]
        self._newest = newest
        recent = [scan for scan in self._scans if abs(now - scan.at) <= CACHE_TIME]
        reached = [scan for scan in recent if scan.stamp <= newest]
        if reached:
            self.ahead = 0.0
        self._scans = [scan for scan in recent if scan.stamp > newest]
        return sorted(reached, key=lambda scan: scan.stamp or newest)


class WaitingScans(WaitingData[RobotScan]):
    """Scans whose transforms have not come yet."""
