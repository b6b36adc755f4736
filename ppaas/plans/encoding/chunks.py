"""Where plans are cut into stretches that other plans may share.

Content-defined chunks by local maximum: each waypoint has a hash, and a plan is cut before a waypoint whose hash is the
largest of all within G waypoints on either side. Whether it is cut there depends on these alone, so equal stretches are
cut equally wherever they lie, and nothing that is stored ever has to be cut again. Two cuts are more than G apart: no
stretch is shorter than G, and no plan of n waypoints has more than n / G.

N. Bjørner, A. Blass, Y. Gurevich, *Content-dependent chunking for differential compression, the local maximum
approach*, J. Computer and System Sciences 76 (2010).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.geometry import Poses
from ppaas.plans.encoding.kernels import chunks

GRANULARITY = 16
"""The paper's: a length in waypoints. It divides a plan into stretches of which at most its length / G are shared, and
a shared stretch longer than it becomes an entry."""

MOST_GRANULARITY = 65536

_ZERO = np.zeros(1, np.int64)


ENDS_BEFORE, ENDS_AFTER = chunks.ENDS_BEFORE, chunks.ENDS_AFTER
"""Waypoints that are a plan's own: they are never shared."""


def inner_granularity(granularity: int) -> int:
    """Return what to cut with for the paper's granularity: a half of it.

    A shared stretch that is little longer than G may hold no whole chunk of G, and mostly holds one of a half.

    Raises
    ------
    InvalidInput
        It is not a whole number from 2 to 65536.
    """
    if not 2 <= granularity <= MOST_GRANULARITY:
        raise InvalidInput(f"granularity: {granularity} is no number of waypoints from 2 to {MOST_GRANULARITY}")
    return granularity // 2


def words_of(poses: Poses) -> NDArray[np.uint64]:
    """Return the bits of (n, 7) poses, to be read."""
    words = np.ascontiguousarray(poses, "<f8").view("<u8")
    words.flags.writeable = False
    return words


def waypoint_hashes(words: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Return a hash of each of (n, 7) poses, told by their bits: the same on every machine.

    Raises
    ------
    InvalidInput
        One is not finite.
    """
    hashes = np.empty(len(words), np.uint64)
    _check_finite(chunks.hash_waypoints(words, hashes))
    return hashes


@dataclass(frozen=True, slots=True)
class Segments:
    """Where the stretches of many plans lie.

    Parameters
    ----------
    begins, ends : (k,) array
        Their rows, from the first to behind the last, of one plan after the other. What is before the first of a plan
        and behind its last is its own.
    parts : (m,) array
        For each plan where its stretches end.
    shared : (m,) array
        Whether its stretches may be shared. Otherwise it has one, which is too short for that, or none.
    """

    begins: NDArray[np.int64]
    ends: NDArray[np.int64]
    parts: NDArray[np.int64]
    shared: NDArray[np.bool_]


def cut_plans(words: NDArray[np.uint64], stops: NDArray[np.int64], granularity: int) -> Segments:
    """Cut many plans at once.

    Parameters
    ----------
    words : (n, 7) array
        The bits of the poses of all plans, one plan after the other.
    stops : (m,) array
        For each plan the row behind its last pose.
    granularity : int
        G, one at least.

    Raises
    ------
    InvalidInput
        A pose is not finite.
    """
    most = len(words) // granularity + len(stops) + 1
    begins, ends, parts = np.empty(most, np.int64), np.empty(most, np.int64), np.empty(len(stops), np.int64)
    _check_finite(chunks.cut(words, stops, granularity, begins, ends, parts))
    between = stops.copy()
    between[1:] -= stops[:-1]
    shared = between >= granularity + ENDS_BEFORE + ENDS_AFTER
    return Segments(begins[: parts[-1]], ends[: parts[-1]], parts, shared)


def _check_finite(infinite: int) -> None:
    if infinite >= 0:
        raise InvalidInput(f"pose {infinite} is not finite: give numbers")
