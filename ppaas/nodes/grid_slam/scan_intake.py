"""Intake of scans: they are checked, cleared of other robots and thinned out; a status says why some are not."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.moving_obstacles import MovingObstacle
from ppaas.diagnosis.observations.scans import scan_facts
from ppaas.diagnosis.rules.scans import BLIND, missing_readings
from ppaas.diagnosis.rules.sensors import SCANS_ALONE
from ppaas.errors import PPaaSError, TransformError
from ppaas.geometry import Pose2D
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.live.live_mapper import LiveMapper
from ppaas.mapping.scan_points import ScanPoints, without_discs
from ppaas.messages.base.std_msgs import String
from ppaas.messages.ppaas_msgs import RobotStates
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.nodes import topics
from ppaas.nodes.amcl.continuity import Continuity
from ppaas.nodes.base import Context, Payload
from ppaas.nodes.frames import MAP, FrameListener
from ppaas.nodes.grid_slam.laser import MappingLaser
from ppaas.nodes.grid_slam.parameters import GridSlamParameters
from ppaas.nodes.message_checks import expect
from ppaas.nodes.other_robots import OTHERS_FRESH, others_of
from ppaas.nodes.robot_scans import RobotScan, ScanReader, WaitingScans
from ppaas.nodes.scan_odometry import ScanOdometry
from ppaas.nodes.scan_silence import ScanSilence

# -- publisher of ``grid_slam/status`` ---------------------------------------------------------------------------------


class StatusPublisher:
    """Publishes the status when it changes.

    Parameters
    ----------
    context : Context
        Of the node.

    Attributes
    ----------
    reported : str
        The newest status.
    """

    def __init__(self, context: Context) -> None:
        self._context, self.reported = context, ""

    def report(self, text: str) -> None:
        """Publish the reason for which scans or parts of the map are left out; empty if none is."""
        if text != self.reported:
            self.reported = text
            self._context.publish(topics.GRID_SLAM_STATUS.name, String(text))


def odometry_status(frames: FrameListener) -> str:
    """Return what a robot without odometry has to do without; empty if it has some."""
    return SCANS_ALONE if frames.is_without_odometry else ""


def lost_status(mapper: LiveMapper | None) -> str:
    """Return what to do for a robot that was carried away while it mapped; empty if its map is whole."""
    if mapper is None or mapper.parts.is_whole:
        return ""
    return "the robot was carried away: it maps where it is now until it recognizes a place where it was before"


def blindness_status(scan: LaserScan) -> str:
    """Return why a scan without a reading shows nothing, as the doctor says it, and what to do; empty if it shows some.

    Space without anything in range is unknown, unless ``inf_is_valid`` says that it is free.
    """
    problem = missing_readings(scan_facts(scan))
    if problem is None:
        return ""
    text, advice = problem
    return f"{BLIND}{text} {advice}"


# -- intake of scans ---------------------------------------------------------------------------------------------------


class ScanIntake:
    """Scans between their arrival and their use.

    Parameters
    ----------
    context : Context
        Of the node.
    frames : FrameListener
        Frames of the robot.
    parameters : GridSlamParameters
        Those that say which scans are used.
    status : StatusPublisher
        Where the reason is reported for which scans wait.

    Attributes
    ----------
    silence : ScanSilence
        Watches whether scans come and are used.
    scan_odometry : ScanOdometry
        Odometry of a robot that has none.
    """

    def __init__(
        self, context: Context, frames: FrameListener, parameters: GridSlamParameters, status: StatusPublisher
    ) -> None:
        self._context, self._frames, self._status = context, frames, status
        self._scans, self._waiting, self._continuity = ScanReader(frames, warns=True), WaitingScans(), Continuity()
        self.silence, self.scan_odometry = ScanSilence(frames), ScanOdometry(context, frames)
        self._every, self._least_interval = parameters.throttle_scans, parameters.least_interval
        self._count, self._used_at = 0, float("-inf")

    def add(self, message: LaserScan, laser: MappingLaser | None) -> None:
        """Check a scan, and keep it until `process`.

        Parameters
        ----------
        message : LaserScan
        laser : MappingLaser, optional
            Laser of the map; None if there is no map yet.

        Raises
        ------
        InvalidInput
            A number is not finite, the beams differ from the map's, or the scan is older than the last.
        TransformError
            The frame of the scan is unknown.
        """
        self.silence.scan_came(self._context.elapsed())
        self.scan_odometry.scan_came(message, self._waiting.oldest)
        scan, newest = self._scans.read(message, self._context.elapsed()), self._frames.newest()
        if laser is not None:
            laser.check(scan)
        if self.scan_odometry.assumes(scan.frame) and not self.scan_odometry.is_active:
            raise TransformError(
                f"no transform connects laser {scan.frame!r} with the robot, which has odometry now: publish "
                f"{self._frames.base!r} → {scan.frame!r} on 'tf_static'"
            )
        if scan.stamp:
            self._continuity.check_stamp(scan.stamp, newest, scan.frame)
        if newest is None:
            self._status.report(
                "scans wait for odometry: publish the transform of the robot in the odometry frame on 'tf'"
            )
        self._waiting.add(scan, newest)

    def process(self, use: Callable[[RobotScan, float], None]) -> list[PPaaSError]:
        """Use the scans that odometry has reached, each with its time [s]; return the errors of those not usable."""
        errors = self._waiting.process(self._frames.newest(), self._context.elapsed(), use)
        problem = self.silence.reason_ahead(self._waiting.problem, self._context.elapsed())
        if problem:
            self._status.report(problem)
        return errors

    def odometry(self, scan: RobotScan, stamp: float) -> tuple[Pose2D, Pose2D | None]:
        """Return the odometry at a scan, and if it was reset since the scan before, the odometry at the scan before.

        Raises
        ------
        TransformError
            The time of the scan [s] is older than what tf keeps.
        """
        odom = self._frames.odometry(stamp)
        self.silence.scan_used(self._context.elapsed())
        return odom, self._continuity.note(odom, stamp, self._context.elapsed(), scan.frame)

    def rebase(self, odometry: Pose2D) -> None:
        """Take it that the robot has not moved since the last scan, at a pose of other odometry."""
        self._continuity.odom = odometry

    def is_due(self, stamp: float) -> bool:
        """Return whether a scan is to be used by ``throttle_scans`` and ``minimum_time_interval``; count it."""
        self._count += 1
        if (self._count - 1) % self._every or abs(stamp - self._used_at) < self._least_interval:
            return False
        self._used_at = stamp
        return True

    def restart(self) -> None:
        """Use the next scan in any case: the map was cleared."""
        self._count, self._used_at = 0, float("-inf")


# -- other robots in the frame of a published map that is continued, or of a joint map ---------------------------------

RADIUS = 0.3
"""Radius of robots that do not report one [m]."""

SAME = 1e-6
"""Difference of the coordinates of equal poses [m, rad]."""


class OtherRobots:
    """Positions of other robots. They hold only while the map has the first key frame of the map in common.

    A robot that starts a separate map, by ``clear`` or another pose graph, is in a frame that the others do not know.

    Attributes
    ----------
    frame : str
        Name of the frame for the other robots: ``map`` on a published map, or the name of a joint map's frame.
    """

    def __init__(self) -> None:
        self.frame = MAP
        self._heard: tuple[float, tuple[MovingObstacle, ...]] = float("-inf"), ()
        self._first: tuple[NDArray[np.float32], NDArray[np.float64]] | None = None

    def use_frame_of(self, common: KeyFrames, frame: str = MAP) -> None:
        """Compare maps with this one from now on; positions that were heard before are forgotten."""
        self._first = common.points[0].copy(), common.poses[0].copy()
        if frame != self.frame:
            self.frame, self._heard = frame, (float("-inf"), ())

    def are_in(self, frames: KeyFrames) -> bool:
        """Return whether the poses of other robots are in the frame of a map."""
        if self._first is None or not len(frames):
            return False
        scan, pose = self._first
        return np.array_equal(frames.points[0], scan) and np.allclose(frames.poses[0], pose, atol=SAME)

    def hear(self, message: Payload, now: float) -> None:
        """Take the states of all other robots; raises as `ppaas.nodes.other_robots.others_of` does."""
        self._heard = now, others_of(expect(message, RobotStates), RADIUS)

    def cut_from(self, scan: ScanPoints, laser: Pose2D, frames: KeyFrames, now: float) -> ScanPoints:
        """Return a scan without the points on other robots.

        Parameters
        ----------
        scan : ScanPoints
        laser : Pose2D
            Expected pose of the laser in the map frame.
        frames : KeyFrames
            Key frames of the map.
        now : float
            Monotonic time [s].
        """
        at, robots = self._heard
        age = now - at
        if not robots or age > OTHERS_FRESH or not self.are_in(frames):
            return scan
        moved = (robot.after(age) for robot in robots)
        return without_discs(scan, laser, np.array([(robot.x, robot.y, robot.radius) for robot in moved]))
