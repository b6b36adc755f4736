"""Division of plans into segments that other plans may share.

Content-defined chunking by local maximum: each waypoint has a hash, and a plan is cut before a waypoint whose hash is
the largest within G waypoints on either side. The cut depends on these waypoints alone. So equal parts are cut equally
wherever they occur, and stored segments never have to be cut again. Two cuts are more than G apart: no segment is
shorter than G, and a plan of n waypoints has at most n / G segments.

Source: N. Bjørner, A. Blass, Y. Gurevich, *Content-dependent chunking for differential compression, the local maximum
approach*, J. Computer and System Sciences 76 (2010).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.geometry import Poses
from ppaas.plans.encoding.kernels import chunks

ENDS_BEFORE, ENDS_AFTER = chunks.ENDS_BEFORE, chunks.ENDS_AFTER
"""Number of waypoints at the start and at the goal that are never shared."""


def words_of(poses: Poses) -> NDArray[np.uint64]:
    """Return the bits of (n, 7) poses, read-only."""
    words = np.ascontiguousarray(poses, "<f8").view("<u8")
    words.flags.writeable = False
    return words


@dataclass(frozen=True, slots=True)
class Segments:
    """Segments of many plans.

    Parameters
    ----------
    begins, ends : (k,) int64 array
        Rows of each segment, the end excluded, one plan after the other. Rows before the first and after the last
        segment of a plan are never shared.
    parts : (m,) int64 array
        For each plan the index after its last segment.
    shared : (m,) bool array
        Whether its segments may be shared. Otherwise it has at most one, which is too short for that.
    """

    begins: NDArray[np.int64]
    ends: NDArray[np.int64]
    parts: NDArray[np.int64]
    shared: NDArray[np.bool_]


def cut_plans(words: NDArray[np.uint64], stops: NDArray[np.int64], granularity: int) -> Segments:
    """Divide many plans into segments at once.

    Parameters
    ----------
    words : (n, 7) uint64 array
        Bits of the poses of all plans, one plan after the other.
    stops : (m,) int64 array
        For each plan the row after its last pose.
    granularity : int
        G, at least 1.

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


def _check_finite(bad_row: int) -> None:
    if bad_row >= 0:
        raise InvalidInput(f"pose {bad_row}: all numbers of a pose must be finite")
