"""Outlines of robots: checks the parameter ``footprint``, and converts it for the kernels."""

import numpy as np

from ppaas.controllers.kernels.clearance import RobotOutline
from ppaas.errors import InvalidParameter
from ppaas.parameters import check_scalar

Footprint = tuple[tuple[float, float], ...]
"""Corners of an outline around the robot's origin, in order [m]; empty for a disc."""


def checked_footprint(value: object) -> Footprint:
    """Return the value of the parameter ``footprint`` as a footprint.

    Raises
    ------
    InvalidParameter
        The value is not a list of pairs of finite numbers, has one or two corners, or does not go around the origin in
        one direction.
    """
    expected = (
        "footprint must be a list of corners (x, y) [m], in order around the robot's origin: none for a disc, or at "
        "least three"
    )
    if not isinstance(value, (list, tuple)) or not all(isinstance(c, (list, tuple)) and len(c) == 2 for c in value):
        raise InvalidParameter(f"{expected}, not {value!r}")
    for corner in value:
        for number in corner:
            check_scalar("footprint", number, float)
    corners = tuple((float(x), float(y)) for x, y in value)
    turns = [a[0] * b[1] - a[1] * b[0] for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
    if corners and (len(corners) < 3 or not (min(turns) > 0.0 or max(turns) < 0.0)):
        raise InvalidParameter(f"{expected}, not {value!r}")
    return corners


def body_of(footprint: Footprint, robot_radius: float) -> RobotOutline:
    """Return the outline of a robot for the kernels, from its footprint, or from its radius [m] if that is empty."""
    corners = np.array(footprint, dtype=np.float64).reshape(-1, 2)
    ways = np.roll(corners, -1, axis=0) - corners
    lengths = np.hypot(ways[:, 0], ways[:, 1])[:, None]
    edges = np.hstack((corners, ways / lengths, lengths))
    if not len(corners):
        return RobotOutline(edges, robot_radius, robot_radius)
    # Distance of each edge's line from the origin: cross product of a corner with the edge's unit direction.
    beside = np.abs(edges[:, 0] * edges[:, 3] - edges[:, 1] * edges[:, 2])
    return RobotOutline(edges, float(beside.min()), float(np.hypot(corners[:, 0], corners[:, 1]).max()))
