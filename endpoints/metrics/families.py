"""Metric families with bounded labels."""

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeVar

from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, HistogramMetricFamily

from engine.control.counts import BucketCounts

S = TypeVar("S", bound=str)

MOST_SERIES = 1000
"""Largest number of series of one metric; the values of all others are added up under `OTHER`."""

LONGEST_LABEL = 64
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


def counters(name: str, text: str, of: str, values: Mapping[S, float]) -> CounterMetricFamily:
    """Return a counter with one label, whose values are a fixed set."""
    family = CounterMetricFamily(name, text, labels=[of])
    for key, value in values.items():
        family.add_metric([key], value)
    return family


def histogram(name: str, text: str, counted: BucketCounts) -> HistogramMetricFamily:
    """Return a histogram of what was counted."""
    buckets, reached = [], 0
    for limit, count in zip((*counted.limits, None), counted.counts, strict=True):
        reached += count
        buckets.append(("+Inf" if limit is None else f"{limit}", reached))
    return HistogramMetricFamily(name, text, buckets=buckets, sum_value=counted.total)
