"""Header of an index: format, size, checksum, and the fingerprint of its map.

An index is one array and one file: its bytes in memory order, which many processes map. Readers trust only what the
header confirms. Its checksum covers all section offsets.
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
"""Format marker. On a machine of the other byte order it reads as another number."""

VERSION = 5
"""Version of the layout and meaning of an index. Files of other versions are built again."""

FINGERPRINT_WORDS = 4
"""Length of a fingerprint [int64]."""


def fingerprint(free: NDArray[np.bool_]) -> Words:
    """Return the fingerprint of a map (height, width): 32 bytes as four int64."""
    digest = blake2b(np.array(free.shape, "<i8").tobytes(), digest_size=8 * FINGERPRINT_WORDS)
    digest.update(np.packbits(free).tobytes())
    return np.frombuffer(digest.digest(), np.int64)


def seal(index: Words, mark: Words) -> Words:
    """Write the header of a finished index for the map with this fingerprint, and make it read-only."""
    index[layout.MAGIC], index[layout.VERSION], index[layout.SIZE] = MAGIC, VERSION, len(index)
    index[layout.FINGERPRINT : layout.FINGERPRINT + FINGERPRINT_WORDS] = mark
    index[layout.CHECK] = _check_sum(index)
    index.flags.writeable = False
    return index


def unseal(content: bytes | memoryview) -> Words:
    """Return the index in the bytes of a file, without a copy.

    Raises
    ------
    InvalidInput
        The bytes are not an index, have another version or byte order, or are truncated.
    """
    if len(content) < 8 * layout.HEAD or len(content) % 8:
        raise InvalidInput(f"{len(content)} bytes are not an index of hub labels; build it again")
    index = np.frombuffer(content, np.int64)
    if index[layout.MAGIC] != MAGIC:
        swapped = int(index[layout.MAGIC].byteswap()) == MAGIC
        what = "made on a machine of the other byte order" if swapped else "not an index of hub labels"
        raise InvalidInput(f"the file is {what}; build the index again")
    if index[layout.VERSION] != VERSION:
        raise InvalidInput(f"the index has version {index[layout.VERSION]} instead of {VERSION}; build it again")
    if index[layout.SIZE] != len(index) or index[layout.CHECK] != _check_sum(index):
        raise InvalidInput(f"the index of {index.nbytes} bytes is truncated or damaged; build it again")
    index.flags.writeable = False
    return index


def _check_sum(index: Words) -> int:
    terrain = int(index[layout.TERRAIN])
    without = index[: layout.HEAD].copy()
    without[layout.CHECK] = 0
    return zlib.crc32(index[terrain : terrain + HEAD].tobytes(), zlib.crc32(without.tobytes()))
