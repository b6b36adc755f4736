"""Metric families: labels and series are bounded, whatever names there are."""

from hypothesis import given
from hypothesis import strategies as st
from prometheus_client import CollectorRegistry, generate_latest
from prometheus_client.core import Metric
from prometheus_client.parser import text_string_to_metric_families

from endpoints.metrics.families import LONGEST_LABEL, MOST_SERIES, OTHER, by_state, gauges, histogram
from engine.control.counts import BucketCounts


def parsed(family: Metric) -> dict[tuple[str, ...], float]:
    """Return the values of a family by their labels, as Prometheus reads them."""

    class Fixed:
        def collect(self) -> list[Metric]:
            return [family]

    registry = CollectorRegistry()
    registry.register(Fixed())  # type: ignore[arg-type]  # it has what a collector needs
    [read] = text_string_to_metric_families(generate_latest(registry).decode())
    found = {(sample.name, *sample.labels.values()): sample.value for sample in read.samples}
    assert len(found) == len(read.samples), "Prometheus refuses a scrape with a series twice"
    return found


@given(st.lists(st.tuples(st.text(max_size=LONGEST_LABEL + 20), st.integers(0, 9)), max_size=20))
def test_any_names_make_a_scrape_that_parses(named: list[tuple[str, int]]) -> None:
    found = parsed(gauges("m", "text", ["name"], (([name], value) for name, value in named)))
    assert sum(found.values()) == sum(value for _, value in named)
    for _, name in found:
        assert len(name) <= LONGEST_LABEL and all(letter.isprintable() for letter in name)


def test_a_name_that_is_made_to_break_out_stays_a_label() -> None:
    bomb = 'a"} 1\nppaas_leader 1\n#\\'
    [(_, name)] = parsed(gauges("m", "text", ["name"], [([bomb], 1.0)]))
    assert name == bomb.replace("\n", "?")


def test_series_beyond_the_limit_are_added_up() -> None:
    many = MOST_SERIES + 50
    found = parsed(gauges("m", "text", ["user", "robot"], ((["ann", f"r{number}"], 1.0) for number in range(many))))
    assert (len(found), found["m", OTHER, OTHER], sum(found.values())) == (MOST_SERIES + 1, 50, many)


def test_a_state_that_nothing_is_in_has_a_value() -> None:
    assert parsed(by_state("m", "text", ("ready", "lost"), {"ready": 2})) == {("m", "ready"): 2, ("m", "lost"): 0}


def test_classes_of_a_histogram_contain_the_ones_below() -> None:
    counted = BucketCounts((0.1, 1.0))
    for value in (0.05, 0.1, 0.5, 7.0):
        counted.add(value)
    assert parsed(histogram("m", "text", [], [([], (counted.limits, counted.counts, counted.total))])) == {
        ("m_bucket", "0.1"): 2,
        ("m_bucket", "1.0"): 3,
        ("m_bucket", "+Inf"): 4,
        ("m_count",): 4,
        ("m_sum",): 7.65,
    }
