"""Text of logs of CARMEN, from simulated drives."""

import math

from benchmarks.mapping.simulated_drive import SimulatedDrive
from ppaas.geometry import Pose2D
from ppaas.mapping.relations import Relations
from ppaas.planar_poses import relative

NO_RANGE = 81.91


def carmen_log(drive: SimulatedDrive) -> str:
    """Return a log of ``FLASER`` lines, with the poses of the odometry."""
    return "".join(_line(drive, row) for row in range(len(drive.log)))


def _line(drive: SimulatedDrive, row: int) -> str:
    log = drive.log
    robot = Pose2D(*log.odometry[row].tolist())
    laser = robot @ log.geometry.mount
    ranges = " ".join(f"{NO_RANGE if math.isnan(value) else value:.2f}" for value in log.ranges[row].tolist())
    poses = " ".join(f"{value:.6f}" for pose in (laser, robot) for value in pose)
    return f"FLASER {len(log.ranges[row])} {ranges} {poses} {log.stamps[row]:.6f} robot {log.stamps[row]:.6f}\n"


def relations_text(drive: SimulatedDrive, apart: int) -> str:
    """Return true relations between all scans a number of scans apart, as lines of a file."""
    true, stamps = drive.true, drive.log.stamps
    relations = Relations(stamps, relative(true[:-apart], true[apart:]))
    return "".join(
        f"{stamps[row]:.6f} {stamps[row + apart]:.6f} {x:.6f} {y:.6f} 0 0 0 {theta:.6f}\n"
        for row, (x, y, theta) in enumerate(relations.poses.tolist())
    )
