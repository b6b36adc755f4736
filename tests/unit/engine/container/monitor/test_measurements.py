"""Measurements: medians of recent values, and data rates of topics."""

from engine.container.monitor.measurements import KEPT, History, TopicRates


def test_one_that_was_held_up_does_not_move_the_median() -> None:
    history = History()
    assert history.median is None
    for value in (0.01, 0.012, 9.0, 0.0, -1.0):
        history.note(value)
    assert history.median == 0.012


def test_only_the_last_are_kept() -> None:
    history = History()
    for n in range(1, 3 * KEPT):
        history.note(float(n))
    assert history.values == [float(n) for n in range(2 * KEPT, 3 * KEPT)]


def test_bytes_become_a_rate_once_they_were_counted_for_long_enough() -> None:
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
