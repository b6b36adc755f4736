"""Traffic of a clone, counted all the time, and the table that is made of it."""

import pytest

from ppaas.diagnosis.observations.topic_table import (
    MOST_SENDERS,
    MOST_TEXT,
    MOST_TOPICS,
    REFUSAL_AGE,
    TopicTable,
    Traffic,
)


def test_messages_bytes_senders_and_refusals_are_counted_by_topic() -> None:
    traffic = Traffic()
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
    traffic = Traffic()
    for number in range(2 * MOST_TOPICS):
        traffic.note(f"topic{number}", 1, number, 0.0)
        traffic.note("scan", 1, number, 0.0)
        traffic.refuse(f"other{number}", "unknown", 0.0)
    assert len(traffic.topics) == MOST_TOPICS
    assert len(traffic.topics["scan"].senders) <= MOST_SENDERS


def test_rates_are_those_of_the_last_seconds() -> None:
    traffic = Traffic()
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
    names = [each.name for each in TopicTable(Traffic(), 0.0).facts(1.0, {}, {})]
    assert names == ["scan", "odom", "tf", "tf_static", "cmd_vel"]


def test_refusals_count_until_messages_are_accepted_again() -> None:
    traffic = Traffic()
    table = TopicTable(traffic, 0.0)
    traffic.note("scan", 1, 1, 1.0)
    traffic.refuse("scan", "unknown frame", 1.0)
    assert table.facts(1.5, {}, {})[0].refused == 1
    later = table.facts(1.5 + REFUSAL_AGE, {}, {})[0]
    assert (later.refused, later.refused_count, later.refusal) == (0, 1, "unknown frame")
