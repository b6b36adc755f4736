"""Drives during which the robot is carried to another place, without its odometry noticing it."""

from dataclasses import replace

import numpy as np

from benchmarks.mapping.simulated_drive import SimulatedDrive
from ppaas.planar_poses import compose, relative


def carried(drive: SimulatedDrive, at: int, on: int) -> SimulatedDrive:
    """Return a drive of which the scans from ``at`` to before ``on`` are missing: the robot was carried that way."""
    count = len(drive.true)
    return followed(drive.first(at), _part(drive, np.arange(on, count)))


def followed(first: SimulatedDrive, second: SimulatedDrive) -> SimulatedDrive:
    """Return a drive of the same robot that is carried from the end of one drive to the start of another."""
    one, two = first.log, second.log
    odometry = compose(one.odometry[-1], relative(two.odometry[0], two.odometry))
    log = replace(
        one,
        stamps=np.concatenate((one.stamps, two.stamps - two.stamps[0] + one.stamps[-1] + 0.2)),
        odometry=np.concatenate((one.odometry, odometry)),
        ranges=np.concatenate((one.ranges, two.ranges)),
        first_angles=np.concatenate((one.first_angles, two.first_angles)),
    )
    return SimulatedDrive(log, np.concatenate((first.true, second.true)))


def _part(drive: SimulatedDrive, kept: np.ndarray) -> SimulatedDrive:  # type: ignore[type-arg]
    log = drive.log
    part = replace(
        log,
        stamps=log.stamps[kept],
        odometry=log.odometry[kept],
        ranges=log.ranges[kept],
        first_angles=log.first_angles[kept],
    )
    return SimulatedDrive(part, drive.true[kept])
