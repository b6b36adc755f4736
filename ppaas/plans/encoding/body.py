"""What of a plan is its own, as bytes: its id and numbers, its ends, and what of it is too short to be shared."""

import itertools
from collections.abc import Iterable, Iterator, Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.errors import Unavailable
from ppaas.geometry import Poses
from ppaas.plans.encoding.codes import pack, poses_in
from ppaas.plans.encoding.index_cells import Position
from ppaas.plans.encoding.kernels.body import FORMAT, HEX, ends_near, read_bodies_numbers
from ppaas.plans.encoding.kernels.numbers import COUNT, MOST, NUMBERS, write_numbers

_IN_SPACE, _INLINE = 0x10, 0x40

_MARGIN = 1e-6
"""[m]"""

NAMES = ("created", "length", "cost", "seconds", "start_x", "start_y", "start_yaw", "goal_x", "goal_y", "goal_yaw")
"""The numbers of a plan, in the order in which they are told."""

_LENGTH = NAMES.index("length")
_IN_PLANE, _BEYOND = [0, 1, 5, 6], [2, 3, 4]
_FIRST, _LAST = NUMBERS, NUMBERS + 4
_ENDS = [_FIRST, _FIRST + 1, _LAST, _LAST + 1]


def write_bodies(
    plan_ids: Sequence[str],
    numbers: Sequence[Sequence[float]],
    words: NDArray[np.uint64],
    stops: NDArray[np.int64],
    between: Sequence[bytes | None],
) -> tuple[list[bytes], NDArray[np.float64]]:
    """Return the bodies of plans, and (m, 4), x and y of their ends.

    Parameters
    ----------
    plan_ids : sequence of str
    numbers : sequence of 10 floats each
        ``NAMES``.
    words : (n, 7) array
        The bits of the poses of all plans, one plan after the other.
    stops : (m,) array
        For each plan the row behind its last pose.
    between : sequence of bytes or None
        The codes of the waypoints between; None where they are entries, or there are none.
    """
    values, beyond = np.empty((len(plan_ids), COUNT)), np.empty((len(plan_ids), 10), np.uint64)
    values[:, :NUMBERS] = numbers
    out, ends = np.empty(MOST * len(plan_ids), np.uint8), np.empty(len(plan_ids), np.int64)
    write_numbers(words, stops, values, beyond, out, ends)
    in_space = (beyond[:, 9] != 0).tolist()
    data, begin, before, bodies = out[: ends[-1]].tobytes(), 0, 0, []
    for number, (end, stop) in enumerate(zip(ends.tolist(), stops.tolist(), strict=True)):
        name, is_hex = _write_id(plan_ids[number])
        spatial = beyond[number, :9].tobytes() if in_space[number] else b""
        code = between[number]
        flags = FORMAT | in_space[number] * _IN_SPACE | is_hex * HEX | (code is not None) * _INLINE
        own = data[begin:end] + spatial + (b"" if code is None else pack(code))
        bodies.append(bytes((flags,)) + name + _write_count(stop - before) + own)
        begin, before = end, stop
    return bodies, values.take(_ENDS, axis=1)


class PlanBody(msgspec.Struct, frozen=True):
    """What is read of a body. No dataclass: a search makes dozens, and such takes them eight times as long.

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
    _values: list[float]
    _rest: bytes
    _in_space: bool

    def numbers(self) -> list[float]:
        """Return ``NAMES``."""
        return self._values[:NUMBERS]

    def ends(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return x, y of the first and the last pose [m]."""
        at = self._values
        return (at[_FIRST], at[_FIRST + 1]), (at[_LAST], at[_LAST + 1])

    def poses(self, shared: Sequence[Poses]) -> Poses:
        """Return the (n, 7) poses, made of the entries between the ends."""
        ends = np.zeros((3, 7))
        ends[:, _IN_PLANE] = np.array(self._values[NUMBERS:]).reshape(3, 4)
        size = 3 * len(_BEYOND) * 8 if self._in_space else 0
        if self._in_space:
            ends[:, _BEYOND] = np.frombuffer(self._rest, "<f8", 9).reshape(3, 3)
        between = list(shared)
        if not self.shared and self.count > 3:
            between.append(poses_in([self._rest[size:]]))
        parts = [ends[:1], *between, ends[2:], ends[1:2]]
        if self.count < 3:
            parts = [ends[:1], ends[1:2]][: self.count]
        poses = np.concatenate(parts)
        if len(poses) != self.count:
            raise Unavailable(f"plan {self.plan_id!r} has {len(poses)} waypoints of {self.count}: restore a backup")
        return poses


def read_body(data: bytes) -> PlanBody:
    """Return what a body tells; as `read_bodies`."""
    [body] = read_bodies([data])
    return body


def read_bodies(bodies: Sequence[bytes]) -> list[PlanBody]:
    """Return what bodies tell.

    Raises
    ------
    Unavailable
        One is damaged, or of a release that wrote it otherwise.
    """
    return list(_Numbers(bodies).bodies(range(len(bodies))))


def bodies_near(
    bodies: Sequence[bytes], start: Position, goal: Position, tolerance: float
) -> Iterator[tuple[int, PlanBody]]:
    """Yield which bodies have ends that may lie within a tolerance of two places [m], and what these tell.

    Those of the shortest plans come first. What is rounded away hides none: one may lie a micrometre further off.

    Raises
    ------
    Unavailable
        As of `read_bodies`.
    """
    read = _Numbers(bodies)
    x, y, to_x, to_y = map(float, (*start, *goal))
    near = np.flatnonzero(ends_near(read.values, (x, y, to_x, to_y), tolerance + _MARGIN))
    order = near[np.argsort(read.values[near, _LENGTH], kind="stable")].tolist()
    return zip(order, read.bodies(order), strict=True)


def id_in(data: bytes) -> str:
    """Return the id of a plan by its body."""
    flags = data[0] if data else 0
    if flags & 0x0F != FORMAT:
        raise Unavailable(f"a stored plan is of format {flags & 0x0F}, which this release does not know: upgrade it")
    return data[1:17].hex() if flags & HEX else data[2 : 2 + sum(data[1:2])].decode()


class _Numbers:
    """The numbers in some bodies, read all together."""

    def __init__(self, bodies: Sequence[bytes]) -> None:
        self._data = bodies
        first = np.array([0, *itertools.accumulate(map(len, bodies))], np.int64)
        self.values = np.empty((len(bodies), COUNT))
        places = np.empty((3, len(bodies)), np.int64)
        read_bodies_numbers(np.frombuffer(b"".join(bodies), np.uint8), first, self.values, places)
        self._counts, rests, states = places.tolist()
        if any(states):
            number = next(number for number, state in enumerate(states) if state)
            id_in(bodies[number])  # tells if it is of another format
            raise Unavailable("a stored plan is damaged: restore it from a backup")
        self._rests = rests

    def bodies(self, which: Iterable[int]) -> Iterator[PlanBody]:
        """Yield what some of the bodies tell."""
        return (self._body(at, self._data[at], self.values[at].tolist()) for at in which)

    def _body(self, at: int, data: bytes, numbers: list[float]) -> PlanBody:
        count, flags = self._counts[at], data[0]
        shared = not flags & _INLINE and count > 3
        return PlanBody(id_in(data), count, shared, numbers, data[self._rests[at] :], bool(flags & _IN_SPACE))


def _write_id(plan_id: str) -> tuple[bytes, bool]:
    """Return an id as bytes, and whether it is of 16 bytes in hex."""
    if len(plan_id) == 32:
        try:
            data = bytes.fromhex(plan_id)
        except ValueError:
            data = b""
        if data.hex() == plan_id:
            return data, True
    data = plan_id.encode()
    return bytes((len(data),)) + data, False


def _write_count(count: int) -> bytes:
    data = bytearray()
    while count >= 128:
        data.append(count & 127 | 128)
        count >>= 7
    return bytes((*data, count))
