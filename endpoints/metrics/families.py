"""Metric families with bounded labels."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import accumulate, islice
from typing import TypeVar

from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, HistogramMetricFamily

S = TypeVar("S", bound=str)

Counted = tuple[Sequence[float], Sequence[int], float]
"""Upper limits of classes, the number of values in each and beyond all, and the sum of all values."""

MOST_SERIES = 1000
"""Largest number of series of one metric; the values of all others are added up under `OTHER`."""

MOST_HISTOGRAMS = 50
"""Largest number of histograms of one metric; of further ones, there are none."""

LONGEST_LABEL = 128
"""Largest length of the value of a label [characters]."""

OTHER = "(other)"
"""Value of the labels of series beyond `MOST_SERIES`."""


def label(text: str) -> str:
    """Return the value of a label for a name: bounded, and without characters that a terminal would obey."""
    return "".join(letter if letter.isprintable() else "?" for letter in text[:LONGEST_LABEL])


def gauge(name: str, text: str, value: float) -> GaugeMetricFamily:
    """Return a gauge without labels."""
    return GaugeMetricFamily(name, text, value=value)


def gauges(
    name: str, text: str, labels: Sequence[str], values: Iterable[tuple[Sequence[str], float]]
) -> GaugeMetricFamily:
    """Return a gauge with labels; values of the same labels are added up."""
    series: dict[tuple[str, ...], float] = {}
    for names, value in values:
        key = tuple(label(each) for each in names)
        if key not in series and len(series) >= MOST_SERIES:
            key = (OTHER,) * len(labels)
        series[key] = series.get(key, 0.0) + value
    family = GaugeMetricFamily(name, text, labels=labels)
    for key, value in series.items():
        family.add_metric(key, value)
    return family


def by_state(name: str, text: str, states: Sequence[S], counts: Mapping[S, float]) -> GaugeMetricFamily:
    """Return a gauge with the label ``state``, which has a value for each of the states."""
    return gauges(name, text, ["state"], (([state], counts.get(state, 0.0)) for state in states))


def counters(
    name: str, text: str, labels: Sequence[str], values: Iterable[tuple[Sequence[str], float]]
) -> CounterMetricFamily:
    """Return a counter with labels, whose values are a fixed set except for names of machines and endpoints."""
    family = CounterMetricFamily(name, text, labels=labels)
    for names, value in islice(values, MOST_SERIES):
        family.add_metric([label(each) for each in names], value)
    return family


def histogram(
    name: str, text: str, labels: Sequence[str], values: Iterable[tuple[Sequence[str], Counted]]
) -> HistogramMetricFamily:
    """Return a histogram of numbers that were counted by class, for each combination of labels."""
    family = HistogramMetricFamily(name, text, labels=labels)
    for names, (limits, counts, total) in islice(values, MOST_HISTOGRAMS):
        reached = accumulate(counts)
        buckets = [(limit, float(next(reached))) for limit in (*map(str, limits), "+Inf")]
        family.add_metric([label(each) for each in names], buckets, total)
    return family
