"""Poses of one path as bytes, bit for bit: its ends as they are, and the poses between them as a segment.

A path from cell to cell takes a byte a pose, where JSON takes 50, and any other path in the plane 32.
"""

import numpy as np

from ppaas.errors import MalformedMessage, Unavailable
from ppaas.geometry import Poses
from ppaas.plans.encoding.chunks import ENDS_AFTER, ENDS_BEFORE
from ppaas.plans.encoding.codes import codes_of, poses_of
from ppaas.plans.encoding.kernels.chain_code import CHAIN, FLAT, SPATIAL

_POSE = 7 * 8
_ENDS = (ENDS_BEFORE + ENDS_AFTER) * _POSE
_CODES = frozenset((CHAIN, FLAT, SPATIAL))


def pack_poses(poses: Poses) -> bytes:
    """Return (n, 7) poses as bytes."""
    if len(poses) <= ENDS_BEFORE + ENDS_AFTER:
        return poses.astype("<f8", copy=False).tobytes()
    first, last = poses[:ENDS_BEFORE], poses[-ENDS_AFTER:]
    [between] = codes_of(poses, np.array([ENDS_BEFORE]), np.array([len(poses) - ENDS_AFTER]))
    return b"".join((first.astype("<f8", copy=False).tobytes(), last.astype("<f8", copy=False).tobytes(), between))


def unpack_poses(data: bytes) -> Poses:
    """Return (n, 7) poses.

    Raises
    ------
    MalformedMessage
        The bytes are not those of packed poses.
    """
    between = data[_ENDS:]
    try:
        ends = np.frombuffer(data[:_ENDS], "<f8").reshape(-1, 7)
        if not between:
            return ends
        if between[0] not in _CODES:
            raise ValueError(f"no segment begins with {between[0]}")
        return np.concatenate((ends[:ENDS_BEFORE], poses_of(between), ends[ENDS_BEFORE:]))
    except (ValueError, Unavailable) as error:
        raise MalformedMessage(f"a path is not packed as it must be: {error}") from error
