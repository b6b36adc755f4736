"""What of a plan is its own, as bytes: its id and numbers, its ends, and what of it is too short to be shared."""

import struct
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import Unavailable
from ppaas.geometry import Poses
from ppaas.plans.chunks import ENDS_BEFORE
from ppaas.plans.codes import pack, poses_of, unpack
from ppaas.plans.headings import quaternion_near, quaternion_towards
from ppaas.plans.numbers import Token, read_tokens, value_of, write_numbers

_FORMAT, _IN_SPACE, _HEX, _INLINE = 1, 0x10, 0x20, 0x40

NUMBERS = ("created", "length", "cost", "seconds", "start_x", "start_y", "start_yaw", "goal_x", "goal_y", "goal_yaw")
"""The numbers of a plan, in the order in which they are told."""

_COUNT = len(NUMBERS)
_SPATIAL = struct.Struct("<3d")
_FLAT = bytes(9 * 8)
_DIGITS = set("0123456789abcdef")


def write_body(
    plan_id: str, count: int, numbers: Sequence[float], ends: Sequence[Sequence[float]], between: bytes | None
) -> bytes:
    """Return the body of a plan.

    Parameters
    ----------
    plan_id : str
    count : int
        Of all its waypoints.
    numbers : sequence of 10 floats
        ``NUMBERS``.
    ends : three sequences of 7 floats
        The first pose, the last but one and the last; where there are fewer, some are the same.
    between : bytes or None
        The code of the waypoints between; None where they are entries, or there are none.
    """
    first, before, last = ends
    values, expected = list(numbers), [0.0] * _COUNT
    heading = quaternion_towards(last[0] - before[0], last[1] - before[1])
    for pose, foreseen in (
        (first, (numbers[4], numbers[5], *quaternion_near(numbers[6]))),
        (last, (numbers[7], numbers[8], *quaternion_near(numbers[9]))),
        (before, (last[0], last[1], *heading)),  # on a grid one of both is often the same
    ):
        values += pose[0], pose[1], pose[5], pose[6]
        expected += foreseen
    spatial = b"".join([_SPATIAL.pack(*pose[2:5]) for pose in ends])
    in_space = spatial != _FLAT
    name, is_hex = _write_id(plan_id)
    flags = _FORMAT | in_space * _IN_SPACE | is_hex * _HEX | (between is not None) * _INLINE
    parts = (bytes((flags,)), name, _write_count(count), write_numbers(values, expected), spatial if in_space else b"")
    return b"".join(parts) + (b"" if between is None else pack(between))


@dataclass(frozen=True, slots=True)
class Body:
    """What is read of a body.

    Parameters
    ----------
    plan_id : str
    count : int
        Of all its waypoints.
    shared : bool
        Whether those between its ends are entries.
    """

    plan_id: str
    count: int
    shared: bool
    _tokens: list[Token]
    _data: bytes
    _at: int
    _in_space: bool

    def numbers(self) -> list[float]:
        """Return ``NUMBERS``."""
        return [value_of(token) for token in self._tokens[:_COUNT]]

    def ends(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return x, y of the first and the last pose [m]."""
        at = self._tokens
        start, goal = ((value_of(at[i]), value_of(at[i + 1])) for i in (4, 7))
        first = value_of(at[_COUNT], start[0]), value_of(at[_COUNT + 1], start[1])
        return first, (value_of(at[_COUNT + 4], goal[0]), value_of(at[_COUNT + 5], goal[1]))

    def poses(self, shared: list[Poses]) -> Poses:
        """Return the (n, 7) poses, made of the entries between the ends."""
        tokens, at = read_tokens(self._data, _COUNT + 12, self._at)
        first, before, last = self._end_poses(tokens, self._data[at : at + len(_FLAT)])
        between = list(shared)
        if not self.shared and self.count > 3:
            between.append(poses_of(unpack(self._data[at + len(_FLAT) * self._in_space :])))
        parts = [first[None], *between, before[None], last[None]]
        if self.count < 3:
            parts = parts[-self.count :] if self.count == 1 else [parts[0], parts[-1]]
        poses = np.concatenate(parts)
        if len(poses) != self.count:
            raise Unavailable(f"plan {self.plan_id!r} has {len(poses)} waypoints of {self.count}: restore a backup")
        return poses

    def _end_poses(self, tokens: list[Token], spatial: bytes) -> NDArray[np.float64]:
        """Return (3, 7): the first pose, the last but one and the last."""
        at, poses = tokens[_COUNT:], np.zeros((3, 7))
        first, last = self.ends()
        before = value_of(at[8], last[0]), value_of(at[9], last[1])
        heading = quaternion_towards(last[0] - before[0], last[1] - before[1])
        start, goal = (quaternion_near(value_of(self._tokens[i])) for i in (6, 9))
        ends = (first, at[2:4], start), (before, at[10:12], heading), (last, at[6:8], goal)
        for pose, (place, (sine, cosine), foreseen) in zip(poses, ends, strict=True):
            pose[:2] = place
            pose[5:] = value_of(sine, foreseen[0]), value_of(cosine, foreseen[1])
        if self._in_space:
            poses[:, 2:5] = np.frombuffer(spatial, "<f8", 9).reshape(3, 3)
        return poses


def read_body(data: bytes) -> Body:
    """Return what a body tells.

    Raises
    ------
    Unavailable
        It is damaged, or of a release that wrote it otherwise.
    """
    flags = data[0] if data else 0
    if flags & 0x0F != _FORMAT:
        raise Unavailable(f"a stored plan is of format {flags & 0x0F}, which this release does not know: upgrade it")
    if flags & _HEX:
        plan_id, at = data[1:17].hex(), 17
    else:
        at = 2 + data[1]
        plan_id = data[2:at].decode()
    count, shift = 0, 0
    while data[at : at + 1] >= b"\x80":
        count |= (data[at] & 127) << shift
        at, shift = at + 1, shift + 7
    count |= (data[at] if at < len(data) else 0) << shift
    tokens, _ = read_tokens(data, _COUNT + 12, at + 1, _COUNT + 6)  # the rest is for those who want the poses
    return Body(plan_id, count, not flags & _INLINE and count > 3, tokens, data, at + 1, bool(flags & _IN_SPACE))


def places_of_ends(stops: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return (m, 3) rows of the ends of plans that lie one after the other up to ``stops``."""
    begins = np.concatenate(([0], stops[:-1]))
    return np.stack((begins, np.maximum(stops - 2, begins), stops - ENDS_BEFORE), axis=1)


def _write_id(plan_id: str) -> tuple[bytes, bool]:
    """Return an id as bytes, and whether it is of 16 bytes in hex."""
    if len(plan_id) == 32 and not set(plan_id) - _DIGITS:
        return bytes.fromhex(plan_id), True
    data = plan_id.encode()
    return bytes((len(data),)) + data, False


def _write_count(count: int) -> bytes:
    data = bytearray()
    while count >= 128:
        data.append(count & 127 | 128)
        count >>= 7
    return bytes((*data, count))
