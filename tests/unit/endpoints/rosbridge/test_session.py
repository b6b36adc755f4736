"""What a client may say at a robot's place, and what it and the others are told, without sockets."""

import asyncio
import json
from collections.abc import AsyncIterator
from functools import partial
from typing import Any

import pytest

from endpoints.rosbridge.calls import MAX_CALLS
from endpoints.rosbridge.outbox import Outbox
from endpoints.rosbridge.session import PATH_SERVICES
from engine.master.quotas import Quota, Quotas
from engine.protocols import robot_link
from engine.service.plan_rate import PlanRate
from ppaas.errors import Unavailable
from ppaas.messages.nav_msgs import GetPlan
from ppaas.messages.ppaas_msgs import ComputePath
from ppaas.nodes.move_base.node import MoveBaseNode
from tests.support.endpoints.still_place import StillClient, StillPlace
from tests.support.waiting import until

POSE = {
    "header": {"frame_id": "map"},
    "pose": {"position": {"x": 1.0, "y": 2.0}, "orientation": {"z": 0.0, "w": 1.0}},
}
GOAL = {
    "op": "send_action_goal",
    "id": "g",
    "action": "/move_base",
    "action_type": "move_base_msgs/action/MoveBase",
    "args": {"target_pose": POSE},
}


@pytest.fixture
async def place() -> StillPlace:
    return StillPlace()


@pytest.fixture
async def client(place: StillPlace) -> AsyncIterator[StillClient]:
    made = StillClient(place)
    yield made
    made.session.end()


@pytest.fixture
async def other(place: StillPlace) -> AsyncIterator[StillClient]:
    made = StillClient(place, "operator")
    yield made
    made.session.end()


async def answers(client: StillClient, count: int = 1) -> list[dict[str, Any]]:
    """Wait until so many frames are there."""
    await until(lambda: len(client.session.outbox) >= count)
    return client.told()


# -- paths that clients ask for ----------------------------------------------------------------------------------------


def test_the_services_that_count_are_those_of_move_base_that_plan() -> None:
    planning = [service for service in MoveBaseNode.services if service.type in (GetPlan, ComputePath)]
    assert {service.name for service in planning} == PATH_SERVICES


@pytest.mark.parametrize("spelling", ["move_base/make_plan", "/move_base/make_plan"])
async def test_a_path_too_many_is_refused_as_the_answer_and_reaches_nobody(place: StillPlace, spelling: str) -> None:
    rate = PlanRate(Quotas(Quota(plans_per_minute=1)))
    client = StillClient(place, count_plan=partial(rate.take, "ann"))
    for number in ("first", "second"):
        client.say(op="call_service", service=spelling, id=number, args={})
    [call] = place.far.take(robot_link.Call)
    assert call.service == "move_base/make_plan"
    [refused] = await answers(client)
    assert (refused["id"], refused["result"]) == ("second", False)
    assert refused["values"].startswith("user 'ann' may ask for 1 paths a minute")
    client.session.end()


# -- topics ------------------------------------------------------------------------------------------------------------


async def test_a_topic_of_a_client_reaches_whoever_hears_it_under_its_own_spelling(
    place: StillPlace, client: StillClient, other: StillClient
) -> None:
    other.say(op="subscribe", topic="/chatter", type="std_msgs/msg/Header", id="s1")
    [warning] = other.told()
    assert (warning["op"], warning["level"], warning["id"]) == ("status", "warning", "s1")
    client.say(op="publish", topic="/chatter", msg={}, id="p1")
    [refused] = client.told()
    assert refused["msg"].startswith("not-found") and refused["id"] == "p1"
    client.say(op="advertise", topic="chatter", type="std_msgs/Header", latch=True)
    client.say(op="publish", topic="chatter", msg={"stamp": {"secs": 1, "nsecs": 2}})
    assert client.told() == []
    assert other.told() == [{"op": "publish", "topic": "/chatter", "msg": {"stamp": {"sec": 1, "nanosec": 2}}}]
    client.say(op="subscribe", topic="chatter")
    assert client.told() == [{"op": "publish", "topic": "chatter", "msg": {"stamp": {"secs": 1, "nsecs": 2}}}]
    assert place.far.take(robot_link.Deliver) == []


async def test_a_topic_goes_with_the_client_that_advertised_it(client: StillClient, other: StillClient) -> None:
    other.say(op="advertise", topic="chatter", type="std_msgs/String", id="a")
    client.say(op="advertise", topic="/chatter", type="std_msgs/msg/String")
    other.say(op="unadvertise", topic="chatter", id="a")
    client.say(op="publish", topic="chatter", msg={"data": "x"})
    assert client.told() == other.told() == []
    client.session.end()
    other.say(op="publish", topic="chatter", msg={"data": "x"})
    assert [told["op"] for told in other.told()] == ["status"]


@pytest.mark.parametrize(
    ("frame", "slug"),
    [
        ({"op": "advertise", "topic": "goal", "type": "std_msgs/Bool"}, "conflict"),
        ({"op": "advertise", "topic": "x", "type": "Bool"}, "unknown-type"),
        ({"op": "advertise", "topic": "x y", "type": "std_msgs/Bool"}, "malformed-message"),
        ({"op": "advertise", "topic": "scan", "type": "sensor_msgs/LaserScan"}, "not-permitted"),
        ({"op": "unadvertise", "topic": "x"}, "not-found"),
        ({"op": "subscribe", "topic": "map", "type": "std_msgs/Bool"}, "conflict"),
        ({"op": "subscribe", "topic": "map", "type": "?"}, "unknown-type"),
        ({"op": "advertise_service", "service": "make_plan", "type": "nav_msgs/GetPlan"}, "conflict"),
        ({"op": "advertise_service", "service": "x", "type": ""}, "unknown-type"),
        ({"op": "unadvertise_service", "service": "x"}, "not-found"),
        ({"op": "service_response", "service": "x", "result": True, "id": "7"}, "not-found"),
        ({"op": "service_response", "service": "x", "result": True, "id": "²"}, "not-found"),
        ({"op": "service_response", "service": "x", "result": True}, "not-found"),
        ({"op": "cancel_action_goal", "action": "move_base", "id": "x"}, "not-found"),
    ],
)
async def test_what_cannot_be_is_told_by_its_kind(frame: dict[str, Any], slug: str, other: StillClient) -> None:
    other.say(**frame)
    [told] = other.told()
    assert (told["op"], told["level"]) == ("status", "error")
    assert told["msg"].startswith(f"{slug}: "), told


async def test_a_subscription_that_was_refused_is_not_heard(place: StillPlace, client: StillClient) -> None:
    client.say(op="subscribe", topic="map", type="std_msgs/Bool")
    client.told()
    place.publish_json("map", {})
    assert client.told() == []


async def test_the_last_of_many_messages_arrives_though_it_came_too_soon(
    place: StillPlace, client: StillClient
) -> None:
    client.say(op="subscribe", topic="goal", throttle_rate=30)
    client.say(op="subscribe", topic="map", throttle_rate=60_000)
    for number in range(5):
        place.publish_json("map", {"n": number})
        place.publish_json("goal", {"n": number})
    first = client.told()
    assert [told["msg"]["n"] for told in first] == [0, 0]
    [last] = await answers(client)
    assert (last["topic"], last["msg"]["n"]) == ("goal", 4)


# -- services ----------------------------------------------------------------------------------------------------------


async def test_a_client_serves_another(client: StillClient, other: StillClient) -> None:
    client.say(op="advertise_service", service="/lights", type="std_srvs/SetBool")
    other.say(op="call_service", service="lights", id="c1", args={"data": True})
    [asked] = await answers(client)
    assert (asked["op"], asked["service"], asked["args"]) == ("call_service", "/lights", {"data": True})
    client.say(op="service_response", service="/lights", id=asked["id"], result=True, values={"success": True})
    assert await answers(other) == [
        {"op": "service_response", "service": "lights", "id": "c1", "result": True, "values": {"success": True}}
    ]
    client.say(op="service_response", service="/lights", id=asked["id"], result=True, values={})
    assert client.told()[0]["msg"].startswith("not-found")
    assert other.told() == []


@pytest.mark.parametrize(
    ("response", "reason"),
    [
        ({"result": False, "values": "no bulb"}, "no bulb"),
        ({"result": False, "values": "unavailable: no bulb"}, "no bulb"),
        ({"result": False}, "the client that offers 'lights' said no"),
        ({"result": None, "values": {}}, "the client that offers 'lights' said no"),
    ],
)
async def test_a_client_may_serve_itself_and_refuse(response: dict[str, Any], reason: str, client: StillClient) -> None:
    client.say(op="advertise_service", service="lights", type="std_srvs/Trigger")
    client.say(op="call_service", service="/lights", id="c1")
    [asked] = await answers(client)
    client.say(op="service_response", service="lights", id=asked["id"], **response)
    [answer] = await answers(client)
    assert (answer["result"], answer["values"], answer["id"]) == (False, reason, "c1")


async def test_a_provider_that_goes_fails_the_calls_put_to_it(client: StillClient, other: StillClient) -> None:
    client.say(op="advertise_service", service="lights", type="std_srvs/Trigger")
    other.say(op="call_service", service="lights", id="c1", timeout=0.02)
    other.say(op="call_service", service="lights", id="c2", timeout=-1)
    [late] = await answers(other)
    assert (late["id"], late["result"]) == ("c1", False) and "0.02 s" in late["values"]
    client.session.end()
    [gone] = await answers(other)
    assert (gone["id"], gone["result"]) == ("c2", False) and "has gone" in gone["values"]


async def test_a_provider_that_does_not_read_is_not_closed_by_those_who_call_it(
    client: StillClient, other: StillClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(frame: str) -> None:
        raise Unavailable("full")

    client.say(op="advertise_service", service="lights", type="std_srvs/Trigger")
    monkeypatch.setattr(client.session.outbox, "put_answer", full)
    other.say(op="call_service", service="lights", id="c1")
    [answer] = await answers(other)
    assert answer["values"] == "full"
    assert not client.session.over.done()


async def test_arguments_of_the_clones_services_may_be_a_list(place: StillPlace, client: StillClient) -> None:
    client.say(op="call_service", service="make_plan", args=[POSE, POSE])
    client.say(op="call_service", service="make_plan", id="long", args=[1, 2, 3, 4])
    client.say(op="call_service", service="nothing", id="unknown", args=[1])
    refused = {told["id"]: told["values"] for told in await answers(client, 2)}
    assert "4 arguments" in refused["long"] and "as an object" in refused["unknown"]
    [call] = place.far.take(robot_link.Call)
    assert json.loads(call.payload) == {"start": POSE, "goal": POSE}


async def test_calls_under_way_are_bounded_and_given_up_at_the_end(client: StillClient) -> None:
    client.say(op="advertise_service", service="lights", type="std_srvs/Trigger")
    for number in range(MAX_CALLS + 1):
        client.say(op="call_service", service="lights", id=str(number))
    [refused] = [told for told in client.told() if told["op"] == "service_response"]
    assert refused["id"] == str(MAX_CALLS)
    client.session.end()
    assert [told for told in client.told() if told["op"] == "service_response"] == []


# -- actions -----------------------------------------------------------------------------------------------------------


def status(goal: str, number: int) -> dict[str, Any]:
    return {"goal_id": {"id": goal}, "status": number, "text": "why"}


def goal_of(place: StillPlace) -> tuple[str, int]:
    """Return the id of the goal that was sent to Move Base, and its number."""
    [deliver] = place.far.take(robot_link.Deliver)
    assert deliver.topic == "move_base/goal"
    return json.loads(deliver.payload)["goal_id"]["id"], deliver.sequence


async def test_a_goal_is_told_of_until_it_ends_and_only_to_its_client(
    place: StillPlace, client: StillClient, other: StillClient
) -> None:
    client.say(**GOAL, feedback=True)
    goal, _ = goal_of(place)
    heard = {frame.topic for frame in place.far.take(robot_link.Subscribe)}
    assert heard == {"move_base/status", "move_base/result", "move_base/feedback"}
    place.publish_json("move_base/feedback", {"status": status(goal, 1), "feedback": {"base_position": POSE}})
    client.say(op="cancel_action_goal", action="move_base", id="g")
    assert [json.loads(frame.payload) for frame in place.far.take(robot_link.Deliver)] == [{"id": goal}]
    place.publish_json("move_base/result", {"status": status(goal, 2), "result": {}})
    feedback, result = client.told()
    assert (feedback["op"], feedback["id"]) == ("action_feedback", "g")
    assert (result["op"], result["id"], result["status"]) == ("action_result", "g", 5)
    assert {frame.topic for frame in place.far.take(robot_link.Unsubscribe)} == heard
    place.publish_json("move_base/result", {"status": status(goal, 2), "result": {}})
    assert client.told() == other.told() == []


async def test_a_topic_that_the_client_hears_itself_is_heard_on_after_the_goal(
    place: StillPlace, client: StillClient
) -> None:
    client.say(op="subscribe", topic="/move_base/result")
    client.say(**GOAL)
    goal, _ = goal_of(place)
    client.say(op="subscribe", topic="/move_base/status")
    client.say(op="unsubscribe", topic="/move_base/status")
    assert place.far.take(robot_link.Unsubscribe) == []
    place.publish_json("move_base/result", {"status": status(goal, 3), "result": {}})
    assert [told["op"] for told in client.told()] == ["publish", "action_result"]
    assert {frame.topic for frame in place.far.take(robot_link.Unsubscribe)} == {"move_base/status"}


async def test_a_goal_that_the_clone_refuses_ends_with_the_reason(place: StillPlace, client: StillClient) -> None:
    client.say(**GOAL)
    _, sequence = goal_of(place)
    place.say(robot_link.Refused(1, "move_base/goal", robot_link.Refusal("transform", "no frame"), sequence))
    result, told = client.told()
    assert (result["status"], result["result"], result["values"]) == (0, False, "no frame")
    assert told["msg"] == "transform: no frame"


@pytest.mark.parametrize("fields", [{"action": "fly"}, {"action": "?"}, {"action_type": "a/b/c"}, {"args": 1}])
async def test_what_is_no_goal_ends_at_once(fields: dict[str, Any], place: StillPlace, client: StillClient) -> None:
    client.say(**GOAL | fields)
    [result] = client.told()
    assert (result["op"], result["id"], result["status"], result["result"]) == ("action_result", "g", 0, False)
    assert place.far.written == []


async def test_all_goals_are_cancelled_by_the_service_of_ros_2(place: StillPlace, client: StillClient) -> None:
    client.say(op="call_service", service="/move_base/_action/cancel_goal", id="c", args={})
    client.say(op="call_service", service="/fly/_action/cancel_goal", id="d", args={})
    done, unknown = await answers(client, 2)
    assert (done["result"], unknown["result"]) == (True, False)
    [cancel] = place.far.take(robot_link.Deliver)
    assert (cancel.topic, cancel.payload) == ("move_base/cancel", b"{}")


async def test_nonsense_from_a_client_that_plays_an_action_harms_only_its_own_message(
    place: StillPlace, client: StillClient, other: StillClient
) -> None:
    for part in ("goal", "cancel", "status", "feedback", "result"):
        other.say(op="advertise", topic=f"fetch/{part}", type=f"toy_msgs/FetchAction{part.title()}")
    client.say(**GOAL | {"action": "fetch", "action_type": "toy_msgs/FetchAction"})
    other.say(op="publish", topic="fetch/result", msg={"status": "done"})
    assert client.told()[0]["msg"].startswith("malformed-message")
    assert other.told() == []


async def test_an_outbox_that_is_full_of_answers_closes_its_client(
    client: StillClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(self: Outbox, frame: str) -> None:
        raise Unavailable("full")

    monkeypatch.setattr(Outbox, "put_answer", full)
    client.say(op="call_service", service="/move_base/_action/cancel_goal")
    async with asyncio.timeout(5):
        assert str(await client.session.over) == "full"
