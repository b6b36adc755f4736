"""Arrivals and traffic of topics."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.diagnosis.observations.arrivals import MOST, WINDOW, Arrivals, gap_and_burst, lateness, unstamped
from ppaas.diagnosis.observations.topic_table import (
    MOST_SENDERS,
    MOST_TEXT,
    MOST_TOPICS,
    REFUSAL_AGE,
    TopicTable,
    TrafficCounter,
)

MOMENTS = st.floats(-1e12, 1e12, allow_nan=False)


def arrivals(times: list[float], late: list[float | None]) -> Arrivals:
    """Return arrivals at times [s], each stamped some time before, or zero."""
    noted = Arrivals()
    for at, delay in zip(times, late, strict=True):
        noted.note(at, 1e9 + at, 0.0 if delay is None else 1e9 + at - delay, "laser")
    return noted


def test_even_messages_have_neither_gap_nor_burst() -> None:
    noted = arrivals([i * 0.1 for i in range(50)], [0.02] * 50)
    gap, burst = gap_and_burst(noted.recent(4.95), 4.95)
    assert (gap, burst) == (pytest.approx(0.1), 0.0)
    assert lateness(noted.recent(4.95)) == (pytest.approx(0.02, abs=1e-6), 0.0)


def test_time_since_the_last_message_counts_as_a_gap() -> None:
    noted = arrivals([0.0, 0.1, 0.2], [0.0] * 3)
    assert gap_and_burst(noted.recent(3.2), 3.2)[0] == pytest.approx(3.0)


def test_messages_that_come_five_at_once_are_bursts() -> None:
    times = [second + i * 1e-3 for second in range(5) for i in range(5)]
    assert gap_and_burst(arrivals(times, [0.0] * 25).recent(5.0), 5.0)[1] == pytest.approx(20 / 24)


def test_steadily_growing_delay_is_growth_and_a_clock_that_was_set_is_none() -> None:
    times = [i * 0.1 for i in range(60)]
    growing = lateness(arrivals(times, [0.02 * i for i in range(60)]).recent(6.0))[1]
    assert growing == pytest.approx(1.2, abs=0.05)
    jumped = lateness(arrivals(times, [0.0] * 30 + [40.0] * 30).recent(6.0))
    assert jumped == (pytest.approx(40.0, abs=1e-6), pytest.approx(0.0, abs=1e-6))


def test_stamps_of_zero_are_counted_and_not_compared_with_the_clock() -> None:
    noted = arrivals([0.0, 0.1, 0.2, 0.3], [None, None, 0.1, 0.1])
    assert unstamped(noted.recent(0.3)) == 0.5
    assert lateness(noted.recent(0.3))[0] == pytest.approx(0.1, abs=1e-6)
    assert noted.backwards() == 0


def test_stamps_run_backwards_within_a_frame_only() -> None:
    noted = Arrivals()
    for stamp, frame in ((10.0, "front"), (9.0, "rear"), (11.0, "front"), (10.5, "front")):
        noted.note(0.0, 20.0, stamp, frame)
    assert noted.backwards() == 1


def test_messages_before_the_window_are_forgotten() -> None:
    noted = arrivals([0.0, 1.0, WINDOW + 0.5], [0.0, 0.0, 5.0])
    assert len(noted.recent(WINDOW + 0.5)) == 2
    assert noted.recent(99.0) == []


def test_number_of_arrivals_is_bounded() -> None:
    noted = arrivals([i * 1e-3 for i in range(2 * MOST)], [0.0] * 2 * MOST)
    assert len(noted.recent(4.0)) == MOST


@given(st.lists(st.tuples(st.floats(0.0, 5.0), st.none() | MOMENTS), max_size=40))
def test_any_stamps_give_finite_facts(messages: list[tuple[float, float | None]]) -> None:
    noted, now = Arrivals(), 0.0
    for step, stamp in messages:
        now += step
        noted.note(now, 1e9 + now, stamp)
    recent = noted.recent(now)
    gap, burst = gap_and_burst(recent, now)
    late, growth = lateness(recent)
    assert gap is None or gap >= 0.0
    assert 0.0 <= burst <= 1.0
    assert late is None or abs(late) < 1e13
    assert growth >= 0.0
    assert 0.0 <= unstamped(recent) <= 1.0


def test_messages_bytes_senders_and_refusals_are_counted_by_topic() -> None:
    traffic = TrafficCounter()
    for number in range(4):
        traffic.note("scan", 1000, number % 2, number * 0.1)
    traffic.refuse("scan", "x" * 1000, 0.3)
    count = traffic.topics["scan"]
    assert (count.count, count.size, count.senders, count.refused, len(count.refusal)) == (
        4,
        4000,
        {0, 1},
        1,
        MOST_TEXT,
    )


def test_names_and_senders_that_clients_choose_are_bounded() -> None:
    traffic = TrafficCounter()
    for number in range(2 * MOST_TOPICS):
        traffic.note(f"topic{number}", 1, number, 0.0)
        traffic.note("scan", 1, number, 0.0)
        traffic.refuse(f"other{number}", "unknown", 0.0)
    assert len(traffic.topics) == MOST_TOPICS
    assert len(traffic.topics["scan"].senders) <= MOST_SENDERS


def test_rates_are_those_of_the_last_seconds() -> None:
    traffic = TrafficCounter()
    table = TopicTable(traffic, 0.0)
    for tick in range(300):
        now = tick * 0.1
        if tick < 100:
            traffic.note("goal_pose", 500, 1, now)
        if tick % 10 == 0:
            table.look(now)
        if tick == 50:
            facts = {each.name: each for each in table.facts(now, {}, {"goal_pose": "geometry_msgs/PoseStamped"})}
            assert facts["goal_pose"].rate == pytest.approx(10.0, rel=0.05)
            assert facts["goal_pose"].bandwidth == pytest.approx(5000.0, rel=0.05)
            assert facts["goal_pose"].type == "geometry_msgs/PoseStamped"
            assert facts["goal_pose"].senders == 1
    [last] = [each for each in table.facts(29.9, {}, {}) if each.name == "goal_pose"]
    assert (last.rate, last.count, last.size, last.silence) == (0.0, 100, 500.0, pytest.approx(20.0))
    assert last.senders == 0


def test_sensors_are_listed_though_nothing_came() -> None:
    names = [each.name for each in TopicTable(TrafficCounter(), 0.0).facts(1.0, {}, {})]
    assert names == ["scan", "odom", "tf", "tf_static", "cmd_vel"]


def test_refusals_count_until_messages_are_accepted_again() -> None:
    traffic = TrafficCounter()
    table = TopicTable(traffic, 0.0)
    traffic.note("scan", 1, 1, 1.0)
    traffic.refuse("scan", "unknown frame", 1.0)
    assert table.facts(1.5, {}, {})[0].refused == 1
    later = table.facts(1.5 + REFUSAL_AGE, {}, {})[0]
    assert (later.refused, later.refused_count, later.refusal) == (0, 1, "unknown frame")
