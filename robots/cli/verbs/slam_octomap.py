"""Makes a 3D map of the depth images and point clouds of a bag, along the trajectory that mapping found."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.errors import InvalidInput
from ppaas.mapping.volume.exports import binary_file, full_file
from ppaas.mapping.volume.offline_volume import OfflineVolume
from ppaas.mapping.volume.parameters import VolumeParameters
from ppaas.parameters import read_parameters
from robots.recordings.bag_points import BagPoints
from robots.recordings.reader import is_bag

if TYPE_CHECKING:
    from ppaas.mapping.trajectories import PlanarTrajectory
    from robots.recordings.recording import RecordedFrames

FULL = ".ot"
"""Ending of octomaps with all probabilities; others are binary."""


def octomap_of(
    path: Path,
    trajectory: "PlanarTrajectory",
    frames: "RecordedFrames",
    parameters: dict[str, Any],
    note: Callable[[str], None],
    *,
    full: bool,
) -> bytes:
    """Return the octomap of a bag.

    Parameters
    ----------
    path : Path
        The bag.
    trajectory : PlanarTrajectory
        Poses of the robot at its scans.
    frames : RecordedFrames
        Names of the robot's frames.
    parameters : dict
        Parameters of ``octomap_server`` that the map has.
    note : callable
        Called with what was left out.
    full : bool
        Whether the file has all probabilities.

    Raises
    ------
    InvalidInput
        The recording is no bag, or has neither images nor clouds that can be used.
    InvalidParameter
        A parameter is unknown or invalid.
    QuotaExceeded
        The map is too large.
    """
    if not is_bag(path):
        raise InvalidInput(f"{path} is no bag: a 3D map is made of depth images or point clouds of a bag")
    made = OfflineVolume(trajectory, read_parameters(VolumeParameters, "octomap_server", parameters))
    bag = BagPoints(path, frames)
    for seen in bag.read():
        made.insert(*seen)
    reasons = dict(bag.left_out) | ({"there is no pose at their time": made.unplaced} if made.unplaced else {})
    for reason, count in reasons.items():
        note(f"{count} depth images or clouds left out of the octomap: {reason}")
    if not made.inserted:
        raise InvalidInput(f"{path} has no depth image and no point cloud of which an octomap can be made")
    return (full_file if full else binary_file)(made.volume)
