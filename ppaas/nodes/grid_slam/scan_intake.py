"""Intake of scans: they are checked, wait until odometry has reached their stamps, and are thinned out."""

from collections.abc import Callable

from ppaas.errors import PPaaSError, TransformError
from ppaas.geometry import Pose2D
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.nodes.amcl.continuity import Continuity
from ppaas.nodes.base import Context
from ppaas.nodes.frames import FrameListener
from ppaas.nodes.grid_slam.laser import MappingLaser
from ppaas.nodes.grid_slam.parameters import GridSlamParameters
from ppaas.nodes.grid_slam.status import StatusPublisher
from ppaas.nodes.robot_scans import RobotScan, ScanReader, WaitingScans
from ppaas.nodes.scan_odometry import ScanOdometry
from ppaas.nodes.scan_silence import ScanSilence


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
