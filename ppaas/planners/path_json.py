"""Paths as JSON, written from their array: thousands of poses never become objects on their way to a client.

Numbers are rounded to the billionth, so what comes of reading them is within half a nanometre of the pose.
"""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from msgspec import Raw
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.geometry import Poses
from ppaas.messages.codec import encode
from ppaas.messages.nav_msgs import Path
from ppaas.messages.std_msgs import Header
from ppaas.planners.kernels.pose_text import BLOCK, MOST, WIDEST, write_rows

_STAMPED = (',"pose":{"position":{"x":', ',"y":', ',"z":', '},"orientation":{"x":', ',"y":', ',"z":', ',"w":', "}}},")
_ROW = ("[", *[","] * 6, "],")


def path_message(poses: Poses, header: Header) -> Path:
    """Return ``nav_msgs/Path`` of (n, 7) poses; each has the header of the path.

    Raises
    ------
    InvalidInput
        A pose is not finite, or out of all bounds.
    """
    first, *others = _STAMPED
    return Path(header, Raw(_write(poses, [f'{{"header":{encode(header).decode()}{first}', *others])))


def rows_text(poses: Poses) -> str:
    """Return (n, 7) poses as the JSON of a list of rows; raises as ``path_message`` does."""
    return str(_write(poses, _ROW), "ascii")


@lru_cache(8)
def _template(pieces: tuple[str, ...]) -> tuple[NDArray[np.uint8], NDArray[np.uint64]]:
    each = [piece.encode() for piece in pieces]
    ends = np.cumsum([len(piece) for piece in each]).astype(np.uint64)
    return np.frombuffer(b"".join(each) + bytes(BLOCK), np.uint8), ends


def _write(rows: Poses, pieces: Sequence[str]) -> memoryview:
    """Return the JSON of a list; the last piece ends with the comma between its items."""
    if not len(rows):
        return memoryview(b"[]")
    template, ends = _template(tuple(pieces))
    text = np.empty(1 + len(rows) * (len(template) + rows.shape[1] * WIDEST) + BLOCK, np.uint8)
    length = write_rows(rows, template, ends, text[1:])
    if not length:
        raise InvalidInput(f"a path with numbers that are not below {MOST:g} cannot be told: bring its map nearer to 0")
    text[0], text[length] = ord("["), ord("]")
    return text[: 1 + int(length)].data
