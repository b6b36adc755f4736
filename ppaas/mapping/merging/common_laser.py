"""Key frames of two lasers as if of one: points are sorted into the beams of a common laser and stay as measured."""

import math
from dataclasses import replace

import numpy as np

from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.scan_points import ScanPoints

SAME = 1e-3
"""Relative difference of angle increments, and difference of first angles in beams, of lasers that are the same."""


def joined_frames(first: KeyFrames, second: KeyFrames, *, finest: bool = True) -> KeyFrames:
    """Return the key frames of two mappings, the first one's before the second's.

    Scans of the second are numbered on from the first's. If the lasers differ, the common one covers both, with
    the angle between beams of one of them.

    Parameters
    ----------
    first, second : KeyFrames
    finest : bool
        Whether the finer laser's beams are used: then no point is lost, and scans of the coarser one have beams
        without a reading. Otherwise the coarser laser's beams are used, and the nearest point of each beam is kept.
    """
    geometry = common_geometry(first.geometry, second.geometry, finest=finest)
    count = len(first) + len(second)
    joined, after = KeyFrames(geometry, max(count, 1)), int(first.scans[-1]) + 1 if len(first) else 0
    for frames, offset in ((first, 0), (second, after)):
        scans = frames.scan_points(slice(None))
        if not are_same(frames.geometry, geometry):
            scans = _sorted_into(geometry, scans)
        joined.extend(frames.poses, frames.information, frames.scans + offset, scans)
    return joined


def are_same(one: LaserGeometry, other: LaserGeometry) -> bool:
    """Return whether two lasers have the same beams."""
    step = one.angle_increment
    return (
        one.beams == other.beams
        and abs(other.angle_increment - step) <= SAME * abs(step)
        and abs(other.angle_min - one.angle_min) <= abs(step)
    )


def common_geometry(first: LaserGeometry, second: LaserGeometry, *, finest: bool) -> LaserGeometry:
    """Return the laser whose beams cover two lasers' beams; the first one if they are the same."""
    if are_same(first, second):
        return first
    choose = min if finest else max
    step = choose(abs(first.angle_increment), abs(second.angle_increment))
    low = min(_low(first), _low(second))
    high = max(_low(one) + abs(one.angle_increment) * (one.beams - 1) for one in (first, second))
    beams = min(math.ceil((high - low) / step - SAME) + 1, math.floor(2.0 * math.pi / step + SAME))
    return replace(first, angle_min=low, angle_increment=step, beams=max(beams, 1), time_increment=0.0)


def _low(geometry: LaserGeometry) -> float:
    """Return the smaller of the angles of the first and the last beam [rad]."""
    return geometry.angle_min + min(0.0, geometry.angle_increment * (geometry.beams - 1))


def _sorted_into(geometry: LaserGeometry, scans: ScanPoints) -> ScanPoints:
    """Return stacked scans (k, b, …) with each point at the beam of another laser that is nearest to its bearing."""
    frames, beams = np.nonzero(scans.valid)
    points = scans.points[frames, beams]
    away = np.hypot(points[:, 0], points[:, 1])
    turns = (np.arctan2(points[:, 1], points[:, 0]) - geometry.angle_min) / geometry.angle_increment
    slots = np.rint(turns).astype(np.int64) % geometry.beams_per_turn
    # The last assignment to a beam counts, so that the nearest of its points is written last.
    order = np.argsort(-away, kind="stable")
    order = order[slots[order] < geometry.beams]
    to, of = (frames[order], slots[order]), (frames[order], beams[order])
    shape = len(scans.valid), geometry.beams
    found = ScanPoints(np.zeros((*shape, 2), np.float32), np.zeros((*shape, 2), np.float32), np.zeros(shape, np.bool_))
    found.points[to], found.normals[to], found.valid[to] = scans.points[of], scans.normals[of], True
    return found
