"""Outlines of robots: checks the parameter ``footprint``, and converts it for the kernels."""

import numpy as np

from ppaas.controllers.kernels.clearance import RobotOutline
from ppaas.errors import InvalidParameter
from ppaas.footprints import Footprint, goes_around


def check_footprint(corners: Footprint) -> None:
    """Check the parameter ``footprint``.

    Raises
    ------
    InvalidParameter
        It has one or two corners, a number is not finite, or it does not go around the origin in one direction.
    """
    if corners and not goes_around(corners):
        raise InvalidParameter(
            "footprint must be a list of corners (x, y) [m], in order around the robot's origin: none for a disc, or "
            f"at least three, not {corners!r}"
        )


def body_of(footprint: Footprint, robot_radius: float) -> RobotOutline:
    """Return the outline of a robot for the kernels, from its footprint, or from its radius [m] if that is empty."""
    corners = np.array(footprint, dtype=np.float64).reshape(-1, 2)
    vectors = np.roll(corners, -1, axis=0) - corners
    lengths = np.hypot(vectors[:, 0], vectors[:, 1])[:, None]
    edges = np.hstack((corners, vectors / lengths, lengths))
    if not len(corners):
        return RobotOutline(edges, robot_radius, robot_radius)
    # Distance of each edge's line from the origin: cross product of a corner with the edge's unit direction.
    beside = np.abs(edges[:, 0] * edges[:, 3] - edges[:, 1] * edges[:, 2])
    return RobotOutline(edges, float(beside.min()), float(np.hypot(corners[:, 0], corners[:, 1]).max()))
