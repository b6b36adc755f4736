"""Subscriptions of a client to one topic."""

import msgspec
import pytest

from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Float64, String
from robots.client.subscription import SubscriptionRegistry, TopicSubscription


def test_a_message_reaches_all_subscriptions_also_if_one_fails() -> None:
    def fail(_: Message) -> None:
        raise RuntimeError("the robot's program")

    registry, heard = SubscriptionRegistry(), list[Float64]()
    registry.add(TopicSubscription("/number", String, lambda _: None))
    registry.add(TopicSubscription("/number", Float64, fail))
    registry.add(TopicSubscription("number", Float64, heard.append))
    with pytest.raises(RuntimeError, match="the robot's program"):
        registry.deliver("number", msgspec.Raw(b'{"data": 1.0}'))
    assert heard == [Float64(1.0)]
