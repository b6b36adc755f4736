"""Waypoints on a grid as a chain code: where the first lies, and for each which of eight ways it heads.

H. Freeman, *On the encoding of arbitrary geometric configurations*, IRE Trans. Electronic Computers EC-10 (1961).
Coordinates are multiples of a nanometre, of which the nearest float64 is taken; those that were reckoned otherwise are
a unit in the last place or two beside it, which is told with the way. What comes back is what was given, bit for bit.
"""

import struct

import numpy as np
from numpy.typing import NDArray

from ppaas.plans.encoding.kernels.chain_code import CHAIN, EXACT, HEAD, write_chains

_COUNT = struct.Struct("<I")
_SHORT, _WIDE, _LOOSE = b"\x01", b"\x00", b"\x02"
"""How a code is packed: three bits a waypoint, four more where one lies beside its place, or not at all."""


def chain_codes(words: NDArray[np.uint64], begins: NDArray[np.int64], ends: NDArray[np.int64]) -> list[bytes]:
    """Return the codes of many stretches.

    Parameters
    ----------
    words : (n, 7) array
        The bits of poses.
    begins, ends : (m,) array
        The rows of each stretch, from the first to behind the last.

    Returns
    -------
    list
        For each stretch its code, or nothing if it is none of waypoints on a grid that follow one another.
    """
    stops = np.empty(len(begins), np.int64)
    out = np.empty(int((ends - begins).sum()) + (HEAD + 1) * len(begins), np.uint8)
    write_chains(words, begins, ends, out, stops)
    data, first, codes = out[: stops[-1] if len(stops) else 0].tobytes(), 0, []
    for stop in stops.tolist():
        codes.append(data[first:stop])
        first = stop
    return codes


def chain_length(code: bytes) -> int:
    """Return how many waypoints a code has."""
    return len(code) - HEAD - 1


def pack_chain(code: bytes) -> bytes:
    """Return a code with three bits a waypoint, and four more where one lies beside its place."""
    ways = np.frombuffer(code, np.uint8, offset=1 + HEAD)
    bits = np.unpackbits(ways[:, None], axis=1, bitorder="little")
    exact = bool((ways >> 3 == EXACT).all())
    kept = bits[:, :3] if exact else bits[:, :7]
    how = _SHORT if exact else _WIDE
    return code[:1] + how + code[1 : 1 + HEAD] + np.packbits(kept, bitorder="little").tobytes()


def loose_chain(code: bytes) -> bytes:
    """Return a code as if it were packed."""
    return code[:1] + _LOOSE + code[1:]


def packed_length(data: bytes) -> int:
    """Return how many waypoints a packed code has.

    Raises
    ------
    ValueError
        It is none, or has another length than it says.
    """
    if len(data) < 2 + HEAD or data[0] != CHAIN or data[1] > _LOOSE[0]:
        raise ValueError("no chain code")
    count, width = int(_COUNT.unpack_from(data, 2)[0]), {_SHORT: 3, _WIDE: 7, _LOOSE: 8}[data[1:2]]
    if not count or len(data) != 2 + HEAD + (count * width + 7) // 8:
        raise ValueError("a chain code is cut off")
    return count
