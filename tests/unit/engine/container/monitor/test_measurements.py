"""Measurements: medians of recent values, and data rates of topics."""

from engine.container.monitor.measurements import KEPT, History, TopicRates


def test_delayed_or_invalid_values_do_not_move_the_median() -> None:
    history = History()
    assert history.median is None
    for value in (0.01, 0.012, 9.0, 0.0, -1.0):
        history.note(value)
    assert history.median == 0.012


def test_history_keeps_the_last_values_only() -> None:
    history = History()
    for n in range(1, 3 * KEPT):
        history.note(float(n))
    assert history.values == [float(n) for n in range(2 * KEPT, 3 * KEPT)]


def test_rate_is_measured_after_a_full_window() -> None:
    rates = TopicRates(window=2.0)
    rates.look(10.0)
    rates.note("scan", 300)
    rates.look(11.0)
    assert rates.of({"scan": 80.0, "image": 9.0}) == {"scan": 80.0, "image": 9.0}
    rates.note("scan", 500)
    rates.look(14.0)
    assert rates.of({"scan": 80.0, "image": 9.0}) == {"scan": 200.0}, "it sends no images"
    rates.look(17.0)
    assert rates.of({"scan": 80.0}) == {"scan": 200.0}, "a laser that rests is not forgotten"
