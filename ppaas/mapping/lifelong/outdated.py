"""Outdated beams: those that show things that have moved since, as two later passes agree."""

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.lifelong.neighbourhood import Neighbourhood
from ppaas.mapping.lifelong.scan_views import View
from ppaas.mapping.scan_points import ScanPoints

PASSES = 2
"""Number of later passes that have to contradict a beam, one after the other."""


def outdated_beams(near: Neighbourhood) -> NDArray[np.bool_]:
    """Return the beams (b,) of a key frame that the last two passes contradict, of those that saw the place.

    A pass contradicts a beam if more of its scans look through the place of the point, or see something before it, than
    see the point. What stood there in one pass only, such as a person, is not enough.
    """
    beams = near.views.seen.shape[1]
    opinions, against = np.zeros(beams, np.int64), np.zeros(beams, np.int64)
    for number in near.newer:
        verdict = _verdict(near, near.passes == number)
        counted = (verdict != 0) & (opinions < PASSES)
        opinions[counted] += 1
        against[counted & (verdict > 0)] += 1
    outdated: NDArray[np.bool_] = against == PASSES
    return outdated


def _verdict(near: Neighbourhood, rows: NDArray[np.bool_]) -> NDArray[np.int8]:
    """Return 1 for beams (b,) that a pass contradicts, -1 for those that it confirms, 0 for others."""
    seen, blocked = near.views.seen[rows], near.views.blocked[rows]
    against = ((seen == View.EMPTY) | blocked).sum(axis=0)
    confirmed = ((seen == View.CONFIRMED) & ~blocked).sum(axis=0)
    verdict: NDArray[np.int8] = np.sign(against - confirmed).astype(np.int8)
    return verdict


def without_beams(frames: KeyFrames, outdated: NDArray[np.bool_]) -> ScanPoints:
    """Return the scans (k, b) of key frames, in which some beams (k, b) have no reading."""
    if not outdated.any():
        return frames.scan_points(slice(None))
    # Lines were fitted to neighbouring points, too: normals beside a beam lean on its point.
    beside = outdated.copy()
    beside[:, :-1] |= outdated[:, 1:]
    beside[:, 1:] |= outdated[:, :-1]
    points, normals = frames.points.copy(), frames.normals.copy()
    points[outdated] = 0.0
    normals[beside] = 0.0
    return ScanPoints(points, normals, frames.valid & ~outdated)
