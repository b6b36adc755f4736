"""Health of the connections of a place."""

from collections import deque
from dataclasses import dataclass, field

from engine.sessions.place.client_health import CONNECT_AGE, MOST_TOPICS, REFUSAL_AGE, ClientHealth
from ppaas.clock import ManualClock
from ppaas.errors import NotFound


@dataclass
class FakeQueue:
    """Messages that wait for a client."""

    connected: bool = True
    connected_at: deque[float] = field(default_factory=lambda: deque([0.0]))
    dropped: int = 0
    dropped_at: float = float("-inf")

    def __len__(self) -> int:
        return 3


def test_sockets_subscriptions_and_topics_of_robots_and_operators_are_told_apart() -> None:
    health = ClientHealth(ManualClock())
    health.joined(1, "robot", FakeQueue())
    health.joined(2, "robot", FakeQueue(connected=False))
    health.joined(3, "operator", FakeQueue())
    facts = health.facts({"cmd_vel": {3}, "map": {1, 3}}, {"own": "std_msgs/String"}, 0.02)
    assert (facts.robots, facts.operators, facts.round_trip, facts.waiting) == (1, 1, 0.02, 6)
    assert (facts.subscribed, facts.client_topics) == (("map",), {"own": "std_msgs/String"})


def test_connections_and_drops_count_for_some_time_also_after_a_session_has_ended() -> None:
    clock = ManualClock()
    health = ClientHealth(clock)
    health.joined(1, "robot", FakeQueue(dropped=4, dropped_at=0.0))
    assert (health.facts({}, {}, None).dropped, health.facts({}, {}, None).connects) == (4, 1)
    health.left(1)
    health.joined(2, "robot", FakeQueue(dropped=4, dropped_at=0.0))
    clock.advance(REFUSAL_AGE + 1.0)
    assert (health.facts({}, {}, None).dropped, health.facts({}, {}, None).connects) == (0, 2)
    clock.advance(CONNECT_AGE)
    assert health.facts({}, {}, None).connects == 0


def test_last_refusals_of_the_robot_are_kept_for_a_while_and_bounded() -> None:
    clock = ManualClock()
    health = ClientHealth(clock)
    health.joined(1, "robot", FakeQueue())
    health.joined(2, "operator", FakeQueue())
    for number in range(2 * MOST_TOPICS):
        health.refused(1, f"t{number}", NotFound("topic", "x" * 1000))
    health.refused(2, "scan", NotFound("topic", "scan"))
    refused = health.facts({}, {}, None).refused
    assert len(refused) == MOST_TOPICS
    assert "scan" not in refused
    assert max(map(len, refused.values())) <= 400
    clock.advance(REFUSAL_AGE + 1.0)
    assert health.facts({}, {}, None).refused == {}
