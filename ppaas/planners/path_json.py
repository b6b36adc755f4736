"""Paths as JSON, written directly from their array without an object per pose.

Numbers are rounded to nine decimals, so positions are within half a nanometre of the pose.
"""

from collections.abc import Sequence
from functools import cache, lru_cache

import numpy as np
from msgspec import Raw
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.geometry import Poses
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.codec import encode
from ppaas.messages.nav_msgs import Path
from ppaas.planners.kernels.pose_text import BLOCK, MAX_MAGNITUDE, WIDEST, write_rows

_STAMPED = (',"pose":{"position":{"x":', ',"y":', ',"z":', '},"orientation":{"x":', ',"y":', ',"z":', ',"w":', "}}},")


def path_message(poses: Poses, header: Header) -> Path:
    """Return the ``nav_msgs/Path`` of (n, 7) poses; each pose has the header of the path.

    Raises
    ------
    InvalidInput
        A number is not finite, or its magnitude is 9·10⁹ or more.
    """
    first, *others = _STAMPED
    return Path(header, Raw(_write(poses, [f'{{"header":{encode(header).decode()}{first}', *others])))


def rows_json(rows: NDArray[np.float64]) -> Raw:
    """Return (n, m) numbers as a JSON array of rows; raises as ``path_message`` does."""
    return Raw(_write(rows, _row(rows.shape[1])))


def rows_text(poses: Poses) -> str:
    """Return (n, 7) poses as a JSON array of rows; raises as ``path_message`` does."""
    return str(_write(poses, _row(poses.shape[1])), "ascii")


@cache
def _row(columns: int) -> tuple[str, ...]:
    return ("[", *[","] * (columns - 1), "],")


@lru_cache(8)
def _template(pieces: tuple[str, ...]) -> tuple[NDArray[np.uint8], NDArray[np.uint64]]:
    each = [piece.encode() for piece in pieces]
    ends = np.cumsum([len(piece) for piece in each]).astype(np.uint64)
    return np.frombuffer(b"".join(each) + bytes(BLOCK), np.uint8), ends


def _write(rows: NDArray[np.float64], pieces: Sequence[str]) -> memoryview:
    """Return a JSON array with one item per row; the last piece ends with the comma between items."""
    if not len(rows):
        return memoryview(b"[]")
    template, ends = _template(tuple(pieces))
    text = np.empty(1 + len(rows) * (len(template) + rows.shape[1] * WIDEST) + BLOCK, np.uint8)
    length = write_rows(rows, template, ends, text[1:])
    if not length:
        raise InvalidInput(
            f"the numbers of a path must be finite and smaller than {MAX_MAGNITUDE:g}: move the map nearer to the "
            "origin of its frame"
        )
    text[0], text[length] = ord("["), ord("]")
    return text[: 1 + int(length)].data
