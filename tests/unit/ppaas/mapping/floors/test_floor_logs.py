"""Logs of floors, and where the maps of floors join."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.mapping.floors.floor_logs import FloorMap, floor_logs, surveyed_building
from ppaas.mapping.floors.levels import DriveLevel
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.scan_log import ScanLog

GEOMETRY = LaserGeometry(0.0, 0.1, 4, Pose2D(0.0, 0.0))


def log_of(poses: list[Pose2D]) -> ScanLog:
    count = len(poses)
    odometry = np.array([tuple(pose) for pose in poses])
    return ScanLog(np.arange(count, dtype=float), odometry, np.ones((count, 4), np.float32), np.zeros(count), GEOMETRY)


def test_scans_of_rides_belong_to_no_floor() -> None:
    log = log_of([Pose2D(0.1 * n, 0.0) for n in range(10)])
    levels = [
        DriveLevel(0.0, [(-np.inf, 2.0), (8.0, np.inf)]),
        DriveLevel(3.0, [(50.0, 60.0)]),
        DriveLevel(6.0, [(4.0, 6.0)]),
    ]
    floors = floor_logs(log, levels)
    assert [(floor.name, floor.elevation, floor.scans.tolist()) for floor in floors] == [
        ("L1", 0.0, [0, 1, 2, 8, 9]), ("L2", 6.0, [4, 5, 6]),
    ]  # fmt: skip
    assert floors[1].log.odometry[:, 0].tolist() == pytest.approx([0.4, 0.5, 0.6])
    with pytest.raises(InvalidInput, match="no scan"):
        floor_logs(log, levels[1:2])


def test_maps_join_where_the_robot_has_left_one_and_come_to_the_other() -> None:
    """Odometry has drifted on the first floor, and each map has a frame that nothing else has."""
    frames = {"L1": Pose2D(4.0, -2.0, 0.5), "L2": Pose2D(-1.0, 3.0, -0.7)}
    true = [
        Pose2D(0.0, 0.0, 0.0),
        Pose2D(1.0, 0.0, 0.0),
        Pose2D(2.0, 1.0, 1.0),
        Pose2D(2.0, 1.0, 1.2),
        Pose2D(3.0, 2.0),
    ]
    drift = Pose2D(0.4, 0.2, 0.3)
    log = log_of([true[0], true[1], *(drift @ pose for pose in true[2:])])
    floors = floor_logs(log, [DriveLevel(0.0, [(-np.inf, 2.0)]), DriveLevel(3.5, [(3.0, np.inf)])])
    maps = []
    for floor in floors:
        poses = np.array([tuple(frames[floor.name].inverse() @ true[scan]) for scan in floor.scans])
        made: Any = SimpleNamespace(poses=poses)
        maps.append(FloorMap(floor, made))
    first, second = surveyed_building(maps, log, lambda name: f"mill-{name}").floors
    assert (first.map, second.map, second.elevation) == ("mill-L1", "mill-L2", 3.5)
    assert first.anchor == (0.0, 0.0, 0.0)
    assert second.anchor == pytest.approx(tuple(frames["L1"].inverse() @ frames["L2"]), abs=1e-3)
