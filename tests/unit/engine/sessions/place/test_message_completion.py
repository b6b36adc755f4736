"""Messages from client to client: complete, and of their type."""

import json
from typing import Any

import pytest

from engine.sessions.place.message_completion import (
    ActionCompletion,
    ServiceCompletion,
    action_completion,
    completion_of,
    service_completion,
)
from ppaas.errors import MalformedMessage
from ppaas.messages import decode, encode
from ppaas.messages.registry import message_type, message_types


def completed(kind: str, message: Any) -> Any:
    complete = completion_of(kind, lambda: 12.5)
    assert complete is not None
    return json.loads(complete(json.dumps(message).encode()))


def test_what_a_message_leaves_out_has_its_default() -> None:
    zero = {"x": 0.0, "y": 0.0, "z": 0.0}
    assert completed("geometry_msgs/Twist", {"linear": {"x": 0.5}}) == {"linear": zero | {"x": 0.5}, "angular": zero}
    assert completed("std_msgs/String", {}) == {"data": ""}


@pytest.mark.parametrize("stamp", [{}, {"stamp": None}, {"stamp": "now"}])
def test_a_header_that_names_no_time_is_stamped(stamp: dict[str, Any]) -> None:
    message = completed("geometry_msgs/PoseStamped", {"header": {"frame_id": "map"} | stamp})
    assert message["header"] == {"seq": 0, "stamp": {"secs": 12, "nsecs": 500_000_000}, "frame_id": "map"}
    assert completed("geometry_msgs/PoseStamped", {})["header"]["stamp"] == {"secs": 12, "nsecs": 500_000_000}


@pytest.mark.parametrize("stamp", [{"secs": 0, "nsecs": 0}, {"sec": 0, "nanosec": 0}, {"sec": 3, "nanosec": 4}])
def test_a_time_that_is_named_is_kept(stamp: dict[str, int]) -> None:
    seconds, rest = stamp.values()
    message = completed("geometry_msgs/PoseStamped", {"header": {"stamp": stamp}})
    assert message["header"]["stamp"] == {"secs": seconds, "nsecs": rest}


@pytest.mark.parametrize(
    ("kind", "message", "place"),
    [
        ("geometry_msgs/Twist", {"linear": "fast"}, "$.linear"),
        ("geometry_msgs/Twist", {"linear": {"x": "1"}}, "$.linear.x"),
        ("geometry_msgs/Twist", {"speed": 1.0}, "speed"),
        ("std_msgs/Bool", {"data": 1.5}, "$.data"),
        ("std_msgs/Header", {"frame_id": "a\nb"}, "$.frame_id"),
    ],
)
def test_a_message_of_another_form_is_refused_with_the_place(kind: str, message: Any, place: str) -> None:
    with pytest.raises(MalformedMessage) as refused:
        completed(kind, message)
    assert place in str(refused.value)


def test_types_that_the_cloud_does_not_know_and_its_own_pass_as_they_are() -> None:
    assert completion_of("my_msgs/Chat") is None
    own = [name for name in message_types() if completion_of(name) is None]
    assert "ppaas_msgs/RobotState" in own
    of_ros = [name for name in own if name.startswith(("std_msgs/", "geometry_msgs/", "nav_msgs/", "sensor_msgs/"))]
    assert of_ros == ["sensor_msgs/BatteryState"]  # what a robot does not measure, it leaves out


@pytest.mark.parametrize("kind", [name for name in message_types() if completion_of(name) is not None])
def test_a_complete_message_is_unchanged(kind: str) -> None:
    cls = message_type(kind)
    whole = encode(decode(cls, b"{}"))
    complete = completion_of(kind, lambda: 0.0)
    assert complete is not None and complete(whole) == whole


def test_requests_and_responses_of_a_known_service_are_completed() -> None:
    request, response = service_completion("std_srvs/SetBool")
    assert request is not None and response is not None
    assert json.loads(request(b"{}")) == {"data": False}
    for values in (b"null", b"{}", b"[]", b"[false]"):
        assert json.loads(response(values)) == {"success": False, "message": ""}
    for wrong in (b'{"success": 2}', b'"x"', b'[true, "", 1]'):
        with pytest.raises(MalformedMessage):
            response(wrong)
    assert service_completion("my_msgs/Lights") == ServiceCompletion()


def test_goals_feedback_and_results_of_a_known_action_are_completed() -> None:
    goal, feedback, result = action_completion("move_base_msgs/MoveBase")
    assert goal is not None and feedback is not None and result is not None
    assert set(json.loads(goal(b"{}"))) == {"target_pose"}
    assert set(json.loads(feedback(b"{}"))) == {"base_position"}
    assert json.loads(result(b"{}")) == {}
    with pytest.raises(MalformedMessage):
        feedback(b'{"target_pose": {}}')
    assert action_completion("my_msgs/Fly") == ActionCompletion()
