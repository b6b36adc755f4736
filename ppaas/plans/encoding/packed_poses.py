"""Poses of one path as bytes, bit for bit: its ends as they are, and the poses between them as a segment.

A path from cell to cell takes a byte a pose, where JSON takes 50, and any other path in the plane 32.
"""

import numpy as np

from ppaas.errors import MalformedMessage
from ppaas.geometry import Poses
from ppaas.plans.encoding.chain_code import loose_chain, packed_length
from ppaas.plans.encoding.chunks import ENDS_AFTER, ENDS_BEFORE
from ppaas.plans.encoding.codes import codes_of, poses_of
from ppaas.plans.encoding.kernels.chain_code import CHAIN, FLAT, SPATIAL, read_segments

_POSE = 7 * 8
_ENDS = (ENDS_BEFORE + ENDS_AFTER) * _POSE
_FIRST = np.zeros(1, np.int64)
_CHAIN = np.array([CHAIN], np.int64)


def pack_poses(poses: Poses) -> bytes:
    """Return (n, 7) poses as bytes."""
    poses = poses.astype("<f8", copy=False)
    if len(poses) <= ENDS_BEFORE + ENDS_AFTER:
        return poses.tobytes()
    [between] = codes_of(poses, np.array([ENDS_BEFORE]), np.array([len(poses) - ENDS_AFTER]))
    if between[0] == CHAIN:
        between = loose_chain(between)
    return b"".join((poses[:ENDS_BEFORE].tobytes(), poses[-ENDS_AFTER:].tobytes(), between))


def unpack_poses(data: bytes) -> Poses:
    """Return (n, 7) poses.

    Raises
    ------
    MalformedMessage
        The bytes are not packed poses.
    """
    between = data[_ENDS:]
    try:
        ends = np.frombuffer(data[:_ENDS], "<f8").reshape(-1, 7)
        if not between:
            return ends
        poses = _between(between)
    except ValueError as error:
        raise MalformedMessage(f"a path is not packed as it must be: {error}") from error
    poses[:ENDS_BEFORE], poses[-ENDS_AFTER:] = ends[:ENDS_BEFORE], ends[ENDS_BEFORE:]
    return poses


def _between(data: bytes) -> Poses:
    """Return the poses of a segment, with room for those before and after it; ``ValueError`` if there are none."""
    if data[0] != CHAIN:
        if data[0] not in (FLAT, SPATIAL):
            raise ValueError(f"no segment begins with {data[0]}")
        return np.pad(poses_of(data), ((ENDS_BEFORE, ENDS_AFTER), (0, 0)))
    count = packed_length(data)
    words = np.zeros((ENDS_BEFORE + count + ENDS_AFTER, 7), np.uint64)
    rows = np.array([ENDS_BEFORE, ENDS_BEFORE + count], np.int64)
    read_segments(np.frombuffer(data, np.uint8, offset=1), _CHAIN, _FIRST, rows, words)
    return words.view(np.float64)
