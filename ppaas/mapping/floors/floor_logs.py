"""Drive over several floors as one log a floor, and where the maps of the floors are in a common frame."""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.buildings.building import Building, Floor
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.mapping.floors.levels import DriveLevel
from ppaas.mapping.pipeline.offline import LogMap
from ppaas.mapping.scan_log import ScanLog


class FloorLog(NamedTuple):
    """Scans of one floor.

    Parameters
    ----------
    name : str
        Name of the floor; the lowest is ``L1``.
    elevation : float
        Height above the lowest floor [m].
    scans : (n,) int array
        Numbers of its scans in the log of the drive.
    log : ScanLog
        The log of these scans.
    """

    name: str
    elevation: float
    scans: NDArray[np.int64]
    log: ScanLog


def floor_logs(log: ScanLog, levels: Sequence[DriveLevel]) -> list[FloorLog]:
    """Return the logs of the floors that have scans, lowest first; scans of rides belong to none.

    Raises
    ------
    InvalidInput
        No scan was taken on a floor.
    """
    found: list[FloorLog] = []
    for level in levels:
        scans = np.flatnonzero(level.covers(log.stamps))
        if len(scans):
            found.append(FloorLog(f"L{len(found) + 1}", level.elevation, scans, log.chosen(scans)))
    if not found:
        raise InvalidInput("no scan was taken at a time at which the height is known")
    return found


@dataclass(frozen=True, slots=True)
class FloorMap:
    """Floor of a drive, with its map."""

    floor: FloorLog
    made: LogMap


def surveyed_building(maps: Sequence[FloorMap], log: ScanLog, map_id: Callable[[str], str]) -> Building:
    """Return the building of the floors of a drive: their elevations, and where their maps are.

    A robot that rides a lift stands in the car, and one on stairs goes on by its odometry. So the pose at which it
    comes to a floor follows from the pose at which it left the floor before, on that floor's map.

    Parameters
    ----------
    maps : sequence of FloorMap
        At least one.
    log : ScanLog
        The log of the whole drive.
    map_id : callable
        Returns the id of the map of a floor, by its name.
    """
    anchors = _anchors(maps, log)
    return Building(
        floors=tuple(
            Floor(
                name=each.floor.name, map=map_id(each.floor.name), elevation=each.floor.elevation,
                anchor=(round(at.x, 4), round(at.y, 4), round(at.theta, 5)),
            )
            for each, at in zip(maps, anchors, strict=True)
        )
    )  # fmt: skip


def _anchors(maps: Sequence[FloorMap], log: ScanLog) -> list[Pose2D]:
    """Return the poses of the frames of the maps in the frame of the map of the first floor of the drive."""
    owner, place = np.full(len(log), -1), np.zeros(len(log), np.int64)
    for number, each in enumerate(maps):
        owner[each.floor.scans], place[each.floor.scans] = number, np.arange(len(each.floor.scans))
    order = np.argsort(log.stamps, kind="stable")
    visited = [int(scan) for scan in order if owner[scan] >= 0]

    def pose(scan: int) -> Pose2D:
        return Pose2D(*maps[owner[scan]].made.poses[place[scan]].tolist())

    anchors = {int(owner[visited[0]]): Pose2D(0.0, 0.0)}
    for before, after in itertools.pairwise(visited):
        if int(owner[after]) in anchors:
            continue
        odom, later = (Pose2D(*log.odometry[scan].tolist()) for scan in (before, after))
        here = anchors[int(owner[before])] @ pose(before) @ odom.inverse() @ later
        anchors[int(owner[after])] = here @ pose(after).inverse()
    return [anchors[number] for number in range(len(maps))]
