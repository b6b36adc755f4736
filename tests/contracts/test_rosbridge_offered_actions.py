"""Clauses of the specification of rosbridge v2 on actions of clients; see ``test_rosbridge_specification.py``.

Members of the kind "a goal ends with exactly one result": clients that execute it succeed, cancel, abort, fail, leave,
withdraw the action, are taken over, answer twice or with nonsense; clients that sent it leave before.
"""

from typing import Any

import pytest

from engine.protocols import robot_link
from engine.sessions.place.client_actions import MAX_ACTIONS
from tests.support.endpoints.still_place import StillClient, StillPlace, error_of, says

DOCK = {"action": "/dock", "type": "dock_msgs/action/Dock"}
GOAL = {"op": "send_action_goal", "action": "/dock", "action_type": "dock_msgs/action/Dock"}
RESULT = {"op": "action_result", "action": "/dock"}


def send(sender: StillClient, executor: StillClient, **fields: Any) -> Any:
    """Send a goal, and return its id at the client that executes it."""
    assert says(sender, **GOAL | {"id": "g"} | fields) == []
    [goal] = executor.received()
    assert goal["op"] == "send_action_goal"
    return goal["id"]


# -- 3.2.10 Advertise action -------------------------------------------------------------------------------------------


async def test_3_2_10_goals_of_an_advertised_action_come_to_the_client(client: StillClient, other: StillClient) -> None:
    assert says(client, op="advertise_action", **DOCK) == []
    assert says(other, **GOAL, id=7, args={"dock_id": "home"}) == []
    [goal] = client.received()
    assert (goal["op"], goal["action"], goal["action_type"]) == ("send_action_goal", "/dock", DOCK["type"])
    assert (goal["args"], goal["feedback"], type(goal["id"])) == ({"dock_id": "home"}, True, str)


@pytest.mark.parametrize(
    "wrong", [{"type": None}, {"action": 7}, {"action": "a b"}, {"type": "DockRobot"}, {"type": 3}]
)
async def test_3_2_10_an_invalid_advertisement_is_an_error(client: StillClient, wrong: dict[str, Any]) -> None:
    [frame] = says(client, **{"op": "advertise_action", **DOCK, "id": "a"} | wrong)
    assert (frame["op"], frame["level"], frame["id"]) == ("status", "error", "a")


@pytest.mark.parametrize("name", ["/move_base", "navigate_to_pose"])
async def test_3_2_10_actions_of_the_clone_cannot_be_taken_over(client: StillClient, name: str) -> None:
    error_of(says(client, op="advertise_action", action=name, type="nav2_msgs/action/NavigateToPose"), "conflict")


async def test_3_2_10_the_newest_client_takes_an_action_over_and_goals_stay_where_they_are(
    client: StillClient, other: StillClient
) -> None:
    """rosbridge_suite aborts the goals; but the robot that executes one may well go on."""
    client.say(op="advertise_action", **DOCK)
    first = send(other, client, id=1)
    other.say(op="advertise_action", **DOCK)
    assert send(client, other, id=2) != first
    client.say(**RESULT, id=first, values={}, status=4, result=True)
    assert [(frame["id"], frame["status"]) for frame in other.received()] == [(1, 4)]


async def test_3_2_10_the_number_of_actions_is_bounded(client: StillClient) -> None:
    for number in range(MAX_ACTIONS):
        assert says(client, op="advertise_action", action=f"/a{number}", type="a_msgs/action/A") == []
    error_of(says(client, op="advertise_action", **DOCK), "quota-exceeded")


async def test_3_2_10_rosapi_lists_the_action_with_its_type(client: StillClient, other: StillClient) -> None:
    client.say(op="advertise_action", **DOCK)
    [answer] = says(other, op="call_service", service="/rosapi/action_servers")
    assert "/dock" in answer["values"]["action_servers"]
    [answer] = says(other, op="call_service", service="/rosapi/action_type", args={"action": "/dock"})
    assert answer["values"] == {"type": "dock_msgs/action/Dock"}


# -- 3.2.11 Unadvertise action -----------------------------------------------------------------------------------------


async def test_3_2_11_goals_of_an_action_that_is_unadvertised_are_aborted(
    client: StillClient, other: StillClient
) -> None:
    client.say(op="advertise_action", **DOCK)
    executed = send(other, client)
    assert says(client, op="unadvertise_action", action="dock") == []
    [result] = other.received()
    assert (result["op"], result["id"], result["status"], result["result"]) == ("action_result", "g", 6, False)
    assert "unadvertised" in result["values"]
    error_of(says(client, **RESULT, id=executed, status=4, result=True), "not-found")
    [result] = says(other, **GOAL, id="h")
    assert (result["id"], result["status"]) == ("h", 0) and "unknown action 'dock'" in result["values"]


async def test_3_2_11_an_action_that_is_not_advertised_is_an_error(client: StillClient, other: StillClient) -> None:
    client.say(op="advertise_action", **DOCK)
    error_of(says(other, op="unadvertise_action", action="/dock"), "not-found")


# -- 3.2.12 Send action goal, 3.2.13 Cancel action goal ----------------------------------------------------------------


async def test_3_2_12_a_goal_of_another_type_is_refused_with_a_result(client: StillClient, other: StillClient) -> None:
    client.say(op="advertise_action", **DOCK)
    [result] = says(other, **GOAL | {"action_type": "nav2_msgs/action/Spin"}, id="g")
    assert (result["id"], result["status"], result["result"]) == ("g", 0, False)
    assert "has type Dock, not Spin" in result["values"]
    assert client.received() == []


@pytest.mark.parametrize(("arguments", "reason"), [([1, 2], "send the arguments as an object"), ("x", "an object, or")])
async def test_3_2_12_arguments_of_an_unknown_type_must_be_an_object(
    client: StillClient, other: StillClient, arguments: Any, reason: str
) -> None:
    client.say(op="advertise_action", **DOCK)
    [result] = says(other, **GOAL, id="g", args=arguments)
    assert result["result"] is False and reason in result["values"]


async def test_3_2_12_arguments_of_a_known_type_may_be_a_list(client: StillClient, other: StillClient) -> None:
    kind = "move_base_msgs/action/MoveBase"
    client.say(op="advertise_action", action="/fly", type=kind)
    other.say(**GOAL | {"action": "fly", "action_type": "move_base_msgs/MoveBaseAction", "args": [{"header": {}}]})
    args = client.received()[0]["args"]
    assert args["target_pose"]["header"]["stamp"] == {"sec": 0, "nanosec": 0}
    assert args["target_pose"]["pose"]["position"] == {"x": 0.0, "y": 0.0, "z": 0.0}


FLY = {"action": "/fly", "type": "move_base_msgs/action/MoveBase"}
FLYING = GOAL | {"action": "/fly", "action_type": FLY["type"], "id": "g"}


async def test_3_2_12_a_goal_that_is_not_of_its_type_is_refused_to_its_sender(
    client: StillClient, other: StillClient
) -> None:
    client.say(op="advertise_action", **FLY)
    for args in ({"target_pose": "home"}, {"target": {}}):
        [result] = says(other, **FLYING | {"args": args})
        assert (result["op"], result["result"], result["id"]) == ("action_result", False, "g")
    assert client.received() == []


async def test_3_2_14_and_3_2_15_feedback_and_results_are_complete_in_the_spelling_of_the_sender(
    client: StillClient, other: StillClient
) -> None:
    client.say(op="advertise_action", **FLY)
    for kind, times in ((FLY["type"], {"sec", "nanosec"}), ("move_base_msgs/MoveBase", {"secs", "nsecs"})):
        executed = send(other, client, **FLYING | {"action_type": kind, "feedback": True})
        client.say(op="action_feedback", action="/fly", id=executed, values={"base_position": {}})
        [feedback] = other.received()
        assert set(feedback["values"]["base_position"]["header"]["stamp"]) == times
        client.say(op="action_result", action="/fly", id=executed, values=None, status=4, result=True)
        [result] = other.received()
        assert (result["values"], result["result"]) == ({}, True)


async def test_3_2_14_and_3_2_15_wrong_feedback_is_dropped_and_a_wrong_result_aborts_the_goal(
    client: StillClient, other: StillClient
) -> None:
    client.say(op="advertise_action", **FLY)
    executed = send(other, client, **FLYING | {"feedback": True})
    error_of(says(client, op="action_feedback", action="/fly", id=executed, values={"at": 1}), "malformed-message")
    assert other.received() == []
    wrong = {"op": "action_result", "action": "/fly", "values": {"found": 1}, "status": 4, "result": True}
    assert "the result of action 'fly'" in error_of(says(client, **wrong, id=executed))["msg"]
    [result] = other.received()
    assert (result["status"], result["result"], result["id"]) == (6, False, "g")
    assert "the result of action 'fly'" in result["values"]


async def test_3_2_12_an_id_names_one_active_goal(client: StillClient, other: StillClient) -> None:
    client.say(op="advertise_action", **DOCK)
    send(other, client)
    [result] = says(other, **GOAL, id="g")
    assert "still active" in result["values"]
    assert client.received() == []


async def test_3_2_13_the_client_that_executes_a_goal_is_told_once_to_cancel_it(
    client: StillClient, other: StillClient
) -> None:
    client.say(op="advertise_action", **DOCK)
    executed = send(other, client)
    for _ in range(2):
        assert says(other, op="cancel_action_goal", action="/dock", id="g") == []
    assert client.received() == [{"op": "cancel_action_goal", "id": executed, "action": "/dock"}]
    client.say(**RESULT, id=executed, values={"success": False}, status=5, result=True)
    [result] = other.received()
    assert (result["status"], result["values"], result["result"]) == (5, {"success": False}, True)
    error_of(says(other, op="cancel_action_goal", action="/dock", id="g"), "not-found")


@pytest.mark.parametrize(
    ("arguments", "cancelled", "code"),
    [
        ({}, 2, 0),
        ({"goal_info": {"stamp": {"sec": 2**31, "nanosec": 0}}}, 2, 0),
        ({"goal_info": {"stamp": {"sec": 1, "nanosec": 0}}}, 0, 0),
        ({"goal_info": {"goal_id": {"uuid": [1] * 16}}}, 0, 2),
    ],
)
async def test_3_2_13_the_cancel_service_cancels_the_goals_of_an_action(
    client: StillClient, other: StillClient, place: StillPlace, arguments: dict[str, Any], cancelled: int, code: int
) -> None:
    client.say(op="advertise_action", **DOCK)
    for number in range(2):
        send(other, client, id=number)
    [answer] = says(other, op="call_service", service="/dock/_action/cancel_goal", args=arguments)
    assert answer["values"]["return_code"] == code
    assert [frame["op"] for frame in client.received()] == ["cancel_action_goal"] * cancelled
    assert place.far.take(robot_link.Deliver) == []


# -- 3.2.14 Action feedback, 3.2.15 Action result ----------------------------------------------------------------------


@pytest.mark.parametrize(("wanted", "count"), [(True, 1), (False, 0), (None, 0)])
async def test_3_2_14_feedback_comes_to_the_client_that_wants_it(
    client: StillClient, other: StillClient, wanted: bool | None, count: int
) -> None:
    client.say(op="advertise_action", **DOCK)
    executed = send(other, client, feedback=wanted)
    assert says(client, op="action_feedback", action="/dock", id=executed, values={"state": 1}) == []
    expected = {"op": "action_feedback", "action": "/dock", "values": {"state": 1}, "id": "g"}
    assert other.received() == [expected] * count


@pytest.mark.parametrize("identity", ["g", 7, None])
@pytest.mark.parametrize("status", [4, 5, 6])
async def test_3_2_15_a_goal_ends_with_one_result(
    client: StillClient, other: StillClient, identity: str | int | None, status: int
) -> None:
    client.say(op="advertise_action", **DOCK)
    executed = send(other, client, id=identity)
    end = RESULT | {"id": executed, "values": {"success": True}, "status": status, "result": True}
    assert says(client, **end) == []
    assert other.received() == [end | {"id": identity}]
    error_of(says(client, **end), "not-found")
    assert other.received() == []


@pytest.mark.parametrize(
    ("end", "reason"),
    [
        ({"result": False, "values": "no dock"}, "no dock"),
        ({"result": False, "status": 6}, "action '/dock': the client failed"),
        ({"status": 6, "values": {}}, "action '/dock': the client failed"),
    ],
)
async def test_3_2_15_a_result_that_is_none_is_an_aborted_goal_with_its_reason(
    client: StillClient, other: StillClient, end: dict[str, Any], reason: str
) -> None:
    client.say(op="advertise_action", **DOCK)
    assert says(client, **RESULT | end, id=send(other, client)) == []
    [result] = other.received()
    assert (result["status"], result["result"], result["values"]) == (6, False, reason)


@pytest.mark.parametrize(
    ("frame", "slug"),
    [
        (RESULT | {"status": 2, "result": True}, "invalid-input"),
        (RESULT | {"status": None, "result": True}, "invalid-input"),
        (RESULT | {"status": 4, "result": True, "values": [1]}, "malformed-message"),
        ({"op": "action_feedback", "action": "/dock", "values": "x"}, "malformed-message"),
    ],
)
async def test_3_2_14_and_3_2_15_what_is_no_feedback_or_result_is_an_error_of_its_sender(
    client: StillClient, other: StillClient, frame: dict[str, Any], slug: str
) -> None:
    client.say(op="advertise_action", **DOCK)
    executed = send(other, client, feedback=True)
    error_of(says(client, **frame, id=executed), slug)
    assert other.received() == []
    client.say(**RESULT, id=executed, values=None, status=4, result=True)
    assert [frame["values"] for frame in other.received()] == [{}]


@pytest.mark.parametrize("identity", [None, "", "x", "99", "1" * 20, -1])
@pytest.mark.parametrize("op", ["action_feedback", "action_result"])
async def test_3_2_14_and_3_2_15_goals_that_are_not_active_are_errors(
    client: StillClient, op: str, identity: str | int | None
) -> None:
    client.say(op="advertise_action", **DOCK)
    error_of(says(client, op=op, action="/dock", id=identity, values={}, status=4, result=True), "not-found")


async def test_3_2_15_another_client_cannot_end_a_goal(client: StillClient, other: StillClient) -> None:
    client.say(op="advertise_action", **DOCK)
    executed = send(other, client)
    error_of(says(other, **RESULT, id=executed, values={}, status=4, result=True), "not-permitted")


async def test_3_2_15_a_goal_ends_when_the_client_that_executes_it_leaves(
    client: StillClient, other: StillClient
) -> None:
    client.say(op="advertise_action", **DOCK)
    send(other, client)
    client.session.end()
    [result] = other.received()
    assert (result["id"], result["status"], result["result"]) == ("g", 0, False)
    assert "has disconnected" in result["values"]


async def test_3_2_15_a_goal_goes_on_when_its_sender_leaves(client: StillClient, place: StillPlace) -> None:
    """As goals of the clone do."""
    client.say(op="advertise_action", **DOCK)
    sender = StillClient(place)
    executed = send(sender, client, feedback=True)
    sender.session.end()
    assert client.received() == []
    assert says(client, op="action_feedback", action="/dock", id=executed, values={}) == []
    assert says(client, **RESULT, id=executed, values={}, status=4, result=True) == []
    assert sender.received() == []
