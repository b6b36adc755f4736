"""Clauses of the specification of rosbridge v2 on services and actions; see ``test_rosbridge_specification.py``.

Members of the kind "a client that waits for an answer gets one": calls and goals whose service or action does not
exist, whose arguments do not fit, whose server leaves, fails or answers nothing, and that carry no id.
"""

import json
from typing import Any

import pytest

from engine.protocols import robot_link
from engine.protocols.refusals import Refusal
from tests.support.endpoints.still_place import POSE, StillClient, StillPlace, answers, error_of, says

LIGHTS = {"service": "/lights", "type": "std_srvs/SetBool"}
GOAL = {
    "op": "send_action_goal",
    "action": "/move_base",
    "action_type": "move_base_msgs/action/MoveBase",
    "args": {"target_pose": POSE},
}
NAVIGATE = {
    "op": "send_action_goal",
    "action": "/navigate_to_pose",
    "action_type": "nav2_msgs/action/NavigateToPose",
    "args": {"pose": POSE},
}


# -- 3.2.6 Advertise service, 3.2.7 Unadvertise service ----------------------------------------------------------------


async def test_3_2_6_calls_of_an_advertised_service_come_to_the_client(client: StillClient, other: StillClient) -> None:
    client.say(op="advertise_service", **LIGHTS)
    other.say(op="call_service", service="lights", args={"data": True}, id=7)
    [call] = client.received()
    assert (call["op"], call["service"], call["args"]) == ("call_service", "/lights", {"data": True})
    client.say(op="service_response", service="/lights", id=call["id"], values={"success": True}, result=True)
    [answer] = await answers(other)
    assert (answer["id"], answer["values"], answer["result"]) == (7, {"success": True, "message": ""}, True)


@pytest.mark.parametrize("wrong", [{"type": None}, {"service": 7}, {"service": "a b"}, {"type": "SetBool"}])
async def test_3_2_6_an_invalid_advertisement_is_an_error(client: StillClient, wrong: dict[str, Any]) -> None:
    client.say(**{"op": "advertise_service", **LIGHTS} | wrong)
    [frame] = client.received()
    assert (frame["op"], frame["level"]) == ("status", "error")


async def test_3_2_7_a_service_that_is_unadvertised_gets_no_more_calls(
    client: StillClient, other: StillClient, place: StillPlace
) -> None:
    """Calls in progress may still be answered; rosbridge_suite aborts them."""
    client.say(op="advertise_service", **LIGHTS)
    other.say(op="call_service", service="/lights", args=[True], id="c")
    [call] = client.received()
    client.say(op="unadvertise_service", service="/lights")
    other.say(op="call_service", service="/lights", args=[], id="d")
    assert client.received() == []
    assert [call.service for call in place.far.take(robot_link.ServiceCall)] == ["lights"]
    client.say(op="service_response", service="/lights", id=call["id"], result=True)
    [answer] = await answers(other)
    assert (answer["id"], answer["result"]) == ("c", True)


async def test_3_2_7_a_service_that_is_not_advertised_is_an_error(client: StillClient) -> None:
    client.say(op="unadvertise_service", service="/lights")
    [frame] = client.received()
    assert frame["msg"].startswith("not-found: ")


# -- 3.2.8 Call service, 3.2.9 Service response ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "sent"),
    [
        ({}, {}), ({"args": None}, {}), ({"args": []}, {}), ({"args": {}}, {}),
        ({"args": {"tolerance": 1.0}}, {"tolerance": 1.0}),
        ({"args": [{}, {}, 0.5]}, {"start": {}, "goal": {}, "tolerance": 0.5}),
    ],
)  # fmt: skip
async def test_3_2_8_arguments_are_an_object_or_a_list_in_the_order_of_the_definition_or_left_out(
    client: StillClient, place: StillPlace, arguments: dict[str, Any], sent: dict[str, Any]
) -> None:
    client.say(op="call_service", service="/make_plan", type="nav_msgs/GetPlan", **arguments)
    [call] = place.far.take(robot_link.ServiceCall)
    assert json.loads(call.payload) == sent


async def test_3_2_8_too_many_arguments_are_refused(client: StillClient) -> None:
    client.say(op="call_service", service="/make_plan", args=[{}, {}, 0.5, 1], id="c")
    [answer] = await answers(client)
    assert (answer["id"], answer["result"]) == ("c", False)
    assert "start, goal, tolerance" in answer["values"]


@pytest.mark.parametrize("timeout", [0, -1, None, 0.0, 1e300])
async def test_3_2_8_a_timeout_that_is_none_is_that_of_the_cloud(
    client: StillClient, place: StillPlace, timeout: float | None
) -> None:
    client.say(op="call_service", service="/make_plan", id="c", timeout=timeout)
    [call] = place.far.take(robot_link.ServiceCall)
    place.say(robot_link.ServiceAnswer(call.call, b'{"plan":{}}'))
    [answer] = await answers(client)
    assert answer["result"] is True


async def test_3_2_8_a_call_that_is_not_answered_in_time_fails(client: StillClient) -> None:
    client.say(op="call_service", service="/make_plan", id="c", timeout=0.01)
    [answer] = await answers(client)
    assert (answer["id"], answer["result"]) == ("c", False)


async def test_3_2_8_a_service_that_does_not_exist_fails(client: StillClient, place: StillPlace) -> None:
    client.say(op="call_service", service="/nowhere", id="c")
    [call] = place.far.take(robot_link.ServiceCall)
    place.say(robot_link.ServiceAnswer(call.call, refusal=Refusal("not-found", "unknown service")))
    [answer] = await answers(client)
    assert (answer["id"], answer["result"], answer["values"]) == ("c", False, "unknown service")


async def test_3_2_8_an_id_after_the_name_is_the_id_of_old_clients(client: StillClient) -> None:
    client.say(op="call_service", service="/rosapi/get_time#33")
    [answer] = client.received()
    assert (answer["service"], answer["id"], answer["result"]) == ("/rosapi/get_time#33", "33", True)


async def test_3_2_9_a_response_names_the_service_as_called_and_has_the_id(client: StillClient) -> None:
    for spelling in ("/rosapi/get_time", "rosapi/get_time"):
        client.say(op="call_service", service=spelling, id=1)
        [answer] = client.received()
        assert set(answer) == {"op", "service", "values", "result", "id"}
        assert (answer["service"], answer["id"]) == (spelling, 1)


@pytest.mark.parametrize(
    ("response", "reason"),
    [
        ({"result": False, "values": "no light"}, "no light"),
        ({"result": False, "values": {}}, "service '/lights': the client reported a failure"),
        ({"result": False}, "service '/lights': the client reported a failure"),
        ({}, "service '/lights': the client reported a failure"),
    ],
)
async def test_3_2_9_a_response_without_a_result_is_a_failure_with_its_reason(
    client: StillClient, other: StillClient, response: dict[str, Any], reason: str
) -> None:
    client.say(op="advertise_service", **LIGHTS)
    other.say(op="call_service", service="/lights", id="c")
    [call] = client.received()
    client.say(op="service_response", service="/lights", id=call["id"], **response)
    [answer] = await answers(other)
    assert (answer["result"], answer["values"]) == (False, reason)


async def test_3_2_9_a_response_may_have_the_id_as_a_number_and_no_values(
    client: StillClient, other: StillClient
) -> None:
    client.say(op="advertise_service", **LIGHTS)
    other.say(op="call_service", service="/lights", id="c")
    [call] = client.received()
    client.say(op="service_response", service="/lights", id=int(call["id"]), result=True)
    [answer] = await answers(other)
    assert (answer["result"], answer["values"]) == (True, {"success": False, "message": ""})


PLAN = {"service": "/plan", "type": "nav_msgs/GetPlan"}


def ask(client: StillClient, other: StillClient, offered: dict[str, Any], args: Any, **fields: Any) -> dict[str, Any]:
    """Return the call that comes to the client that advertises a service."""
    client.say(op="advertise_service", **offered)
    other.say(op="call_service", service=offered["service"], args=args, id="c", **fields)
    [call] = client.received()
    assert isinstance(call, dict)
    return call


async def test_3_2_8_a_request_to_a_client_is_complete(client: StillClient, other: StillClient) -> None:
    request = ask(client, other, PLAN, {"tolerance": 1, "start": {"header": {"stamp": {"sec": 3, "nanosec": 4}}}})[
        "args"
    ]
    assert request["tolerance"] == 1.0
    assert request["start"]["header"]["stamp"] == {"secs": 3, "nsecs": 4}
    assert request["goal"]["pose"]["position"] == {"x": 0.0, "y": 0.0, "z": 0.0}


@pytest.mark.parametrize("args", [{"data": "on"}, {"light": True}, [True, False]])
async def test_3_2_8_a_request_that_is_not_of_its_type_is_refused_to_its_sender(
    client: StillClient, other: StillClient, args: Any
) -> None:
    client.say(op="advertise_service", **LIGHTS)
    other.say(op="call_service", service="/lights", args=args, id="c")
    [answer] = await answers(other)
    assert (answer["id"], answer["result"]) == ("c", False)
    assert client.received() == []


@pytest.mark.parametrize("values", [{"success": "yes"}, {"done": True}, "x", [True, "", 1]])
async def test_3_2_9_a_response_that_is_not_of_its_type_fails_the_call_and_is_an_error_of_its_sender(
    client: StillClient, other: StillClient, values: Any
) -> None:
    call = ask(client, other, LIGHTS, {"data": True})
    reported = says(client, op="service_response", service="/lights", id=call["id"], values=values, result=True)
    assert "the response of service 'lights'" in error_of(reported)["msg"]
    [answer] = await answers(other)
    assert answer["result"] is False and "the response of service 'lights'" in answer["values"]
    error_of(says(client, op="service_response", service="/lights", id=call["id"], result=True), "not-found")


async def test_3_2_9_requests_and_responses_of_an_unknown_type_pass_as_they_are(
    client: StillClient, other: StillClient
) -> None:
    odd = {"secs": "any", "values": [None, {}]}
    call = ask(client, other, {"service": "/odd", "type": "my_msgs/srv/Odd"}, odd)
    assert call["args"] == odd
    client.say(op="service_response", service="/odd", id=call["id"], values=odd, result=True)
    [answer] = await answers(other)
    assert answer["values"] == odd


@pytest.mark.parametrize(
    ("offered", "called", "asked_in_ros2", "answered_in_ros2"),
    [
        ("nav_msgs/GetPlan", {}, False, False),
        ("nav_msgs/srv/GetPlan", {}, True, True),
        ("nav_msgs/srv/GetPlan", {"type": "nav_msgs/GetPlan"}, True, False),
        ("nav_msgs/GetPlan", {"type": "nav_msgs/srv/GetPlan"}, False, True),
    ],
)
async def test_3_2_9_each_client_gets_times_as_the_type_that_it_names_spells_them(
    client: StillClient,
    other: StillClient,
    offered: str,
    called: dict[str, str],
    asked_in_ros2: bool,
    answered_in_ros2: bool,
) -> None:
    stamp = {"sec": 3, "nanosec": 4}
    call = ask(client, other, PLAN | {"type": offered}, {"start": {"header": {"stamp": stamp}}}, **called)
    assert set(call["args"]["start"]["header"]["stamp"]) == ({"sec", "nanosec"} if asked_in_ros2 else {"secs", "nsecs"})
    plan = {"header": {"stamp": stamp}}
    client.say(op="service_response", service="/plan", id=call["id"], values={"plan": plan}, result=True)
    [answer] = await answers(other)
    times = set(answer["values"]["plan"]["header"]["stamp"])
    assert times == ({"sec", "nanosec"} if answered_in_ros2 else {"secs", "nsecs"})
    assert answer["values"]["plan"]["poses"] == []


# -- 3.2.12 Send action goal to 3.2.15 Action result -------------------------------------------------------------------


def goal_of(place: StillPlace) -> tuple[str, Any]:
    """Return the id of the goal that was sent to Move Base, and the goal."""
    [deliver] = place.far.take(robot_link.Deliver)
    message = json.loads(deliver.payload)
    return message["goal_id"]["id"], message["goal"]


def status(goal: str, number: int) -> dict[str, Any]:
    return {"goal_id": {"id": goal}, "status": number, "text": "why"}


@pytest.mark.parametrize("arguments", [{"target_pose": POSE}, [POSE]])
async def test_3_2_12_arguments_of_a_goal_are_an_object_or_a_list(
    client: StillClient, place: StillPlace, arguments: Any
) -> None:
    client.say(**GOAL | {"args": arguments}, id=1)
    assert goal_of(place)[1] == {"target_pose": POSE}


@pytest.mark.parametrize("goal", [GOAL, NAVIGATE])
@pytest.mark.parametrize("identity", ["g", 7, None])
async def test_3_2_12_a_goal_ends_with_exactly_one_result_with_its_id(
    client: StillClient, place: StillPlace, goal: dict[str, Any], identity: str | int | None
) -> None:
    client.say(**goal, id=identity)
    sent, _ = goal_of(place)
    for _ in range(2):
        place.publish_json("move_base/result", {"status": status(sent, 3), "result": {}})
    [result] = client.received()
    assert (result["op"], result["id"], result["status"], result["result"]) == ("action_result", identity, 4, True)
    assert result["action"] == goal["action"]


@pytest.mark.parametrize(("feedback", "count"), [(True, 1), (False, 0), (None, 0)])
async def test_3_2_14_feedback_is_sent_on_request(
    client: StillClient, place: StillPlace, feedback: bool | None, count: int
) -> None:
    client.say(**GOAL, id=7, feedback=feedback)
    sent, _ = goal_of(place)
    place.publish_json("move_base/feedback", {"status": status(sent, 1), "feedback": {"base_position": POSE}})
    frames = client.received()
    assert [(frame["op"], frame["id"], frame["values"]["base_position"]) for frame in frames] == [
        ("action_feedback", 7, POSE)
    ] * count


@pytest.mark.parametrize("identity", ["g", 7])
async def test_3_2_13_a_goal_is_cancelled_by_its_id(
    client: StillClient, place: StillPlace, identity: str | int
) -> None:
    client.say(**GOAL, id=identity)
    sent, _ = goal_of(place)
    client.say(op="cancel_action_goal", action="/move_base", id=identity)
    [cancel] = place.far.take(robot_link.Deliver)
    assert (cancel.topic, json.loads(cancel.payload)) == ("move_base/cancel", {"id": sent})


async def test_3_2_13_a_goal_that_is_not_active_is_reported(client: StillClient) -> None:
    """As an error; rosbridge_suite says nothing."""
    client.say(op="cancel_action_goal", action="/move_base", id=7)
    [frame] = client.received()
    assert (frame["op"], frame["id"]) == ("status", 7)
    assert frame["msg"].startswith("not-found: ")


@pytest.mark.parametrize(("ends", "number"), [(3, 4), (2, 5), (8, 5), (4, 6), (5, 6)])
async def test_3_2_15_the_status_of_a_result_is_that_of_action_msgs(
    client: StillClient, place: StillPlace, ends: int, number: int
) -> None:
    client.say(**GOAL, id="g")
    sent, _ = goal_of(place)
    place.publish_json("move_base/result", {"status": status(sent, ends), "result": {}})
    [result] = client.received()
    assert (result["status"], result["result"]) == (number, True)


async def test_3_2_15_a_goal_that_the_clone_refuses_has_a_result(client: StillClient, place: StillPlace) -> None:
    client.say(**NAVIGATE | {"args": {}}, id="g")  # an orientation of zeros
    [deliver] = place.far.take(robot_link.Deliver)
    refusal = Refusal("invalid-input", "the orientation of a goal is all zero")
    place.say(robot_link.MessageRefused(deliver.client, deliver.topic, refusal, deliver.sequence))
    results = [frame for frame in client.received() if frame["op"] == "action_result"]
    assert [(frame["id"], frame["status"], frame["result"]) for frame in results] == [("g", 0, False)]
