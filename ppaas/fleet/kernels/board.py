"""Arrays that the kernels of fleet plans share, and their random numbers.

Cells are numbered from 0 to v − 1, robots from 0 to n − 1. A cell has at most four neighbours.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import bare, joined

Ints = NDArray[np.int32]

NOBODY = np.int32(-1)
"""Robot of an empty cell, and cell of a robot that has not decided yet."""

UNREACHABLE = np.int16(32_000)
"""Distance of cells from which a goal cannot be reached [cells]; greatest distance, plus one, that a table may have."""


NO_AREAS = np.empty(0, np.uint64)
"""Areas of cells of which none is in one."""


class Board(NamedTuple):
    """Cells, and where the robots want to go.

    Parameters
    ----------
    neighbours : (v, 4) int32 array
        Cells to which a robot may move from each cell, −1 behind the last one.
    distances : (n, v) int16 array
        Distance of each cell from the goal of each robot [cells], `UNREACHABLE` without a way.
    guide : (n, v) int8 array
        Index of the neighbour to which the guide of a robot leads, −1 off its way; (0, 0) without guides.
    goals : (n,) int32 array
        Goal of each robot.
    areas : (v,) uint64 array
        Areas that each cell is in, as bits: bit a for area a. (0,) without areas.
    room : (a,) int32 array
        Number of robots that may be in each area at a time.
    barred : (s, v) bool array
        True for cells that robots of each size do not enter; (0, 0) if all robots may enter all cells.
    sizes : (n,) int8 array
        Size of each robot, a row of ``barred``; (0,) without it.
    """

    neighbours: Ints
    distances: NDArray[np.int16]
    guide: NDArray[np.int8]
    goals: Ints
    areas: NDArray[np.uint64]
    room: Ints
    barred: NDArray[np.bool_]
    sizes: NDArray[np.int8]


class Step(NamedTuple):
    """One step of all robots while it is decided.

    Parameters
    ----------
    at, to : (n,) int32 array
        Cells before and after the step; ``to`` is −1 for robots that have not decided.
    here, next : (v,) int32 array
        Robot in each cell before and after the step, −1 for none. Both are −1 everywhere between two steps.
    pushed : (n + 1,) int32 array
        Stack of the robots that push each other away.
    turn : (n + 1,) int32 array
        Index of the choice that each robot of the stack has taken.
    choices : (n + 1, 7) int32 array
        Cells of each robot of the stack from the best to the worst, their number at `COUNT`, and the robot with which
        it swaps, or −1, at `PARTNER`.
    keys : (5,) float32 array
        Scratch memory.
    inside : (a,) int32 array
        Number of robots in each area before the step, and of those that have decided to enter it.
    bits : (1,) uint64 array
        State of the random numbers.
    """

    at: Ints
    to: Ints
    here: Ints
    next: Ints
    pushed: Ints
    turn: Ints
    choices: Ints
    keys: NDArray[np.float32]
    inside: Ints
    bits: NDArray[np.uint64]


COUNT, PARTNER = 5, 6

NOT_BARRED = np.empty((0, 0), np.bool_)
"""Barred cells of robots that may enter all."""

ONE_SIZE = np.empty(0, np.int8)
"""Sizes of robots that may enter all cells."""

NO_GUIDE = np.empty((0, 0), np.int8)
"""Guides of robots that have none."""


def smallest_board(guide: NDArray[np.int8] = NO_GUIDE) -> Board:
    """Return a board of two cells for one robot, whose goal is the second one: for ``warm`` of kernels."""
    neighbours = np.array([[1, -1, -1, -1], [0, -1, -1, -1]], np.int32)
    distances, goals = np.array([[1, 0]], np.int16), np.ones(1, np.int32)
    return Board(neighbours, distances, guide, goals, NO_AREAS, np.empty(0, np.int32), NOT_BARRED, ONE_SIZE)


@joined
def is_barred(board: Board, robot: int, cell: int) -> bool:
    """Return whether a robot is too large to enter a cell."""
    return bool(len(board.barred) > 0 and board.barred[board.sizes[robot], cell])


def step_of(board: Board, at: Ints, seed: int) -> Step:
    """Return the arrays for the steps of robots that are in the cells ``at``; seeds give the same random numbers."""
    n, cells = len(at), len(board.neighbours)
    return Step(
        at.astype(np.int32),
        np.full(n, NOBODY, np.int32),
        np.full(cells, NOBODY, np.int32),
        np.full(cells, NOBODY, np.int32),
        np.empty(n + 1, np.int32),
        np.empty(n + 1, np.int32),
        np.empty((n + 1, 7), np.int32),
        np.empty(5, np.float32),
        np.zeros(len(board.room), np.int32),
        seeded(seed),
    )


def seeded(seed: int) -> NDArray[np.uint64]:
    """Return the state of random numbers that begin with a seed."""
    return np.random.default_rng(seed).integers(1, 1 << 63, 1, np.uint64)


@joined
def draw(bits: NDArray[np.uint64]) -> np.uint64:
    """Return 64 random bits: the xorshift generator of Marsaglia (2003)."""
    x = bits[0]
    x ^= x << np.uint64(13)
    x ^= x >> np.uint64(7)
    x ^= x << np.uint64(17)
    bits[0] = x
    return x  # type: ignore[no-any-return]


@joined
def fraction(bits: NDArray[np.uint64]) -> np.float32:
    """Return a random number between 0 and 1."""
    return np.float32(draw(bits) >> np.uint64(40)) * np.float32(2.0**-24)


@joined
def below(bits: NDArray[np.uint64], limit: int) -> np.int64:
    """Return a random whole number of at least 0 and below ``limit``."""
    return np.int64((draw(bits) >> np.uint64(33)) % np.uint64(limit))


@bare
def shuffle(bits: NDArray[np.uint64], items: Ints) -> None:
    """Bring items into a random order."""
    for last in range(len(items) - 1, 0, -1):
        other = below(bits, last + 1)
        items[last], items[other] = items[other], items[last]


def warm() -> None:
    """Compile and call each kernel once."""
    shuffle(seeded(0), np.arange(3, dtype=np.int32))
