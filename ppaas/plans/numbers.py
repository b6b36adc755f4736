"""Numbers as bytes, bit for bit and short where they are what people and rasters give: few places behind the point.

A number has a tag of four bits and up to eight bytes: so many thousandths; so many millionths and a few units in the
last place; what was expected of it, or a few units beside that; or its own eight bytes.
"""

import struct
from collections.abc import Sequence

from ppaas.errors import Unavailable

_MICRO, _EXPECTED, _BESIDE, _RAW = 7, 13, 14, 15
"""Tags; those before the first say how many bytes of thousandths follow, those from it on three bytes of millionths and
more."""

_SIZES = (*range(_MICRO), *range(3, 9), 0, 1, 8)
_MILLI_MOST, _MICRO_MOST = 2**46, 2**51

Token = tuple[int, int]

_float = struct.Struct("<d")
_word = struct.Struct("<q")


def write_numbers(values: Sequence[float], expected: Sequence[float]) -> bytes:
    """Return values as bytes, told by what is expected of each."""
    tags, data = [], []
    words = struct.unpack(f"<{len(values)}q", struct.pack(f"<{len(values)}d", *values))
    foreseen = struct.unpack(f"<{len(values)}q", struct.pack(f"<{len(values)}d", *expected))
    for value, word, other in zip(values, words, foreseen, strict=True):
        tag, code = _token(value, word, word - other)
        tags.append(tag)
        if code:
            data.append(code.to_bytes(_SIZES[tag], "little"))
        elif _SIZES[tag]:
            data.append(bytes(_SIZES[tag]))
    if len(tags) % 2:
        tags.append(0)
    heads = bytes([low | high << 4 for low, high in zip(tags[::2], tags[1::2], strict=True)])
    return heads + b"".join(data)


def read_tokens(data: bytes, count: int, at: int, most: int | None = None) -> tuple[list[Token], int]:
    """Return the tags and codes of numbers that are told from ``at`` on, and where the bytes behind them begin.

    Of the ``count`` that were written only the first ``most`` are read, if that is given.

    Raises
    ------
    Unavailable
        The bytes end before.
    """
    heads = at
    at += (count + 1) // 2
    tokens = []
    for number in range(count if most is None else most):
        tag = data[heads + number // 2] >> 4 * (number & 1) & 15 if heads + number // 2 < len(data) else 0
        size = _SIZES[tag]
        tokens.append((tag, int.from_bytes(data[at : at + size], "little") if size else 0))
        at += size
    if at > len(data):
        raise Unavailable("a stored plan is damaged: restore it from a backup")
    return tokens, at


def value_of(token: Token, expected: float = 0.0) -> float:
    """Return the number of a tag and code, of which this was expected."""
    tag, code = token
    if tag < _MICRO:
        return _signed(code) / 1e3
    if tag < _EXPECTED:
        return _beside(_signed(code >> 4) / 1e6, (code & 15) - 8)
    if tag == _RAW:
        return float(_float.unpack(code.to_bytes(8, "little"))[0])
    return expected if tag == _EXPECTED else _beside(expected, code - 128)


def _token(value: float, word: int, beside: int) -> Token:
    """Return how a value is told: it, its bits, and how many units in the last place it is beside what is expected."""
    if not beside:
        return _EXPECTED, 0
    scaled = value * 1e3
    if -_MILLI_MOST < scaled < _MILLI_MOST:
        whole = round(scaled)
        if whole / 1e3 == value and (whole or not word):
            code = whole << 1 if whole >= 0 else (-whole << 1) - 1
            return (code.bit_length() + 7) // 8, code
    if -128 <= beside < 128:
        return _BESIDE, beside + 128
    scaled = value * 1e6
    if -_MICRO_MOST < scaled < _MICRO_MOST:
        whole = round(scaled)
        places = word - _bits(whole / 1e6)
        if -8 <= places < 8:
            code = (whole << 1 if whole >= 0 else (-whole << 1) - 1) << 4 | places + 8
            return _MICRO + max((code.bit_length() + 7) // 8, 3) - 3, code
    return _RAW, word & (1 << 64) - 1


def _bits(value: float) -> int:
    return int(_word.unpack(_float.pack(value))[0])


def _beside(value: float, places: int) -> float:
    return float(_float.unpack(_word.pack(_bits(value) + places))[0])


def _signed(code: int) -> int:
    return code >> 1 if not code & 1 else -(code + 1 >> 1)
