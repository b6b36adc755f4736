"""Plan bodies: the part of a plan that no other plan shares, as bytes: id, numbers, ends, and short waypoint lists."""

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
"""Allowance for rounding of stored ends [m]."""

NAMES = ("created", "length", "cost", "seconds", "start_x", "start_y", "start_yaw", "goal_x", "goal_y", "goal_yaw")
"""Numbers of a plan, in the order in which they are stored."""

_LENGTH = NAMES.index("length")
_PLANAR_COLUMNS, _SPATIAL_COLUMNS = [0, 1, 5, 6], [2, 3, 4]
_START, _GOAL = NUMBERS, NUMBERS + 4
_ENDS = [_START, _START + 1, _GOAL, _GOAL + 1]


def write_bodies(
    plan_ids: Sequence[str],
    numbers: Sequence[Sequence[float]],
    words: NDArray[np.uint64],
    stops: NDArray[np.int64],
    between: Sequence[bytes | None],
) -> tuple[list[bytes], NDArray[np.float64]]:
    """Return the bodies of plans, and (m, 4), x and y of their ends [m].

    Parameters
    ----------
    plan_ids : sequence of str
        Ids of the plans.
    numbers : sequence of 10 floats each
        Values of ``NAMES``.
    words : (n, 7) uint64 array
        Bits of the poses of all plans, one plan after the other.
    stops : (m,) int64 array
        For each plan the row after its last pose.
    between : sequence of bytes or None
        Codes of the waypoints between the ends; None if these are stored as shared entries, or there are none.
    """
    values, spatial_bits = np.empty((len(plan_ids), COUNT)), np.empty((len(plan_ids), 10), np.uint64)
    values[:, :NUMBERS] = numbers
    out, ends = np.empty(MOST * len(plan_ids), np.uint8), np.empty(len(plan_ids), np.int64)
    write_numbers(words, stops, values, spatial_bits, out, ends)
    in_space = (spatial_bits[:, 9] != 0).tolist()
    data, begin, before, bodies = out[: ends[-1]].tobytes(), 0, 0, []
    for number, (end, stop) in enumerate(zip(ends.tolist(), stops.tolist(), strict=True)):
        name, is_hex = _write_id(plan_ids[number])
        z_bytes = spatial_bits[number, :9].tobytes() if in_space[number] else b""
        code = between[number]
        flags = FORMAT | in_space[number] * _IN_SPACE | is_hex * HEX | (code is not None) * _INLINE
        own = data[begin:end] + z_bytes + (b"" if code is None else pack(code))
        bodies.append(bytes((flags,)) + name + _write_count(stop - before) + own)
        begin, before = end, stop
    return bodies, values.take(_ENDS, axis=1)


class PlanBody(msgspec.Struct, frozen=True):
    """The decoded body of a plan.

    It is not a dataclass: a search creates dozens, and that would take eight times as long.

    Parameters
    ----------
    plan_id : str
        Id of the plan.
    count : int
        Number of all its waypoints.
    shared : bool
        Whether the waypoints between its ends are stored as shared entries.
    """

    plan_id: str
    count: int
    shared: bool
    _values: list[float]
    _remainder: bytes
    _in_space: bool

    def numbers(self) -> list[float]:
        """Return the values of ``NAMES``."""
        return self._values[:NUMBERS]

    def ends(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return x, y of the first and the last pose [m]."""
        at = self._values
        return (at[_START], at[_START + 1]), (at[_GOAL], at[_GOAL + 1])

    def poses(self, shared: Sequence[Poses]) -> Poses:
        """Return the (n, 7) poses, given the poses of the shared entries between the ends.

        Raises
        ------
        Unavailable
            The number of poses is wrong.
        """
        ends = np.zeros((3, 7))
        ends[:, _PLANAR_COLUMNS] = np.array(self._values[NUMBERS:]).reshape(3, 4)
        size = 3 * len(_SPATIAL_COLUMNS) * 8 if self._in_space else 0
        if self._in_space:
            ends[:, _SPATIAL_COLUMNS] = np.frombuffer(self._remainder, "<f8", 9).reshape(3, 3)
        between = list(shared)
        if not self.shared and self.count > 3:
            between.append(poses_in([self._remainder[size:]]))
        # The three poses that a plan does not share are stored as first, last, last but one.
        parts = [ends[:1], *between, ends[2:], ends[1:2]]
        if self.count < 3:
            parts = [ends[:1], ends[1:2]][: self.count]
        poses = np.concatenate(parts)
        if len(poses) != self.count:
            raise Unavailable(
                f"plan {self.plan_id!r} has {len(poses)} waypoints instead of {self.count}: restore it from a backup"
            )
        return poses


def read_body(data: bytes) -> PlanBody:
    """Return a decoded body; raises as `read_bodies`."""
    [body] = read_bodies([data])
    return body


def read_bodies(bodies: Sequence[bytes]) -> list[PlanBody]:
    """Return decoded bodies.

    Raises
    ------
    Unavailable
        A body is damaged, or another release wrote it in another format.
    """
    return list(_Numbers(bodies).bodies(range(len(bodies))))


def bodies_near(
    bodies: Sequence[bytes], start: Position, goal: Position, tolerance: float
) -> Iterator[tuple[int, PlanBody]]:
    """Yield the index and the decoded body of each plan whose ends may lie within a tolerance of two positions [m].

    Shorter plans come first. An allowance for rounding admits ends that are up to a micrometre too far away.

    Raises
    ------
    Unavailable
        As `read_bodies`.
    """
    read = _Numbers(bodies)
    x, y, to_x, to_y = map(float, (*start, *goal))
    near = np.flatnonzero(ends_near(read.values, (x, y, to_x, to_y), tolerance + _MARGIN))
    order = near[np.argsort(read.values[near, _LENGTH], kind="stable")].tolist()
    return zip(order, read.bodies(order), strict=True)


def id_in(data: bytes) -> str:
    """Return the id of the plan with this body."""
    flags = data[0] if data else 0
    if flags & 0x0F != FORMAT:
        raise Unavailable(f"a stored plan has format {flags & 0x0F}, and this release reads {FORMAT}: upgrade PPaaS")
    return data[1:17].hex() if flags & HEX else data[2 : 2 + sum(data[1:2])].decode()


class _Numbers:
    """Numbers of several bodies, decoded in one kernel call."""

    def __init__(self, bodies: Sequence[bytes]) -> None:
        self._data = bodies
        first = np.array([0, *itertools.accumulate(map(len, bodies))], np.int64)
        self.values = np.empty((len(bodies), COUNT))
        header = np.empty((3, len(bodies)), np.int64)
        read_bodies_numbers(np.frombuffer(b"".join(bodies), np.uint8), first, self.values, header)
        self._counts, remainders, damaged = header.tolist()
        if any(damaged):
            number = next(number for number, state in enumerate(damaged) if state)
            id_in(bodies[number])  # raises if it has another format
            raise Unavailable("a stored plan is damaged: restore it from a backup")
        self._remainders = remainders

    def bodies(self, which: Iterable[int]) -> Iterator[PlanBody]:
        """Yield the decoded bodies with these indices."""
        return (self._body(at, self._data[at], self.values[at].tolist()) for at in which)

    def _body(self, at: int, data: bytes, numbers: list[float]) -> PlanBody:
        count, flags = self._counts[at], data[0]
        shared = not flags & _INLINE and count > 3
        return PlanBody(id_in(data), count, shared, numbers, data[self._remainders[at] :], bool(flags & _IN_SPACE))


def _write_id(plan_id: str) -> tuple[bytes, bool]:
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
