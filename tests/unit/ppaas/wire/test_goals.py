"""Goals by ``send_action_goal`` over the topics of an action: each ends exactly once, whatever happens."""

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import Conflict, InvalidInput, MalformedMessage, NotFound, QuotaExceeded, TransformError
from ppaas.navigation.goal_watch import MIN_LISTS, SETTLED
from ppaas.wire.actions import PARTS, actions, find_action
from ppaas.wire.goals import MAX_GOALS, GoalFrame, GoalTracker
from ppaas.wire.operations import CancelActionGoal, SendActionGoal
from ppaas.wire.rosbridge import RosbridgeSession

TOPICS = {
    "move_base/goal": "move_base_msgs/MoveBaseActionGoal",
    "fetch/goal": "toy_msgs/FetchActionGoal",
    "move_base_simple/goal": "geometry_msgs/PoseStamped",
} | {f"{name}/{part}": "toy_msgs/Part" for name in ("move_base", "fetch") for part in PARTS[1:]}
MOVE_BASE = "move_base_msgs/MoveBaseAction"
NAV2 = "nav2_msgs/action/NavigateToPose"


def pose(x: float, frame: str = "map") -> dict[str, Any]:
    return {
        "header": {"frame_id": frame, "stamp": {"secs": 1, "nsecs": 2}},
        "pose": {"position": {"x": x, "y": 0.0}, "orientation": {"z": 0.0, "w": 1.0}},
    }


def sent(**fields: Any) -> SendActionGoal:
    given = {"op": "send_action_goal", "id": "1", "action": "/move_base", "action_type": MOVE_BASE}
    operation = RosbridgeSession().receive(json.dumps(given | {"args": {"target_pose": pose(4.0)}} | fields))
    assert isinstance(operation, SendActionGoal)
    return operation


class Client:
    """The goals of one client, and the frames sent to it."""

    def __init__(self) -> None:
        self.goals = GoalTracker("c")
        self.frames: list[dict[str, Any]] = []

    def send(self, now: float = 0.0, **fields: Any) -> dict[str, Any]:
        """Send a goal; return the message for the action."""
        operation = sent(**fields)
        action = find_action(operation.action.removeprefix("/"), operation.action_type, TOPICS)
        _, message = self.goals.send(operation, action, now)
        found: dict[str, Any] = json.loads(message)
        return found

    def receive(self, topic: str, now: float = 0.0, **message: Any) -> None:
        """Receive a message of the action."""
        self._note(*self.goals.hear(topic, json.dumps(message).encode(), now))

    def _note(self, *sent_frames: GoalFrame) -> None:
        self.frames += [json.loads(one.frame) for one in sent_frames]

    def receive_statuses(self, now: float, *statuses: tuple[str, int]) -> None:
        """Receive the list of statuses."""
        listed = [{"goal_id": {"id": goal}, "status": status, "text": "why"} for goal, status in statuses]
        self.receive("move_base/status", now, header={}, status_list=listed)

    def receive_settled(self, since: float, *statuses: tuple[str, int]) -> None:
        """Receive as many lists over as much time as end a goal that they do not show as active."""
        for number in range(MIN_LISTS):
            self.receive_statuses(since + number * SETTLED / (MIN_LISTS - 1), *statuses)

    def receive_result(self, goal: str, status: int) -> None:
        """Receive a result."""
        self.receive("move_base/result", status={"goal_id": {"id": goal}, "status": status, "text": "why"}, result={})


def test_goal_has_its_own_id_and_its_result_that_of_the_client() -> None:
    client = Client()
    first, second = client.send(id="1"), client.send(id="2")
    assert first["goal"] == {"target_pose": pose(4.0)}
    assert first["goal_id"]["id"] != second["goal_id"]["id"]
    client.receive_result(second["goal_id"]["id"], 3)
    assert client.frames == [
        {"op": "action_result", "action": "/move_base", "values": {}, "status": 4, "result": True, "id": "2"}
    ]
    assert len(client.goals) == 1


@pytest.mark.parametrize(("status", "expected"), [(3, 4), (2, 5), (8, 5), (4, 6), (5, 6)])
def test_result_statuses_are_those_of_ros_2(status: int, expected: int) -> None:
    client = Client()
    client.receive_result(client.send()["goal_id"]["id"], status)
    assert [(frame["status"], frame["result"]) for frame in client.frames] == [(expected, True)]


def test_feedback_is_sent_to_clients_that_requested_it() -> None:
    client = Client()
    feedback = {"base_position": pose(1.0)}
    for number, wanted in enumerate((True, False)):
        goal = client.send(id=str(number), feedback=wanted)["goal_id"]["id"]
        client.receive("move_base/feedback", status={"goal_id": {"id": goal}, "status": 1}, feedback=feedback)
    assert client.frames == [{"op": "action_feedback", "action": "/move_base", "values": feedback, "id": "0"}]
    assert client.goals.topics() == {"move_base/status", "move_base/result", "move_base/feedback"}


def test_cancel_uses_the_goal_id_of_the_action() -> None:
    client = Client()
    goal = client.send(id="mine")["goal_id"]["id"]
    action, message = client.goals.cancel(CancelActionGoal("/move_base", "mine"))
    assert (action, json.loads(message)) == ("move_base", {"id": goal})
    with pytest.raises(NotFound):
        client.goals.cancel(CancelActionGoal("/move_base", "other"))


def test_navigate_to_pose_has_nav2_fields_and_ros_2_times() -> None:
    client = Client()
    args = {"pose": pose(4.0), "behavior_tree": ""}
    message = client.send(10.0, action="navigate_to_pose", action_type=NAV2, args=args, feedback=True)
    goal = message["goal_id"]["id"]
    assert message["goal"]["target_pose"]["pose"]["position"]["x"] == 4.0
    status = {"goal_id": {"id": goal}, "status": 1}
    client.receive("move_base/feedback", 12.5, status=status, feedback={"base_position": pose(1.0)})
    client.receive_result(goal, 4)
    feedback, result = client.frames
    assert feedback["values"]["distance_remaining"] == 3.0
    assert feedback["values"]["navigation_time"] == {"sec": 2, "nanosec": 500000000}
    assert feedback["values"]["current_pose"]["header"]["stamp"] == {"sec": 1, "nanosec": 2}
    assert (result["values"], result["status"]) == ({"error_code": 9000, "error_msg": "why"}, 6)


def test_distance_remaining_is_null_for_a_goal_in_another_frame() -> None:
    client = Client()
    args = [pose(4.0, frame="odom")]
    goal = client.send(action="navigate_to_pose", action_type=NAV2, args=args, feedback=True)["goal_id"]["id"]
    status = {"goal_id": {"id": goal}, "status": 1}
    client.receive("move_base/feedback", status=status, feedback={"base_position": pose(1.0)})
    assert client.frames[0]["values"]["distance_remaining"] is None


def test_navigate_to_pose_estimates_time_and_distance_by_the_progress_of_move_base() -> None:
    client = Client()
    args = {"pose": pose(4.0, frame="odom")}
    message = client.send(10.0, action="navigate_to_pose", action_type=NAV2, args=args, feedback=True)
    assert client.goals.topics() == {
        "move_base/status", "move_base/result", "move_base/feedback", "navigate_to_pose/feedback",
    }  # fmt: skip
    status = {"goal_id": message["goal_id"], "status": 1}
    progress = {
        "current_pose": pose(0.9),
        "navigation_time": {"secs": 1, "nsecs": 0},
        "estimated_time_remaining": {"secs": 8, "nsecs": 5},
        "number_of_recoveries": 2,
        "distance_remaining": 3.5,
    }
    client.receive("navigate_to_pose/feedback", 12.0, header={}, status=status, feedback=progress)
    assert client.frames == []
    client.receive("move_base/feedback", 12.5, status=status, feedback={"base_position": pose(1.0)})
    [frame] = client.frames
    assert frame["values"]["current_pose"]["pose"]["position"]["x"] == 1.0
    assert {key: value for key, value in frame["values"].items() if key != "current_pose"} == {
        "navigation_time": {"sec": 2, "nanosec": 500000000},
        "estimated_time_remaining": {"sec": 8, "nanosec": 5},
        "number_of_recoveries": 2,
        "distance_remaining": 3.5,
        "position_tracking_error": 0.0,
        "heading_tracking_error": 0.0,
    }


def test_unknown_action_type_is_passed_on() -> None:
    client = Client()
    kinds = {"action": "fetch", "action_type": "toy_interfaces/action/Fetch"}
    message = client.send(args={"what": "ball"}, **kinds)
    assert message["goal"] == {"what": "ball"}
    status = {"goal_id": message["goal_id"], "status": 3}
    client.receive("fetch/result", status=status, result={"took": {"secs": 3, "nsecs": 0}})
    assert client.frames[0]["values"] == {"took": {"sec": 3, "nanosec": 0}}


def test_goal_with_a_lost_result_ends_with_its_last_status() -> None:
    client = Client()
    goal = client.send()["goal_id"]["id"]
    client.receive_statuses(1.0, (goal, 1))
    client.receive_statuses(2.0, (goal, 3))
    assert client.frames == []
    client.receive_settled(2.0, (goal, 3))
    assert [(frame["status"], frame["result"]) for frame in client.frames] == [(4, True)]


def test_goal_missing_from_the_status_list_is_lost() -> None:
    client = Client()
    client.send()
    client.receive_settled(1.0)
    assert [(frame["status"], frame["result"]) for frame in client.frames] == [(0, False)]
    assert "lost" in client.frames[0]["values"]


def test_goal_that_reappears_in_the_status_list_is_not_lost() -> None:
    client = Client()
    goal = client.send()["goal_id"]["id"]
    client.receive_statuses(1.0)
    client.receive_statuses(2.0, (goal, 1))
    for number in range(MIN_LISTS - 1):
        client.receive_statuses(2.0 + number * SETTLED)
    assert client.frames == []


def test_refused_goal_ends_with_the_reason() -> None:
    client = Client()
    goal = client.send()["goal_id"]["id"]
    client.goals.posted(goal, 7)
    assert client.goals.refused(0, TransformError("no")) is None
    assert client.goals.refused(6, TransformError("no")) is None
    refused = client.goals.refused(7, TransformError("no frame 'moon'"))
    assert refused is not None and refused.final
    frame = json.loads(refused.frame)
    assert (frame["status"], frame["result"], frame["values"]) == (0, False, "no frame 'moon'")
    assert len(client.goals) == 0


@pytest.mark.parametrize(
    ("fields", "error"),
    [
        ({"action": "fly"}, NotFound),
        ({"action": "move_base_simple"}, NotFound),
        ({"action_type": "move_base_msgs/FlyAction"}, InvalidInput),
        ({"action_type": "?"}, InvalidInput),
        ({"args": 3}, MalformedMessage),
        ({"action": "navigate_to_pose", "action_type": NAV2, "args": {"pose": {"x": 1.0}}}, MalformedMessage),
        (
            {"action": "navigate_to_pose", "action_type": NAV2, "args": {"pose": pose(1.0), "behavior_tree": "x.xml"}},
            InvalidInput,
        ),
        ({"action": "navigate_to_pose", "action_type": MOVE_BASE}, InvalidInput),
    ],
)
def test_an_invalid_goal_is_refused(fields: dict[str, Any], error: type[Exception]) -> None:
    client = Client()
    with pytest.raises(error):
        client.send(**fields)
    assert len(client.goals) == 0


def test_goal_ids_of_a_client_are_unique_and_limited() -> None:
    client = Client()
    client.send(id="a")
    with pytest.raises(Conflict):
        client.send(id="a")
    for number in range(MAX_GOALS - 1):
        client.send(id=str(number))
    with pytest.raises(QuotaExceeded):
        client.send(id="last")


def test_an_unknown_status_is_malformed() -> None:
    client = Client()
    goal = client.send()["goal_id"]["id"]
    with pytest.raises(MalformedMessage):
        client.receive_result(goal, 99)
    assert len(client.goals) == 1


def test_actions_are_derived_from_the_topics() -> None:
    assert actions(TOPICS) == ["fetch", "move_base", "navigate_to_pose"]
    assert actions({}) == []
    assert actions({name: kind for name, kind in TOPICS.items() if name != "move_base/cancel"}) == ["fetch"]


EVENTS = st.lists(
    st.tuples(st.sampled_from(["result", "listed", "unlisted", "feedback"]), st.integers(0, 9)), max_size=30
)


@given(EVENTS)
def test_every_goal_ends_exactly_once(events: list[tuple[str, int]]) -> None:
    client = Client()
    goal = client.send(feedback=True)["goal_id"]["id"]
    for now, (event, status) in enumerate(events):
        if event == "result":
            client.receive_result(goal, status)
        elif event == "feedback":
            active = {"goal_id": {"id": goal}, "status": 1}
            client.receive("move_base/feedback", now, status=active, feedback={"base_position": pose(1.0)})
        else:
            client.receive_statuses(now, *([(goal, status)] if event == "listed" else []))
    client.receive_settled(1e3)
    results = [frame for frame in client.frames if frame["op"] == "action_result"]
    assert len(results) == 1
    assert client.frames[-1] is results[0]
