"""Stretches of waypoints as bytes.

The *code* of a stretch is made quickly, and equal stretches have equal codes: by it a stretch is known again. It is
*packed* once, when it is kept for the first time; a pack says by its first byte how it was made.
"""

import hashlib
import zlib

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import Unavailable
from ppaas.geometry import Poses
from ppaas.plans.chain_code import chain_codes, chain_length, chain_poses, lengthened, shortened

_CHAIN, _FLAT, _SPATIAL = b"\x01", b"\x02", b"\x03"
_FLAT_COLUMNS = [0, 1, 5, 6]

ID_BYTES = 16


def codes_of(poses: Poses, begins: NDArray[np.int64], ends: NDArray[np.int64]) -> list[bytes]:
    """Return the codes of stretches of (n, 7) poses.

    Parameters
    ----------
    poses : (n, 7) float64 array
    begins, ends : (m,) array
        The rows of each stretch, from the first to behind the last; they ascend and do not overlap.
    """
    chains = chain_codes(poses, begins, ends)
    codes = [b"" if chain is None else _CHAIN + chain for chain in chains]
    others = [number for number, chain in enumerate(chains) if chain is None]
    if others:
        flat = np.ascontiguousarray(poses[:, _FLAT_COLUMNS])
        in_space = (np.ascontiguousarray(poses[:, 2:5]).view(np.int64) != 0).any(axis=1)
    for number in others:
        rows = slice(begins[number], ends[number])
        spatial = in_space[rows].any()
        codes[number] = _SPATIAL + poses[rows].tobytes() if spatial else _FLAT + flat[rows].tobytes()
    return codes


def poses_of(code: bytes) -> Poses:
    """Return the (n, 7) poses of a code."""
    if code[:1] == _CHAIN:
        return chain_poses(code[1:])
    if code[:1] == _SPATIAL:
        return np.frombuffer(code, "<f8", offset=1).reshape(-1, 7)
    flat = np.frombuffer(code, "<f8", offset=1).reshape(-1, 4)
    poses = np.zeros((len(flat), 7))
    poses[:, _FLAT_COLUMNS] = flat
    return poses


def waypoints_in(code: bytes) -> int:
    """Return how many waypoints a code has."""
    if code[:1] == _CHAIN:
        return chain_length(code[1:])
    return (len(code) - 1) // (8 * (4 if code[:1] == _FLAT else 7))


def entry_id(scope: bytes, code: bytes) -> bytes:
    """Return the id of a stretch: what it is of, and what is in it.

    Parameters
    ----------
    scope : bytes
        16 bytes; equal stretches of another scope have another id.
    code : bytes
    """
    return hashlib.blake2b(code, digest_size=ID_BYTES, salt=scope).digest()


def pack(code: bytes) -> bytes:
    """Return what is kept of a code."""
    if code[:1] == _CHAIN:
        return _CHAIN + shortened(code[1:])
    columns = 4 if code[:1] == _FLAT else 7
    words = np.frombuffer(code, "<i8", offset=1).reshape(-1, columns)
    # Neighbours are alike: what is told of each is how it differs, and bytes of equal weight lie side by side.
    moved = np.diff(words, axis=0, prepend=np.zeros((1, columns), "<i8"))
    planes = moved.view(np.uint8).reshape(len(words), columns * 8).T
    return code[:1] + zlib.compress(planes.tobytes(), 9, -15)


def unpack(data: bytes) -> bytes:
    """Return the code that was packed.

    Raises
    ------
    Unavailable
        It is damaged, or of a release that packed it otherwise.
    """
    try:
        if data[:1] == _CHAIN:
            return _CHAIN + lengthened(data[1:])
        columns = {_FLAT: 4, _SPATIAL: 7}[data[:1]]
        planes = np.frombuffer(zlib.decompress(data[1:], -15), np.uint8).reshape(columns * 8, -1)
        moved = np.ascontiguousarray(planes.T).view("<i8")
        return data[:1] + np.cumsum(moved, axis=0, dtype="<i8").tobytes()
    except (IndexError, KeyError, ValueError, zlib.error) as error:
        raise Unavailable(f"stored waypoints cannot be read ({error}): restore them from a backup") from error
