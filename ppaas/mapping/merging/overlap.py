"""Overlap of two mappings at given poses: how far the scans of the second agree with the first's."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.mapping.alignment import align
from ppaas.mapping.closures.check import ALIGNED_WITH, MOST_MOVED, MOST_TURNED, CheckedScan
from ppaas.mapping.edge_information import weakest_information
from ppaas.mapping.key_frames import KeyFrames, NearFrames
from ppaas.mapping.merging.parameters import MergeParameters
from ppaas.mapping.near_poses import nearest_poses
from ppaas.mapping.visible_points import confirmed_share
from ppaas.planar_poses import PoseArray, relative

NEAR = 1.5
"""Largest distance between a scan and the key frames that it is compared with; see `nearest_poses` [m]."""

MOST = 200
"""Largest number of scans that are compared."""


class Overlap(NamedTuple):
    """Comparison of the scans of the second mapping that were taken near key frames of the first.

    Parameters
    ----------
    nodes : (n,) int64 array
        Key frames of the second mapping that were compared.
    fits : (n,) bool array
        Whether each can be aligned with the first's.
    confirmed : (n,) float64 array
        Share of the points visible to both lasers that both confirm, at the aligned pose; 0 of those that do not fit.
    scans : list of CheckedScan
        Scans that passed, and whose position is determined in every direction: they can be edges.
    """

    nodes: NDArray[np.int64]
    fits: NDArray[np.bool_]
    confirmed: NDArray[np.float64]
    scans: list[CheckedScan]


def compare(frames: KeyFrames, poses: PoseArray, first: int, parameters: MergeParameters) -> Overlap:
    """Compare the scans of the second mapping with the first's.

    Parameters
    ----------
    frames : KeyFrames
        Joined: the first mapping's, then the second's.
    poses : (k, 3) array
        Their poses in one frame.
    first : int
        Number of key frames of the first mapping.
    parameters : MergeParameters
    """
    near = nearest_poses(poses[first:], poses[:first], ALIGNED_WITH, NEAR)
    candidates = np.flatnonzero(near[:, 0] >= 0)
    chosen = candidates[:: max(1, -(-len(candidates) // MOST))]
    fits, confirmed, scans = np.zeros(len(chosen), np.bool_), np.zeros(len(chosen)), []
    for row, at in enumerate(chosen):
        others = near[at][near[at] >= 0]
        scan = _checked(frames, first + int(at), poses, others, parameters)
        if scan is None:
            continue
        fits[row], confirmed[row] = True, scan.confirmed
        closures = parameters.closures
        determined = weakest_information(scan.information) >= closures.least_information
        if determined and scan.confirmed >= closures.least_confirmed:
            scans.append(scan)
    return Overlap(first + chosen, fits, confirmed, scans)


def _checked(
    frames: KeyFrames, node: int, poses: PoseArray, others: NDArray[np.int64], parameters: MergeParameters
) -> CheckedScan | None:
    """Return a scan aligned with key frames of the first mapping; None if it does not fit."""
    near, start = NearFrames(others, poses[others]), Pose2D(*poses[node].tolist())
    scan = frames.scan_points(node)
    found = align(scan, start, frames, near)
    if found.ratio < parameters.closures.least_ratio or start.distance_to(found.pose) > MOST_MOVED:
        return None
    if abs(wrap_angle(found.pose.theta - start.theta)) > MOST_TURNED:
        return None
    confirmed = confirmed_share(frames, scan, near, found.pose, parameters.tolerance)
    measurement = relative(near.poses[0], np.array(found.pose))
    return CheckedScan(node, int(others[0]), measurement, found.information, found.ratio, confirmed)
