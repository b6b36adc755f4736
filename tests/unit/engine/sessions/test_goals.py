"""Action goals of a client."""

import json
from typing import Any

import pytest

from engine.protocols import robot_link
from engine.protocols.refusals import Refusal
from ppaas.wire.actions import UNKNOWN_GOAL_ID
from tests.support.endpoints.still_place import POSE, StillClient, StillPlace, answers

GOAL = {
    "op": "send_action_goal",
    "id": "g",
    "action": "/move_base",
    "action_type": "move_base_msgs/action/MoveBase",
    "args": {"target_pose": POSE},
}


def status(goal: str, number: int) -> dict[str, Any]:
    return {"goal_id": {"id": goal}, "status": number, "text": "why"}


def goal_of(place: StillPlace) -> tuple[str, int]:
    """Return the id of the goal that was sent to Move Base, and its number."""
    [deliver] = place.far.take(robot_link.Deliver)
    assert deliver.topic == "move_base/goal"
    return json.loads(deliver.payload)["goal_id"]["id"], deliver.sequence


async def test_a_goal_reports_feedback_and_result_to_its_client_only(
    place: StillPlace, client: StillClient, other: StillClient
) -> None:
    client.say(**GOAL, feedback=True)
    goal, _ = goal_of(place)
    heard = {frame.topic for frame in place.far.take(robot_link.SubscribeTopic)}
    assert heard == {"move_base/status", "move_base/result", "move_base/feedback"}
    place.publish_json("move_base/feedback", {"status": status(goal, 1), "feedback": {"base_position": POSE}})
    client.say(op="cancel_action_goal", action="move_base", id="g")
    assert [json.loads(frame.payload) for frame in place.far.take(robot_link.Deliver)] == [{"id": goal}]
    place.publish_json("move_base/result", {"status": status(goal, 2), "result": {}})
    feedback, result = client.received()
    assert (feedback["op"], feedback["id"]) == ("action_feedback", "g")
    assert (result["op"], result["id"], result["status"]) == ("action_result", "g", 5)
    assert {frame.topic for frame in place.far.take(robot_link.UnsubscribeTopic)} == heard
    place.publish_json("move_base/result", {"status": status(goal, 2), "result": {}})
    assert client.received() == other.received() == []


async def test_a_goal_keeps_the_subscriptions_of_its_client(place: StillPlace, client: StillClient) -> None:
    client.say(op="subscribe", topic="/move_base/result")
    client.say(**GOAL)
    goal, _ = goal_of(place)
    client.say(op="subscribe", topic="/move_base/status")
    client.say(op="unsubscribe", topic="/move_base/status")
    assert place.far.take(robot_link.UnsubscribeTopic) == []
    place.publish_json("move_base/result", {"status": status(goal, 3), "result": {}})
    assert [frame["op"] for frame in client.received()] == ["publish", "action_result"]
    assert {frame.topic for frame in place.far.take(robot_link.UnsubscribeTopic)} == {"move_base/status"}


async def test_a_goal_refused_by_the_clone_ends_with_the_reason(place: StillPlace, client: StillClient) -> None:
    client.say(**GOAL)
    _, sequence = goal_of(place)
    place.say(robot_link.MessageRefused(1, "move_base/goal", Refusal("transform", "no frame"), sequence))
    result, status_frame = client.received()
    assert (result["status"], result["result"], result["values"]) == (0, False, "no frame")
    assert status_frame["msg"] == "transform: no frame"


@pytest.mark.parametrize("fields", [{"action": "fly"}, {"action": "?"}, {"action_type": "a/b/c"}, {"args": 1}])
async def test_an_invalid_goal_fails_at_once(fields: dict[str, Any], place: StillPlace, client: StillClient) -> None:
    client.say(**GOAL | fields)
    [result] = client.received()
    assert (result["op"], result["id"], result["status"], result["result"]) == ("action_result", "g", 0, False)
    assert place.far.written == []


NO_STAMP = {"stamp": {"secs": 0, "nsecs": 0}}


@pytest.mark.parametrize(
    ("action", "arguments", "message"),
    [
        ("move_base", {}, NO_STAMP),
        ("navigate_to_pose", {}, NO_STAMP),
        (
            "navigate_to_pose",
            {"goal_info": {"goal_id": {"uuid": [0] * 16}, "stamp": {"sec": 0, "nanosec": 0}}},
            NO_STAMP,
        ),
        ("move_base", [], NO_STAMP),
        ("move_base", {"goal_info": {"stamp": {"sec": 7, "nanosec": 8}}}, {"stamp": {"secs": 7, "nsecs": 8}}),
    ],
)
async def test_the_ros_2_cancel_service_cancels_goals_under_each_name_of_an_action(
    action: str, arguments: Any, message: Any, place: StillPlace, client: StillClient
) -> None:
    client.say(op="call_service", service=f"/{action}/_action/cancel_goal", id="c", args=arguments)
    [done] = await answers(client)
    assert (done["result"], done["values"]) == (True, {"return_code": 0, "goals_canceling": []})
    [cancel] = place.far.take(robot_link.Deliver)
    assert (cancel.topic, json.loads(cancel.payload)) == ("move_base/cancel", message)


@pytest.mark.parametrize("action", ["fly", "move_base_simple"])
async def test_goals_of_an_unknown_action_are_not_cancelled(
    action: str, place: StillPlace, client: StillClient
) -> None:
    client.say(op="call_service", service=f"/{action}/_action/cancel_goal", id="d")
    [unknown] = await answers(client)
    assert unknown["result"] is False
    assert "known: move_base, navigate_to_pose" in unknown["values"]
    assert place.far.take(robot_link.Deliver) == []


async def test_a_single_goal_that_is_named_by_its_uuid_is_unknown(place: StillPlace, client: StillClient) -> None:
    goal = {"goal_info": {"goal_id": {"uuid": [1, *[0] * 15]}}}
    client.say(op="call_service", service="/move_base/_action/cancel_goal", id="u", args=goal)
    [unknown] = await answers(client)
    assert unknown["values"]["return_code"] == UNKNOWN_GOAL_ID
    assert place.far.take(robot_link.Deliver) == []


async def test_a_malformed_action_result_is_reported_to_the_goal_client(
    place: StillPlace, client: StillClient, other: StillClient
) -> None:
    for part in ("goal", "cancel", "status", "feedback", "result"):
        other.say(op="advertise", topic=f"fetch/{part}", type=f"toy_msgs/FetchAction{part.title()}")
    client.say(**GOAL | {"action": "fetch", "action_type": "toy_msgs/FetchAction"})
    other.say(op="publish", topic="fetch/result", msg={"status": "done"})
    assert client.received()[0]["msg"].startswith("malformed-message")
    assert other.received() == []
