"""The head of an index: what it is, and whether it is whole and of the map at hand.

An index is one array, so one file: its bytes as they lie in memory, which many processes map. Whoever takes such bytes
believes nothing that the head does not vouch for: its check sum covers all numbers that say where things lie.
"""

import zlib
from hashlib import blake2b

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.planners.hub_labels.kernels import layout
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.terrain import HEAD

MAGIC = int.from_bytes(b"PPaaShub", "big") & 0x7FFFFFFFFFFFFFFF
"""Read on a machine of the other byte order, it is another number."""

VERSION = 5
"""Raised whenever the layout or the meaning of an index changes: old files are then built anew."""

FINGERPRINT_WORDS = 4


def fingerprint(free: NDArray[np.bool_]) -> Words:
    """Return what tells a map, (height, width), from all others: 32 bytes as four int64."""
    digest = blake2b(np.array(free.shape, "<i8").tobytes(), digest_size=8 * FINGERPRINT_WORDS)
    digest.update(np.packbits(free).tobytes())
    return np.frombuffer(digest.digest(), np.int64)


def seal(index: Words, mark: Words) -> Words:
    """Write the head of an index that is laid out, for the map with that fingerprint, and let nobody write to it."""
    index[layout.MAGIC], index[layout.VERSION], index[layout.SIZE] = MAGIC, VERSION, len(index)
    index[layout.FINGERPRINT : layout.FINGERPRINT + FINGERPRINT_WORDS] = mark
    index[layout.CHECK] = _check_sum(index)
    index.flags.writeable = False
    return index


def unseal(content: bytes | memoryview) -> Words:
    """Return the index of a map from the bytes of a file, without a copy.

    Raises
    ------
    InvalidInput
        They are no index, one of another version or byte order, or one that was cut off.
    """
    if len(content) < 8 * layout.HEAD or len(content) % 8:
        raise InvalidInput(f"{len(content)} bytes are no index of hub labels; build it again")
    index = np.frombuffer(content, np.int64)
    if index[layout.MAGIC] != MAGIC:
        swapped = int(index[layout.MAGIC].byteswap()) == MAGIC
        what = "made on a machine of the other byte order" if swapped else "not an index of hub labels"
        raise InvalidInput(f"the file is {what}; build the index again")
    if index[layout.VERSION] != VERSION:
        raise InvalidInput(f"the index is of version {index[layout.VERSION]} instead of {VERSION}; build it again")
    if index[layout.SIZE] != len(index) or index[layout.CHECK] != _check_sum(index):
        raise InvalidInput(f"the index is not whole: {index.nbytes} bytes, or a head that was changed; build it again")
    index.flags.writeable = False
    return index


def _check_sum(index: Words) -> int:
    terrain = int(index[layout.TERRAIN])
    without = index[: layout.HEAD].copy()
    without[layout.CHECK] = 0
    return zlib.crc32(index[terrain : terrain + HEAD].tobytes(), zlib.crc32(without.tobytes()))
