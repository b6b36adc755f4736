"""Clauses of the specification of rosbridge v2 on topics; see ``test_rosbridge_specification.py``."""

from typing import Any

import pytest

from engine.protocols import robot_link
from engine.protocols.refusals import Refusal
from tests.support.endpoints.still_place import StillClient, StillPlace, delivered, error_of, says

# -- 3.2.1 Advertise, 3.2.2 Unadvertise --------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["std_msgs/String", "std_msgs/msg/String", "toy_msgs/Unknown"])
async def test_3_2_1_a_topic_that_does_not_exist_is_established(
    client: StillClient, other: StillClient, kind: str
) -> None:
    """Types are not resolved: a topic among clients may have any, which rosbridge_suite cannot offer."""
    client.say(op="advertise", topic="/chatter", type=kind, id="a", queue_size=100, latch=False)
    other.say(op="subscribe", topic="/chatter")
    client.say(op="publish", topic="/chatter", msg={"data": "x"})
    assert other.received() == [{"op": "publish", "topic": "/chatter", "msg": {"data": "x"}}]


async def test_3_2_1_another_type_is_an_error_and_the_message_is_dropped(
    client: StillClient, other: StillClient
) -> None:
    client.say(op="advertise", topic="/chatter", type="std_msgs/String")
    assert error_of(says(other, op="advertise", topic="/chatter", type="std_msgs/Bool", id=1), "conflict")["id"] == 1
    client.say(op="unadvertise", topic="/chatter")
    error_of(says(other, op="publish", topic="/chatter", msg={}), "not-found")


@pytest.mark.parametrize("kind", ["std_msgs/String", "std_msgs/msg/String"])
async def test_3_2_1_the_same_type_in_either_spelling_registers_another_publisher(
    client: StillClient, other: StillClient, kind: str
) -> None:
    client.say(op="advertise", topic="/chatter", type="std_msgs/String")
    assert says(other, op="advertise", topic="/chatter", type=kind) == []
    client.say(op="unadvertise", topic="/chatter")
    assert says(other, op="publish", topic="/chatter", msg={}) == []


@pytest.mark.parametrize("fields", [{}, {"type": None}, {"type": 7}])
async def test_3_2_1_a_type_is_required(client: StillClient, fields: dict[str, Any]) -> None:
    error_of(says(client, op="advertise", topic="/chatter", **fields))


async def test_3_2_1_what_is_no_type_is_an_error(client: StillClient) -> None:
    error_of(says(client, op="advertise", topic="/chatter", type="String"), "unknown-type")


async def test_3_2_2_a_topic_remains_while_another_client_advertises_it(
    client: StillClient, other: StillClient
) -> None:
    for each in (client, other):
        each.say(op="advertise", topic="/chatter", type="std_msgs/String")
    assert says(client, op="unadvertise", topic="/chatter") == []
    assert says(client, op="publish", topic="/chatter", msg={}) == []


async def test_3_2_2_a_topic_that_is_not_advertised_is_reported(client: StillClient, other: StillClient) -> None:
    """As an error, where the specification has a warning and rosbridge_suite only logs."""
    error_of(says(client, op="unadvertise", topic="/nowhere"), "not-found")
    other.say(op="advertise", topic="/chatter", type="std_msgs/String")
    error_of(says(client, op="unadvertise", topic="/chatter", id="u"), "not-found")


# -- 3.2.3 Publish -----------------------------------------------------------------------------------------------------


async def test_3_2_3_a_topic_that_does_not_exist_is_an_error(client: StillClient, place: StillPlace) -> None:
    frame = error_of(says(client, op="publish", topic="/nowhere", msg={}, id="p"), "not-found")
    assert frame["id"] == "p" and "known: " in frame["msg"]
    assert delivered(place) == []


@pytest.mark.parametrize("fields", [{}, {"msg": {}}])
async def test_3_2_3_a_message_that_is_left_out_is_empty(
    client: StillClient, place: StillPlace, fields: dict[str, Any]
) -> None:
    assert says(client, op="publish", topic="/goal", **fields) == []
    assert delivered(place) == [("goal", {})]


@pytest.mark.parametrize("fields", [{"latch": None}, {"latch": True}, {"latch": False}, {"queue_size": 1}])
async def test_3_2_3_optional_fields_may_be_null(
    client: StillClient, place: StillPlace, fields: dict[str, Any]
) -> None:
    assert says(client, op="publish", topic="/goal", msg={}, **fields) == []
    assert delivered(place) == [("goal", {})]


async def test_3_2_3_a_message_that_does_not_conform_is_an_error_of_its_sender(
    client: StillClient, other: StillClient, place: StillPlace
) -> None:
    other.say(op="subscribe", topic="/goal")
    client.say(op="publish", topic="/goal", msg={"data": 1}, id="p")
    [message] = place.far.take(robot_link.Deliver)
    refusal = Refusal("malformed-message", "not a String")
    place.say(robot_link.MessageRefused(message.client, "goal", refusal, message.sequence))
    error_of(client.received())
    assert other.received() == []


# -- 3.2.4 Subscribe, 3.2.5 Unsubscribe --------------------------------------------------------------------------------


async def test_3_2_4_a_subscription_needs_no_type(client: StillClient, place: StillPlace) -> None:
    client.say(op="subscribe", topic="map")
    place.publish_json("map", {"n": 1})
    assert client.received() == [{"op": "publish", "topic": "map", "msg": {"n": 1}}]


async def test_3_2_4_another_type_is_an_error(client: StillClient, place: StillPlace) -> None:
    assert error_of(says(client, op="subscribe", topic="/map", type="std_msgs/Bool", id=3), "conflict")["id"] == 3
    place.publish_json("map", {})
    assert client.received() == []


async def test_3_2_4_a_topic_that_does_not_exist_yet_is_waited_for(client: StillClient, other: StillClient) -> None:
    """With a warning; rosbridge_suite refuses it unless a type is given."""
    [warning] = says(client, op="subscribe", topic="/chatter", id="s")
    assert (warning["op"], warning["level"], warning["id"]) == ("status", "warning", "s")
    other.say(op="advertise", topic="/chatter", type="std_msgs/String")
    other.say(op="publish", topic="/chatter", msg={})
    assert [frame["op"] for frame in client.received()] == ["publish"]


@pytest.mark.parametrize("rate", [0, None, 0.0])
async def test_3_2_4_without_a_throttle_rate_each_message_is_sent(
    client: StillClient, place: StillPlace, rate: float | None
) -> None:
    client.say(op="subscribe", topic="/goal", throttle_rate=rate, queue_length=None)
    for number in range(3):
        place.publish_json("goal", {"n": number})
    assert [frame["msg"]["n"] for frame in client.received()] == [0, 1, 2]


@pytest.mark.parametrize("fields", [{"throttle_rate": -1}, {"queue_length": -1}, {"throttle_rate": -2147483648}])
async def test_3_2_4_a_negative_rate_or_queue_counts_as_zero_with_a_warning(
    client: StillClient, place: StillPlace, fields: dict[str, int]
) -> None:
    [warning] = says(client, op="subscribe", topic="/goal", id=1, **fields)
    assert (warning["level"], warning["id"]) == ("warning", 1)
    for number in range(2):
        place.publish_json("goal", {"n": number})
    assert [frame["msg"]["n"] for frame in client.received()] == [0, 1]


@pytest.mark.parametrize(
    "fields", [{"throttle_rate": "100"}, {"queue_length": "1"}, {"queue_length": 0.5}, {"topic": 1}]
)
async def test_3_2_4_fields_of_another_type_are_refused_with_the_id(
    client: StillClient, fields: dict[str, Any]
) -> None:
    assert error_of(says(client, **{"op": "subscribe", "topic": "/map", "id": "s1"} | fields))["id"] == "s1"


async def test_3_2_4_the_lowest_rate_of_a_topic_applies(client: StillClient, place: StillPlace) -> None:
    client.say(op="subscribe", topic="/goal", throttle_rate=60_000, id="slow")
    client.say(op="subscribe", topic="/goal", throttle_rate=0, id="fast")
    for number in range(3):
        place.publish_json("goal", {"n": number})
    assert [frame["msg"]["n"] for frame in client.received()] == [0, 1, 2]


async def test_3_2_5_an_id_ends_its_subscription_only(client: StillClient, place: StillPlace) -> None:
    for identity in ("a", "b"):
        client.say(op="subscribe", topic="/map", id=identity)
    client.say(op="unsubscribe", topic="/map", id="a")
    place.publish_json("map", {})
    assert len(client.received()) == 1


async def test_3_2_5_without_an_id_all_subscriptions_end(client: StillClient, place: StillPlace) -> None:
    for identity in ("a", 2):
        client.say(op="subscribe", topic="/map", id=identity)
    client.say(op="unsubscribe", topic="map")
    place.publish_json("map", {})
    assert client.received() == []


async def test_3_2_5_a_topic_without_a_subscription_is_no_error(client: StillClient) -> None:
    assert says(client, op="unsubscribe", topic="/map", id="a") == []
