"""Freeman chain code of waypoints on a grid: the position of the first, and one of eight directions for each.

Source: H. Freeman, *On the encoding of arbitrary geometric configurations*, IRE Trans. Electronic Computers EC-10
(1961).

A coordinate is stored as a multiple of a nanometre, whose nearest float64 is taken. Coordinates that were computed
differently lie one or two units in the last place beside it; that offset is stored with the direction. Decoding returns
the original bits.
"""

import struct

import numpy as np
from numpy.typing import NDArray

from ppaas.plans.encoding.kernels.chain_code import CHAIN, EXACT, HEAD, write_chains

_COUNT = struct.Struct("<I")

_THREE_BITS, _SEVEN_BITS, _UNPACKED = b"\x01", b"\x00", b"\x02"
"""Packing of a code: three bits a waypoint; seven bits if some lie beside their grid position; or not packed."""


def chain_codes(words: NDArray[np.uint64], begins: NDArray[np.int64], ends: NDArray[np.int64]) -> list[bytes]:
    """Return the codes of many segments.

    Parameters
    ----------
    words : (n, 7) uint64 array
        Bits of poses.
    begins, ends : (m,) int64 array
        Rows of each segment, the end excluded.

    Returns
    -------
    list of bytes
        Code of each segment; empty if its waypoints are not consecutive cells of a grid.
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
    """Return the number of waypoints of a code."""
    return len(code) - HEAD - 1


def pack_chain(code: bytes) -> bytes:
    """Return a code with three bits a waypoint, or seven if some lie beside their grid position."""
    directions = np.frombuffer(code, np.uint8, offset=1 + HEAD)
    bits = np.unpackbits(directions[:, None], axis=1, bitorder="little")
    exact = bool((directions >> 3 == EXACT).all())
    packed_bits = bits[:, :3] if exact else bits[:, :7]
    width_tag = _THREE_BITS if exact else _SEVEN_BITS
    return code[:1] + width_tag + code[1 : 1 + HEAD] + np.packbits(packed_bits, bitorder="little").tobytes()


def loose_chain(code: bytes) -> bytes:
    """Return a code in the packed format, without packing it."""
    return code[:1] + _UNPACKED + code[1:]


def packed_length(data: bytes) -> int:
    """Return the number of waypoints of a packed code.

    Raises
    ------
    ValueError
        It is not a chain code, or its length does not match its header.
    """
    if len(data) < 2 + HEAD or data[0] != CHAIN or data[1] > _UNPACKED[0]:
        raise ValueError("not a chain code")
    count, width = int(_COUNT.unpack_from(data, 2)[0]), {_THREE_BITS: 3, _SEVEN_BITS: 7, _UNPACKED: 8}[data[1:2]]
    if not count or len(data) != 2 + HEAD + (count * width + 7) // 8:
        raise ValueError("a chain code is truncated")
    return count
