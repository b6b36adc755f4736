"""Time estimates: computing a plan, by planner and complexity, and getting a stored one, by link.

Both give a standard deviation. Computing times are assumed to be log-normal. If a complexity has few samples, samples
of the others contribute through a regression line (the time grows with a power of the distance). The time of a link is
a round trip plus a time per byte, fitted by weighted least squares with exponential forgetting. After minutes without
an answer, the estimate returns to the prior of an unmeasured link.
"""

import math
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

from ppaas.clock import Clock, monotonic
from ppaas.plans.history import LOG_UNITS, LinkHistory, PlannerHistory, bucket_of

ROUND_TRIP = 0.002
"""Prior round trip of a link that was not measured [s]."""

BYTES_PER_SECOND = 2e8
"""Prior bandwidth of a link that was not measured [bytes/s]."""

LARGE_ANSWER = 1e5
"""Size of an answer whose time is dominated by its bytes [bytes]."""

DECAY = 0.9
"""Factor on the weight of an answer for each later answer."""

HALF_LIFE = 60.0
"""Time in which the weight of an answer halves [s]."""

MOST_SAMPLES = 64.0
"""Largest weight of the samples of one planner and complexity; older ones fade."""

PRIOR_SPREAD = 0.5
"""Prior standard deviation of the logarithm of a time."""

PRIOR_SAMPLES = 2.0
"""Weight of that prior [samples]."""

ENOUGH_SAMPLES = 8.0
"""Number of samples from which on a complexity needs no regression."""

LARGEST_EXPONENT = 2.0
"""Largest power of the distance with which the time may grow: the area's power."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """Estimated time [s], mean minus and plus one standard deviation [s], and the number of samples it rests on."""

    mean: float
    lower: float
    upper: float
    samples: float


class _LogSums(NamedTuple):
    """Number of times of one planner and complexity, and the sums of their logarithms and of the squares of these."""

    number: float = 0.0
    total: float = 0.0
    squares: float = 0.0

    def plus(self, number: float, total: float, squares: float) -> "_LogSums":
        """Return the sums of both; if that exceeds `MOST_SAMPLES`, the older samples fade."""
        keep = min(1.0, max(MOST_SAMPLES - number, 0.0) / self.number) if self.number else 1.0
        take = min(1.0, MOST_SAMPLES / number)
        return _LogSums(
            keep * self.number + take * number, keep * self.total + take * total, keep * self.squares + take * squares
        )

    @property
    def mean(self) -> float:
        return self.total / self.number

    @property
    def variance(self) -> float:
        return max(self.squares / self.number - self.mean**2, 0.0)


class ComputationTimes:
    """Computing times of planners on one map.

    Several threads may use it. Of two samples noted at the same moment, one may be lost.
    """

    def __init__(self) -> None:
        self._logs: defaultdict[str, dict[int, _LogSums]] = defaultdict(dict)

    def note(self, planner: str, cells: float, seconds: float) -> None:
        """Add the computing time of a plan of this complexity [s]."""
        log = math.log(max(seconds * 1e6, 1.0))
        self._add(planner, bucket_of(cells), 1.0, log, log * log)

    def add(self, rows: Iterable[PlannerHistory]) -> None:
        """Add stored samples."""
        for row in rows:
            if row.computed > 0:
                logs, squares = row.logs / LOG_UNITS, row.squares / LOG_UNITS
                self._add(row.planner, row.bucket, float(row.computed), logs, squares)

    def _add(self, planner: str, bucket: int, count: float, total: float, squares: float) -> None:
        known = self._logs[planner]
        known[bucket] = known.get(bucket, _LogSums()).plus(count, total, squares)

    def expect(self, planner: str, cells: float) -> Estimate | None:
        """Return the estimated computing time of a plan; None if this planner was never measured."""
        known = self._logs.get(planner)
        if not known:
            return None
        bucket = bucket_of(cells)
        own = known.get(bucket)
        if own is not None and own.number >= ENOUGH_SAMPLES:
            return _log_normal(own.mean, own.variance, own.number)
        return _log_normal(*_with_regression(dict(known), bucket))


def _with_regression(known: dict[int, _LogSums], bucket: int) -> tuple[float, float, float]:
    """Return mean, variance and weight for a bucket with few samples or none, from the line through all buckets."""
    weight = sum(logs.number for logs in known.values())
    middle = sum(logs.number * at for at, logs in known.items()) / weight
    mean = sum(logs.total for logs in known.values()) / weight
    across = sum(logs.number * (at - middle) ** 2 for at, logs in known.items())
    along = sum(logs.number * (at - middle) * (logs.mean - mean) for at, logs in known.items())
    steepest = LARGEST_EXPONENT * math.log(2.0) / 2.0  # a bucket is half an octave
    slope = min(max(along / across, 0.0), steepest) if across else 0.0
    rest = sum(
        logs.number * (logs.variance + _residual(at, logs, middle, mean, slope) ** 2) for at, logs in known.items()
    )
    line = mean + slope * (bucket - middle)
    nearest = min(abs(at - bucket) for at in known)
    # The error of the slope counts once for each bucket between.
    variance = rest / weight + (nearest * steepest / 4.0) ** 2
    own = known.get(bucket)
    if own is None:
        return line, variance, 1.0
    blended = (own.total + PRIOR_SAMPLES * line) / (own.number + PRIOR_SAMPLES)
    return blended, variance, own.number + PRIOR_SAMPLES


def _residual(at: int, logs: _LogSums, middle: float, mean: float, slope: float) -> float:
    return logs.mean - mean - slope * (at - middle)


def _log_normal(mean: float, variance: float, count: float) -> Estimate:
    spread = (variance * count + PRIOR_SPREAD**2 * PRIOR_SAMPLES) / (count + PRIOR_SAMPLES)
    deviation = math.sqrt(spread * (1.0 + 1.0 / count))
    return Estimate(math.exp(mean) / 1e6, math.exp(mean - deviation) / 1e6, math.exp(mean + deviation) / 1e6, count)


class LinkTimes:
    """Times of answers that arrive over one link.

    Parameters
    ----------
    clock : callable
        Monotonic clock [s].
    round_trip, bandwidth : float
        Prior values, before the first measurement [s, bytes/s].
    """

    def __init__(
        self, clock: Clock = monotonic, round_trip: float = ROUND_TRIP, bandwidth: float = BYTES_PER_SECOND
    ) -> None:
        self._clock = clock
        self._at = clock()
        self._sums: _Sums = (0.0,) * 6
        self._answers = 0
        # The prior counts as two answers of weight 1/4: an empty one, and one with some thousand poses.
        self._prior = _plus(
            _sums(0.25, 0.0, round_trip), _sums(0.25, LARGE_ANSWER, round_trip + LARGE_ANSWER / bandwidth)
        )

    def note(self, size: float, seconds: float) -> None:
        """Add the time of an answer of ``size`` bytes [s]."""
        self._sums = _plus(_scaled(self._sums, DECAY * self._age()), _sums(1.0, size, seconds))
        self._at = self._clock()
        self._answers += 1

    def start_from(self, history: LinkHistory) -> None:
        """Start from an earlier measurement, which counts as two answers."""
        empty = _sums(1.0, 0.0, history.round_trip)
        full = _sums(1.0, LARGE_ANSWER, history.round_trip + LARGE_ANSWER / history.bandwidth)
        self._sums = _plus(self._sums, _plus(empty, full))
        self._answers += history.answers

    @property
    def answers(self) -> int:
        """Number of answers measured, including earlier processes."""
        return self._answers

    def _age(self) -> float:
        return float(0.5 ** (max(self._clock() - self._at, 0.0) / HALF_LIFE))

    def expect(self, size: float) -> Estimate:
        """Return the estimated time of an answer of ``size`` bytes."""
        sums = _plus(_scaled(self._sums, self._age()), self._prior)
        each, base, variance = _line(sums)
        mean, deviation = base + each * size, math.sqrt(variance * (1.0 + 1.0 / sums[0]))
        return Estimate(mean, max(mean - deviation, 0.0), mean + deviation, sums[0] - self._prior[0])

    def history(self, link: str, now: float) -> LinkHistory:
        """Return the row to store; ``now`` is in seconds since the epoch."""
        each, base, _ = _line(_plus(self._sums, self._prior))
        return LinkHistory(link, base, 1.0 / max(each, 1e-12), self._answers, now)


_Sums = tuple[float, ...]


def _sums(weight: float, size: float, seconds: float) -> _Sums:
    return weight, weight * size, weight * seconds, weight * size**2, weight * size * seconds, weight * seconds**2


def _plus(one: _Sums, other: _Sums) -> _Sums:
    return tuple(a + b for a, b in zip(one, other, strict=True))


def _scaled(sums: _Sums, factor: float) -> _Sums:
    return tuple(each * factor for each in sums)


def _line(sums: _Sums) -> tuple[float, float, float]:
    """Return seconds per byte, seconds of an empty answer, and the residual variance of that line."""
    weight, sizes, seconds, sizes2, both, seconds2 = sums
    size, mean = sizes / weight, seconds / weight
    across, along = sizes2 / weight - size**2, both / weight - size * mean
    each = min(max(along / across, 0.0), mean / size) if across > 0.0 and size > 0.0 else 0.0
    variance = seconds2 / weight - mean**2 - 2.0 * each * along + each**2 * across
    return each, mean - each * size, max(variance, 0.0)


# -- both sides of criterion (a), as a container measures them ---------------------------------------------------------

BYTES_PER_CELL = 64.0
"""Size of an answer per cell between start and goal [bytes]: a pose has 56 bytes, and no path is straight."""

JSON_SECONDS_PER_CELL = 1.4e-6
"""Time to send a plan to the client as JSON, per cell between start and goal [s]. A pose has about 110 bytes.

This time is not measured here. Computed plans need it too, so reuse saves less than the time of planning."""

CHECK_SECONDS = 2e-4
"""Assumed time to check any plan, before the first measurement [s]."""

CHECK_BYTES_PER_SECOND = 1e9
"""Assumed rate at which poses are checked, before the first measurement [bytes/s]."""

FASTEST_RETRIEVAL = Estimate(3e-4, 3e-4, 3e-4, 0.0)
"""Lower limit of the time to get a stored plan [s]: a frame to the machine and back, a thread there, and a store."""


@dataclass(slots=True)
class Times:
    """Measured times, for the estimates of criterion (a)."""

    computation: ComputationTimes = field(default_factory=ComputationTimes)
    link: LinkTimes = field(default_factory=LinkTimes)
    checking: LinkTimes = field(default_factory=lambda: LinkTimes(monotonic, CHECK_SECONDS, CHECK_BYTES_PER_SECOND))

    def transmission(self, cells: float) -> Estimate:
        """Return the estimated time to find, check and send a stored plan of this complexity [cells]."""
        size = cells * BYTES_PER_CELL
        link, checking = self.link.expect(size), self.checking.expect(size)
        serializing = cells * JSON_SECONDS_PER_CELL
        lower, upper = link.lower + checking.lower + serializing, link.upper + checking.upper + serializing
        return Estimate(link.mean + checking.mean + serializing, lower, upper, link.samples)
