"""What will take how long: computing a plan, by planner and complexity, and getting a kept one, by link.

Both say how sure they are. Times of computing are taken to be log-normal; with few samples of a complexity, those of
others help by a line through them all (time grows with a power of the distance). Times of a link are a round trip and
so much a byte, by weighted least squares that forget: old answers count less, and after minutes without any the
estimate is back at what a link is taken to be before it was measured.
"""

import math
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

from ppaas.clock import Clock, monotonic
from ppaas.plans.history import LOG_UNITS, LinkHistory, PlannerHistory, bucket_of

ROUND_TRIP = 0.002
BYTES_PER_SECOND = 2e8
"""What is believed of a link that was not measured."""

LARGE = 1e5
"""Bytes of an answer that takes what its bytes take."""

FORGET = 0.9
"""What an answer still counts for when one more has come."""

HALF_LIFE = 60.0
"""Seconds in which an answer comes to count half."""

MEMORY = 64.0
"""Times of one planner and complexity that count; older ones fade."""

SPREAD = 0.5
"""Standard deviation of the logarithm of a time before anything was measured …"""

SPREAD_SAMPLES = 2.0
"""… and how many measured ones that is worth."""

ENOUGH = 8.0
"""Samples of one complexity that need no help from others."""

STEEPEST = 2.0
"""Time grows with the distance at most like this power of it: as the area does."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A time in seconds, one standard deviation around it, and how many measured ones it rests on."""

    mean: float
    lower: float
    upper: float
    samples: float


class _Logs(NamedTuple):
    """How many times of one planner and complexity there are, and sums of their logarithms and of the squares."""

    number: float = 0.0
    total: float = 0.0
    squares: float = 0.0

    def plus(self, number: float, total: float, squares: float) -> "_Logs":
        """Return these and others; of all that is more than `MEMORY` times, the older ones fade."""
        keep = min(1.0, max(MEMORY - number, 0.0) / self.number) if self.number else 1.0
        take = min(1.0, MEMORY / number)
        return _Logs(
            keep * self.number + take * number, keep * self.total + take * total, keep * self.squares + take * squares
        )

    @property
    def mean(self) -> float:
        return self.total / self.number

    @property
    def variance(self) -> float:
        return max(self.squares / self.number - self.mean**2, 0.0)


class ComputationTimes:
    """How long planners take on one map.

    Several threads may use it: of what two of them note at the same moment, one may be lost.
    """

    def __init__(self) -> None:
        self._logs: defaultdict[str, dict[int, _Logs]] = defaultdict(dict)

    def note(self, planner: str, cells: float, seconds: float) -> None:
        """Take the time that a plan of this complexity took."""
        log = math.log(max(seconds * 1e6, 1.0))
        self._add(planner, bucket_of(cells), 1.0, log, log * log)

    def add(self, rows: Iterable[PlannerHistory]) -> None:
        """Take what was kept before."""
        for row in rows:
            if row.computed > 0:
                logs, squares = row.logs / LOG_UNITS, row.squares / LOG_UNITS
                self._add(row.planner, row.bucket, float(row.computed), logs, squares)

    def _add(self, planner: str, bucket: int, count: float, total: float, squares: float) -> None:
        known = self._logs[planner]
        known[bucket] = known.get(bucket, _Logs()).plus(count, total, squares)

    def expect(self, planner: str, cells: float) -> Estimate | None:
        """Return how long a plan will take; None if none of this planner was measured."""
        known = self._logs.get(planner)
        if not known:
            return None
        bucket = bucket_of(cells)
        own = known.get(bucket)
        if own is not None and own.number >= ENOUGH:
            return _log_normal(own.mean, own.variance, own.number)
        return _log_normal(*_with_help(dict(known), bucket))


def _with_help(known: dict[int, _Logs], bucket: int) -> tuple[float, float, float]:
    """Return mean, variance and weight for a bucket of few samples, or none, from the line through all buckets."""
    weight = sum(logs.number for logs in known.values())
    middle = sum(logs.number * at for at, logs in known.items()) / weight
    mean = sum(logs.total for logs in known.values()) / weight
    across = sum(logs.number * (at - middle) ** 2 for at, logs in known.items())
    along = sum(logs.number * (at - middle) * (logs.mean - mean) for at, logs in known.items())
    steepest = STEEPEST * math.log(2.0) / 2.0  # a bucket is half an octave
    slope = min(max(along / across, 0.0), steepest) if across else 0.0
    rest = sum(logs.number * (logs.variance + _off(at, logs, middle, mean, slope) ** 2) for at, logs in known.items())
    line = mean + slope * (bucket - middle)
    nearest = min(abs(at - bucket) for at in known)
    # What the slope is off by counts for each bucket that lies between.
    variance = rest / weight + (nearest * steepest / 4.0) ** 2
    own = known.get(bucket)
    if own is None:
        return line, variance, 1.0
    helped = (own.total + SPREAD_SAMPLES * line) / (own.number + SPREAD_SAMPLES)
    return helped, variance, own.number + SPREAD_SAMPLES


def _off(at: int, logs: _Logs, middle: float, mean: float, slope: float) -> float:
    return logs.mean - mean - slope * (at - middle)


def _log_normal(mean: float, variance: float, count: float) -> Estimate:
    spread = (variance * count + SPREAD**2 * SPREAD_SAMPLES) / (count + SPREAD_SAMPLES)
    off = math.sqrt(spread * (1.0 + 1.0 / count))
    return Estimate(math.exp(mean) / 1e6, math.exp(mean - off) / 1e6, math.exp(mean + off) / 1e6, count)


class LinkTimes:
    """How long answers take that come over one link.

    Parameters
    ----------
    clock : callable
        Monotonic seconds.
    round_trip, bandwidth : float
        What is believed of it before it is measured [s, bytes/s].
    """

    def __init__(
        self, clock: Clock = monotonic, round_trip: float = ROUND_TRIP, bandwidth: float = BYTES_PER_SECOND
    ) -> None:
        self._clock = clock
        self._at = clock()
        self._sums: _Sums = (0.0,) * 6
        self._answers = 0
        # Two answers that were never measured: an empty one, and one of some thousand poses.
        self._prior = _plus(_sums(0.25, 0.0, round_trip), _sums(0.25, LARGE, round_trip + LARGE / bandwidth))

    def note(self, size: float, seconds: float) -> None:
        """Take the time until an answer of so many bytes was here."""
        self._sums = _plus(_times(self._sums, FORGET * self._age()), _sums(1.0, size, seconds))
        self._at = self._clock()
        self._answers += 1

    def believe(self, history: LinkHistory) -> None:
        """Take what was measured before this began, like two answers."""
        empty = _sums(1.0, 0.0, history.round_trip)
        full = _sums(1.0, LARGE, history.round_trip + LARGE / history.bandwidth)
        self._sums = _plus(self._sums, _plus(empty, full))
        self._answers += history.answers

    @property
    def answers(self) -> int:
        """How many answers were measured, those before this began too."""
        return self._answers

    def _age(self) -> float:
        return float(0.5 ** (max(self._clock() - self._at, 0.0) / HALF_LIFE))

    def expect(self, size: float) -> Estimate:
        """Return how long an answer of so many bytes will take."""
        sums = _plus(_times(self._sums, self._age()), self._prior)
        each, base, variance = _line(sums)
        mean, off = base + each * size, math.sqrt(variance * (1.0 + 1.0 / sums[0]))
        return Estimate(mean, max(mean - off, 0.0), mean + off, sums[0] - self._prior[0])

    def history(self, link: str, now: float) -> LinkHistory:
        """Return what to keep; ``now`` is seconds since the epoch."""
        each, base, _ = _line(_plus(self._sums, self._prior))
        return LinkHistory(link, base, 1.0 / max(each, 1e-12), self._answers, now)


_Sums = tuple[float, ...]


def _sums(weight: float, size: float, seconds: float) -> _Sums:
    return weight, weight * size, weight * seconds, weight * size**2, weight * size * seconds, weight * seconds**2


def _plus(one: _Sums, other: _Sums) -> _Sums:
    return tuple(a + b for a, b in zip(one, other, strict=True))


def _times(sums: _Sums, factor: float) -> _Sums:
    return tuple(each * factor for each in sums)


def _line(sums: _Sums) -> tuple[float, float, float]:
    """Return seconds a byte, seconds without any, and the variance around that line."""
    weight, sizes, seconds, sizes2, both, seconds2 = sums
    size, mean = sizes / weight, seconds / weight
    across, along = sizes2 / weight - size**2, both / weight - size * mean
    each = min(max(along / across, 0.0), mean / size) if across > 0.0 and size > 0.0 else 0.0
    variance = seconds2 / weight - mean**2 - 2.0 * each * along + each**2 * across
    return each, mean - each * size, max(variance, 0.0)
