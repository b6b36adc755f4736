"""Requests of Nav2 clients over rosbridge, sent to a real clone with a simulated robot.

The members of the kind are the topics and actions of Nav2's BasicNavigator and of rviz's panel, each with the field
names of ROS 2: ``goal_pose``, ``navigate_to_pose``, ``navigate_through_poses``, ``compute_path_to_pose``,
``compute_path_through_poses``, ``spin``, ``backup``, ``wait``.
"""

from collections.abc import AsyncIterator

import pytest

from engine.protocols import robot_link
from ppaas.errors import QuotaExceeded
from ppaas.geometry import Pose2D
from ppaas.wire.actions import Part, part_of_action
from tests.support.endpoints.driven_place import DrivenPlace
from tests.support.endpoints.nav2_frames import Json, goal, seconds, stamped
from tests.support.endpoints.still_place import StillClient, answers
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World, walled_map

PARTS: tuple[Part, ...] = ("Goal", "Result", "Feedback")
START = Pose2D(1.0, 1.0, 0.0)


@pytest.fixture
async def driven() -> DrivenPlace:
    place = DrivenPlace(ClosedLoop(World(walled_map(6, 4, []), START)))
    place.run(0.3)
    return place


@pytest.fixture
async def navigator(driven: DrivenPlace) -> AsyncIterator[StillClient]:
    made = StillClient(driven, "operator")
    yield made
    made.session.end()


POSE_FEEDBACK = [
    "current_pose", "navigation_time", "estimated_time_remaining", "number_of_recoveries", "distance_remaining",
]  # fmt: skip
TRACKING = ["position_tracking_error", "heading_tracking_error"]
MOTION = ["total_elapsed_time", "error_code", "error_msg"]
ERROR = ["error_code", "error_msg"]
PATH = ["path", "planning_time", *ERROR]


@pytest.mark.parametrize(
    ("action", "sent", "result", "feedback"),
    [
        ("NavigateToPose", ["pose", "behavior_tree"], ERROR, [*POSE_FEEDBACK, *TRACKING]),
        (
            "NavigateThroughPoses", ["poses", "behavior_tree"], [*ERROR, "waypoint_statuses"],
            [*POSE_FEEDBACK, *TRACKING, "number_of_poses_remaining", "waypoint_statuses"],
        ),
        ("ComputePathToPose", ["goal", "start", "planner_id", "use_start", "viapoints"], PATH, []),
        ("ComputePathThroughPoses", ["goals", "start", "planner_id", "use_start"], [*PATH, "last_reached_index"], []),
        (
            "Spin", ["target_yaw", "time_allowance", "disable_collision_checks"], MOTION,
            ["angular_distance_traveled"],
        ),
        (
            "BackUp", ["target", "speed", "time_allowance", "disable_collision_checks"], MOTION,
            ["distance_traveled"],
        ),
        ("Wait", ["time"], MOTION, ["time_left"]),
    ],
)  # fmt: skip
def test_an_action_has_the_fields_of_nav2_in_their_order(
    action: str, sent: list[str], result: list[str], feedback: list[str]
) -> None:
    """Those of Humble, then those of later releases up to Lyrical; a list of arguments is in this order."""
    parts = [list(part_of_action(f"nav2_msgs/action/{action}", part).field_names()) for part in PARTS]
    assert parts == [sent, result, feedback]


# -- goal_pose ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("topic", ["/goal_pose", "goal_pose", "/move_base_simple/goal"])
async def test_a_pose_that_is_published_is_a_goal(driven: DrivenPlace, navigator: StillClient, topic: str) -> None:
    navigator.say(op="advertise", topic=topic, type="geometry_msgs/msg/PoseStamped")
    navigator.say(op="publish", topic=topic, msg=stamped(1.6, 1.0))
    driven.carry()
    driven.driving.run(30.0)
    assert driven.driving.last_status() == 3
    assert driven.driving.world.pose.x == pytest.approx(1.6, abs=0.2)
    assert navigator.received() == []


@pytest.mark.parametrize(
    ("pose", "reason"),
    [
        (stamped(2.0, 1.0, frame="mars"), "transform: a goal cannot be transformed into 'map'"),
        (stamped(2.0, 1.0, w=0.0), "invalid-input: the orientation of a goal is all zero"),
        (stamped(2.0, 1.0, frame=""), "invalid-input: a goal needs header.frame_id"),
    ],
)
async def test_a_pose_that_is_no_goal_is_refused_with_the_reason(
    driven: DrivenPlace, navigator: StillClient, pose: Json, reason: str
) -> None:
    navigator.say(op="publish", topic="/goal_pose", msg=pose)
    driven.carry()
    [frame] = navigator.received()
    assert (frame["op"], frame["level"]) == ("status", "error")
    assert frame["msg"].startswith(reason)


# -- navigate_to_pose --------------------------------------------------------------------------------------------------


async def test_navigate_to_pose_reports_the_fields_of_nav2(driven: DrivenPlace, navigator: StillClient) -> None:
    ended = driven.result(navigator, goal("navigate_to_pose", "NavigateToPose", pose=stamped(3.0, 2.5)))
    assert (ended["status"], ended["result"]) == (4, True)
    assert (ended["values"]["error_code"], ended["values"]["error_msg"]) == (0, "")
    feedback = ended["feedback"]
    assert {frozenset(each) for each in feedback} == {frozenset({*POSE_FEEDBACK, *TRACKING})}
    assert max(abs(each["position_tracking_error"]) for each in feedback) < 0.2
    assert any(each["heading_tracking_error"] for each in feedback)
    left = [each["distance_remaining"] for each in feedback]
    assert left[1] == pytest.approx(2.5, abs=0.3)
    assert left[-1] < 0.3
    times = [seconds(each["estimated_time_remaining"]) for each in feedback]
    assert 3.0 < times[1] < 8.0
    assert times[-1] < 3.0
    assert all(each["number_of_recoveries"] == 0 for each in feedback)


# -- navigate_through_poses --------------------------------------------------------------------------------------------


async def test_navigate_through_poses_reports_the_fields_of_nav2(driven: DrivenPlace, navigator: StillClient) -> None:
    poses = [stamped(2.5, 1.0), stamped(4.0, 2.5)]
    ended = driven.result(navigator, goal("navigate_through_poses", "NavigateThroughPoses", poses=poses))
    statuses = ended["values"].pop("waypoint_statuses")
    assert (ended["status"], ended["result"], ended["values"]) == (4, True, {"error_code": 0, "error_msg": ""})
    assert [(each["waypoint_index"], each["waypoint_status"]) for each in statuses] == [(0, 1), (1, 1)]
    assert {frozenset(each) for each in ended["feedback"]} == {
        frozenset({*POSE_FEEDBACK, *TRACKING, "number_of_poses_remaining", "waypoint_statuses"})
    }
    remaining = [each["number_of_poses_remaining"] for each in ended["feedback"]]
    assert (set(remaining), remaining) == ({1, 2}, sorted(remaining, reverse=True))
    assert seconds(ended["feedback"][0]["estimated_time_remaining"]) > 4.0
    assert driven.driving.world.pose.distance_to(Pose2D(4.0, 2.5, 0.0)) < 0.25


@pytest.mark.parametrize(
    ("args", "reason"),
    [
        ({"poses": []}, "from 1 to 100 poses, not 0"),
        ({"poses": [stamped(2.0, 1.0), stamped(2.0, 1.0, w=0.0)]}, "the orientation of pose 2 is all zero"),
        ({"poses": [stamped(2.0, 1.0)], "behavior_tree": "tree.xml"}, "behavior trees are not supported"),
        ({"goals": [stamped(2.0, 1.0)]}, "poses, behavior_tree"),
    ],
)
async def test_poses_that_are_no_goal_are_refused_with_the_reason(
    driven: DrivenPlace, navigator: StillClient, args: Json, reason: str
) -> None:
    ended = driven.result(navigator, goal("navigate_through_poses", "NavigateThroughPoses", **args))
    assert (ended["status"], ended["result"]) == (0, False)
    assert reason in ended["values"]


async def test_navigate_through_poses_is_cancelled_by_its_service(driven: DrivenPlace, navigator: StillClient) -> None:
    poses = [stamped(2.5, 1.0), stamped(4.0, 2.5)]
    navigator.say(op="send_action_goal", **goal("navigate_through_poses", "NavigateThroughPoses", poses=poses))
    driven.run(1.0)
    navigator.say(op="call_service", service="/navigate_through_poses/_action/cancel_goal", id="c", args={})
    ended = driven.next_result(navigator, 2.0)
    assert (ended["status"], ended["result"]) == (5, True)


# -- compute_path_to_pose, compute_path_through_poses ------------------------------------------------------------------


def ends(path: Json) -> list[tuple[float, float]]:
    assert path["header"]["frame_id"] == "map"
    positions = [path["poses"][index]["pose"]["position"] for index in (0, -1)]
    return [(position["x"], position["y"]) for position in positions]


@pytest.mark.parametrize(
    ("args", "start"),
    [
        ({"goal": stamped(4.0, 3.0)}, (1.0, 1.0)),
        ({"goal": stamped(4.0, 3.0), "start": stamped(2.0, 3.0), "planner_id": "", "use_start": False}, (1.0, 1.0)),
        (
            {"goal": stamped(4.0, 3.0), "start": stamped(2.0, 3.0), "planner_id": "GridBased", "use_start": True},
            (2.0, 3.0),
        ),
    ],
)
async def test_compute_path_to_pose_returns_a_path_and_the_planning_time(
    driven: DrivenPlace, navigator: StillClient, args: Json, start: tuple[float, float]
) -> None:
    ended = driven.result(navigator, goal("compute_path_to_pose", "ComputePathToPose", **args))
    assert (ended["status"], ended["result"]) == (4, True)
    assert set(ended["values"]) == {"path", "planning_time", "error_code", "error_msg"}
    assert ends(ended["values"]["path"]) == [pytest.approx(start, abs=0.05), pytest.approx((4.0, 3.0))]
    assert seconds(ended["values"]["planning_time"]) > 0.0
    assert driven.driving.world.pose == START


async def test_compute_path_through_poses_returns_one_path(driven: DrivenPlace, navigator: StillClient) -> None:
    goals = [stamped(4.0, 3.0), stamped(4.0, 1.0)]
    ended = driven.result(navigator, goal("compute_path_through_poses", "ComputePathThroughPoses", goals=goals))
    assert (ended["status"], ended["values"]["error_code"]) == (4, 0)
    assert ends(ended["values"]["path"]) == [pytest.approx((1.0, 1.0), abs=0.05), pytest.approx((4.0, 1.0))]


async def test_a_path_that_does_not_exist_is_aborted_with_code_and_text(
    driven: DrivenPlace, navigator: StillClient
) -> None:
    ended = driven.result(navigator, goal("compute_path_to_pose", "ComputePathToPose", goal=stamped(40.0, 3.0)))
    assert (ended["status"], ended["result"], ended["values"]["error_code"]) == (6, True, 204)
    assert "outside" in ended["values"]["error_msg"]
    assert ended["values"]["path"]["poses"] == []


@pytest.mark.parametrize(
    ("args", "reason"),
    [
        ({}, "the orientation of pose 1 is all zero"),
        ({"goal": stamped(1.0, 1.0, frame="")}, "pose 1 needs header.frame_id"),
        ({"pose": stamped(1.0, 1.0)}, "goal, start, planner_id, use_start"),
    ],
)
async def test_what_is_no_pose_is_refused_with_the_reason(
    driven: DrivenPlace, navigator: StillClient, args: Json, reason: str
) -> None:
    ended = driven.result(navigator, goal("compute_path_to_pose", "ComputePathToPose", **args))
    assert (ended["status"], ended["result"]) == (0, False)
    assert reason in ended["values"]


@pytest.mark.parametrize("by_topic", [False, True])
async def test_paths_count_towards_the_quota_of_plans(driven: DrivenPlace, by_topic: bool) -> None:
    def refuse() -> None:
        raise QuotaExceeded("120000 plans a minute: try again later")

    limited = StillClient(driven, "operator", count_plan=refuse)
    if by_topic:
        limited.say(op="publish", topic="/compute_path_to_pose/goal", msg={"goal": {"goal": stamped(4.0, 3.0)}})
    else:
        limited.say(op="send_action_goal", **goal("compute_path_to_pose", "ComputePathToPose", goal=stamped(4.0, 3.0)))
    [frame] = limited.received()
    assert "plans a minute" in (frame["msg"] if by_topic else frame["values"])
    assert driven.far.take(robot_link.Deliver) == []
    limited.session.end()


# -- spin, backup, wait ------------------------------------------------------------------------------------------------

ALLOWANCE = {"sec": 10, "nanosec": 0}


@pytest.mark.parametrize(
    ("action", "kind", "args", "progress"),
    [
        ("spin", "Spin", {"target_yaw": 1.57, "time_allowance": ALLOWANCE}, "angular_distance_traveled"),
        (
            "backup", "BackUp",
            {"target": {"x": 0.3, "y": 0.0, "z": 0.0}, "speed": 0.1, "time_allowance": ALLOWANCE}, "distance_traveled",
        ),
        ("wait", "Wait", {"time": {"sec": 1, "nanosec": 500000000}}, "time_left"),
    ],
)  # fmt: skip
async def test_a_behaviour_reports_the_fields_of_nav2(
    driven: DrivenPlace, navigator: StillClient, action: str, kind: str, args: Json, progress: str
) -> None:
    ended = driven.result(navigator, goal(action, kind, **args))
    assert (ended["status"], ended["result"]) == (4, True)
    assert {frozenset(each) for each in ended["feedback"]} == {frozenset({progress})}
    assert set(ended["values"]) == {"total_elapsed_time", "error_code", "error_msg"}
    assert seconds(ended["values"]["total_elapsed_time"]) > 1.0
    assert (ended["values"]["error_code"], ended["values"]["error_msg"]) == (0, "")


async def test_a_robot_does_not_back_up_into_a_wall(driven: DrivenPlace, navigator: StillClient) -> None:
    args = {"target": {"x": 3.0}, "speed": 0.3, "time_allowance": ALLOWANCE}
    ended = driven.result(navigator, goal("backup", "BackUp", **args))
    assert (ended["status"], ended["result"], ended["values"]["error_code"]) == (6, True, 714)
    assert "the space behind is not free" in ended["values"]["error_msg"]
    assert driven.driving.clearance > 0.15


async def test_a_behaviour_is_cancelled(driven: DrivenPlace, navigator: StillClient) -> None:
    navigator.say(op="send_action_goal", **goal("spin", "Spin", target_yaw=6.0))
    driven.run(1.0)
    navigator.say(op="cancel_action_goal", action="/spin", id="spin")
    ended = driven.next_result(navigator, 2.0)
    assert (ended["status"], ended["result"]) == (5, True)
    assert driven.driving.command.angular.z == 0.0


async def test_an_invalid_behaviour_is_aborted_with_code_and_text(driven: DrivenPlace, navigator: StillClient) -> None:
    ended = driven.result(navigator, goal("backup", "BackUp", target={"x": 0.3}))
    assert (ended["status"], ended["values"]["error_code"]) == (6, 713)
    assert ended["values"]["error_msg"] == "speed must not be 0 m/s"


# -- clearing of costmaps ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("arguments", [{}, {"args": {}}, {"args": {"request": {}}}])
@pytest.mark.parametrize("costmap", ["global_costmap", "local_costmap"])
async def test_a_costmap_is_cleared_by_the_service_of_nav2(
    driven: DrivenPlace, navigator: StillClient, costmap: str, arguments: Json
) -> None:
    service, kind = f"/{costmap}/clear_entirely_{costmap}", "nav2_msgs/srv/ClearEntireCostmap"
    navigator.say(op="call_service", service=service, type=kind, id="c", **arguments)
    driven.carry()
    [answer] = await answers(navigator)
    assert (answer["id"], answer["result"], answer["values"]) == ("c", True, {"response": {}, "success": True})


# -- what is served ----------------------------------------------------------------------------------------------------


async def test_the_actions_of_nav2_are_among_the_action_servers(driven: DrivenPlace, navigator: StillClient) -> None:
    navigator.say(op="call_service", service="/rosapi/action_servers", id="a")
    [answer] = navigator.received()
    assert set(answer["values"]["action_servers"]) >= {
        "/navigate_to_pose", "/navigate_through_poses", "/compute_path_to_pose", "/compute_path_through_poses",
        "/spin", "/backup", "/wait",
    }  # fmt: skip


async def test_an_action_that_is_not_served_is_refused_with_those_that_are(
    driven: DrivenPlace, navigator: StillClient
) -> None:
    ended = driven.result(navigator, goal("smooth_path", "SmoothPath"))
    assert (ended["status"], ended["result"]) == (0, False)
    assert "unknown action 'smooth_path'; known: backup, " in ended["values"]
