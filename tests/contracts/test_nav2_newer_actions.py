"""Actions that Nav2 has gained since Humble, over rosbridge, sent to a real clone with a simulated robot.

The members of the kind are ``follow_path``, ``compute_route``, ``compute_and_track_route``, ``follow_object``,
``drive_on_heading`` and the service ``is_path_valid``, each with the field names of Nav2.
"""

import math
from collections.abc import AsyncIterator

import pytest

from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Time
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.transforms.planar import transform_message
from ppaas.wire.actions import Part, part_of_action
from ppaas.zones.reading import zones_of
from tests.support.endpoints.driven_place import DrivenPlace
from tests.support.endpoints.nav2_frames import Json, goal, seconds, stamped
from tests.support.endpoints.still_place import StillClient, answers
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World, walled_map

PARTS: tuple[Part, ...] = ("Goal", "Result", "Feedback")
START = Pose2D(1.0, 1.0, 0.0)
ERROR = ["error_code", "error_msg"]
LANES = b"""{"type": "FeatureCollection", "features": [
    {"type": "Feature", "properties": {"name": "east", "kind": "lane", "one_way": true},
     "geometry": {"type": "LineString", "coordinates": [[1.0, 1.0], [4.5, 1.0], [4.5, 3.0]]}},
    {"type": "Feature", "properties": {"name": "back", "kind": "lane", "one_way": true},
     "geometry": {"type": "LineString", "coordinates": [[4.5, 3.0], [1.0, 3.0]]}}
]}"""


@pytest.fixture
async def driven() -> DrivenPlace:
    place = DrivenPlace(ClosedLoop(World(walled_map(6, 4, []), START), masks={"zones": zones_of(LANES)}))
    place.run(0.3)
    return place


@pytest.fixture
async def navigator(driven: DrivenPlace) -> AsyncIterator[StillClient]:
    made = StillClient(driven, "operator")
    yield made
    made.session.end()


@pytest.mark.parametrize(
    ("action", "sent", "result", "feedback"),
    [
        (
            "FollowPath",
            ["path", "controller_id", "goal_checker_id", "progress_checker_id", "path_handler_id"],
            [*ERROR, "result"], ["distance_to_goal", "speed", "tracking_feedback"],
        ),
        (
            "ComputeRoute", ["start_id", "start", "goal_id", "goal", "use_start", "use_poses"],
            ["planning_time", "path", "route", *ERROR], [],
        ),
        (
            "ComputeAndTrackRoute", ["start_id", "start", "goal_id", "goal", "use_start", "use_poses"],
            ["execution_duration", *ERROR],
            ["last_node_id", "next_node_id", "current_edge_id", "route", "path", "operations_triggered", "rerouted"],
        ),
        (
            "FollowObject", ["pose_topic", "tracked_frame", "max_duration"],
            ["total_elapsed_time", "error_code", "num_retries", "error_msg"],
            ["state", "following_time", "num_retries"],
        ),
        (
            "DriveOnHeading", ["target", "speed", "time_allowance", "disable_collision_checks"],
            ["total_elapsed_time", *ERROR], ["distance_traveled"],
        ),
    ],
)  # fmt: skip
def test_an_action_has_the_fields_of_nav2_in_their_order(
    action: str, sent: list[str], result: list[str], feedback: list[str]
) -> None:
    parts = [list(part_of_action(f"nav2_msgs/action/{action}", part).field_names()) for part in PARTS]
    assert parts == [sent, result, feedback]


# -- follow_path -------------------------------------------------------------------------------------------------------

BEND = [(1.0, 1.0), (3.0, 1.0), (3.0, 2.5)]


def path(points: list[tuple[float, float]], frame: str = "map") -> Json:
    return {"header": {"frame_id": frame}, "poses": [{"pose": stamped(x, y)["pose"]} for x, y in points]}


async def test_a_robot_follows_the_path_of_a_client_and_not_one_that_it_plans(
    driven: DrivenPlace, navigator: StillClient
) -> None:
    navigator.say(op="send_action_goal", feedback=True, **goal("follow_path", "FollowPath", path=path(BEND)))
    corner, frames = math.inf, []
    while not frames or frames[-1]["op"] != "action_result":
        driven.run(0.25)
        corner = min(corner, driven.driving.world.pose.distance_to(Pose2D(3.0, 1.0)))
        frames += navigator.received()
        assert len(frames) < 1000
    *heard, ended = frames
    assert (ended["status"], ended["values"]["error_code"]) == (4, 0)
    assert corner < 0.5, "a planned path would pass it at 1.2 m"
    assert driven.driving.world.pose.distance_to(Pose2D(3.0, 2.5)) < 0.25
    feedback = [frame["values"] for frame in heard]
    first, last = feedback[1], feedback[-1]
    assert set(first) == {"distance_to_goal", "speed", "tracking_feedback"}
    assert first["distance_to_goal"] == pytest.approx(3.5, abs=0.2)
    assert last["distance_to_goal"] < 0.5
    tracking = [each["tracking_feedback"] for each in feedback]
    assert max(abs(each["position_tracking_error"]) for each in tracking) < 0.5
    assert tracking[0]["distance_to_goal"] == pytest.approx(math.hypot(2.0, 1.5), abs=0.2)
    assert tracking[0]["robot_pose"]["header"]["frame_id"] == "map"


@pytest.mark.parametrize(
    ("args", "code", "reason"),
    [
        ({"path": path([])}, 103, "the path is empty"),
        ({"path": path(BEND, "mars")}, 102, "mars"),
        ({"path": path(BEND), "controller_id": "Tank"}, 101, "unknown controller 'Tank'; known: FollowPath"),
        ({"path": path([(4.0, 3.0), (5.0, 3.0)])}, 106, "away from the path"),
    ],
)
async def test_a_path_that_cannot_be_followed_is_aborted_with_the_code_of_nav2(
    driven: DrivenPlace, navigator: StillClient, args: Json, code: int, reason: str
) -> None:
    ended = driven.result(navigator, goal("follow_path", "FollowPath", **args))
    assert (ended["status"], ended["values"]["error_code"]) == (6, code)
    assert reason in ended["values"]["error_msg"]
    assert driven.driving.world.pose.distance_to(START) < 0.05


async def test_a_path_through_a_wall_is_given_up_without_recovery_behaviours(
    driven: DrivenPlace, navigator: StillClient
) -> None:
    ended = driven.result(navigator, goal("follow_path", "FollowPath", path=path([(1.0, 1.0), (1.0, -3.0)])))
    assert (ended["status"], ended["values"]["error_code"]) == (6, 106)
    assert ended["values"]["error_msg"] == "Failed to find a valid plan. the path is blocked"
    assert driven.driving.clearance > 0.1


async def test_a_path_is_cancelled_by_its_action_alone(driven: DrivenPlace, navigator: StillClient) -> None:
    navigator.say(op="send_action_goal", **goal("follow_path", "FollowPath", path=path(BEND)))
    driven.run(1.0)
    navigator.say(op="call_service", service="/navigate_through_poses/_action/cancel_goal", id="n", args={})
    driven.run(1.0)
    assert driven.driving.command.linear.x > 0.1
    navigator.say(op="call_service", service="/follow_path/_action/cancel_goal", id="c", args={})
    ended = driven.next_result(navigator, 2.0)
    assert (ended["status"], ended["result"]) == (5, True)


# -- is_path_valid -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("args", "values"),
    [
        ({"path": path(BEND)}, {"is_valid": True, "invalid_pose_indices": []}),
        (
            {"path": path([(1.0, 1.0), (3.0, -1.0), (3.0, 9.0)])},
            {"is_valid": False, "invalid_pose_indices": [1]},
        ),
        (
            {"path": path([(1.0, 1.0), (3.0, -1.0), (3.0, 9.0)]), "stop_at_first_collision": False},
            {"is_valid": False, "invalid_pose_indices": [1, 2]},
        ),
        ({"path": path([(3.0, 9.0), (1.0, 1.0), (3.0, 1.0)])}, {"is_valid": True, "invalid_pose_indices": []}),
        (
            {"path": path([(1.0, 1.0), (3.0, 1.0), (9.0, 1.0)]), "max_lookahead_distance": 3.0},
            {"is_valid": True, "invalid_pose_indices": []},
        ),
        ({"path": path([])}, {"is_valid": False, "invalid_pose_indices": []}),
    ],
)
async def test_a_path_is_valid_if_its_poses_ahead_of_the_robot_are_free(
    driven: DrivenPlace, navigator: StillClient, args: Json, values: Json
) -> None:
    navigator.say(op="call_service", service="/is_path_valid", type="nav2_msgs/srv/IsPathValid", id="v", args=args)
    driven.carry()
    [answer] = await answers(navigator)
    assert (answer["result"], answer["values"]) == (True, values | {"success": True})


# -- compute_route, compute_and_track_route ----------------------------------------------------------------------------


async def test_routes_are_known_by_the_poses_at_their_ends(driven: DrivenPlace, navigator: StillClient) -> None:
    args = {"goal": stamped(4.5, 2.9), "use_poses": True}
    ended = driven.result(navigator, goal("compute_route", "ComputeRoute", **args))
    assert (ended["status"], ended["values"]["error_code"]) == (4, 0)
    route, way = ended["values"]["route"], ended["values"]["path"]["poses"]
    places = [(each["position"]["x"], each["position"]["y"]) for each in route["nodes"]]
    assert places == [(1.0, 1.0), (4.5, 1.0)], "the goal is beside the last edge"
    assert [(each["start"]["x"], each["end"]["x"]) for each in route["edges"]] == [(1.0, 4.5)]
    assert route["route_cost"] == pytest.approx(3.5)
    assert way[-1]["pose"]["position"] == pytest.approx({"x": 4.5, "y": 2.9, "z": 0.0})
    assert driven.driving.world.pose == START


@pytest.mark.parametrize(
    ("args", "code", "reason"),
    [
        ({"start_id": 1, "goal_id": 9}, 403, "unknown node '9'; nodes are numbered from 1 to 4"),
        ({"start_id": 4, "goal_id": 1}, 405, "no lanes lead from node 4 to node 1"),
        ({"goal": stamped(4.5, 2.9, "mars"), "use_poses": True}, 401, "mars"),
    ],
)
async def test_a_route_that_there_is_none_is_aborted_with_the_code_of_nav2(
    driven: DrivenPlace, navigator: StillClient, args: Json, code: int, reason: str
) -> None:
    for action, kind in (("compute_route", "ComputeRoute"), ("compute_and_track_route", "ComputeAndTrackRoute")):
        ended = driven.result(navigator, goal(action, kind, **args))
        assert (ended["status"], ended["values"]["error_code"]) == (6, code)
        assert reason in ended["values"]["error_msg"]


async def test_a_map_without_lanes_has_no_graph() -> None:
    place = DrivenPlace(ClosedLoop(World(walled_map(6, 4, []), START)))
    place.run(0.3)
    client = StillClient(place, "operator")
    ended = place.result(client, goal("compute_route", "ComputeRoute", start_id=1, goal_id=2))
    assert (ended["status"], ended["values"]["error_code"]) == (6, 402)
    assert ended["values"]["error_msg"] == "the map has no lanes: draw zones of the kind 'lane'"
    client.session.end()


async def test_a_route_is_tracked_while_the_robot_follows_its_path(driven: DrivenPlace, navigator: StillClient) -> None:
    navigator.say(
        op="send_action_goal", feedback=True,
        **goal("compute_and_track_route", "ComputeAndTrackRoute", start_id=1, goal_id=3),
    )  # fmt: skip
    driven.run(0.5)
    [begin, *_] = [frame["values"] for frame in navigator.received() if frame["op"] == "action_feedback"]
    assert [each["nodeid"] for each in begin["route"]["nodes"]] == [1, 2, 3]
    driver = StillClient(driven, "operator")
    driver.say(op="send_action_goal", **goal("follow_path", "FollowPath", path=begin["path"]))
    ended = driven.next_result(navigator)
    assert (ended["status"], ended["values"]["error_code"]) == (4, 0)
    assert seconds(ended["values"]["execution_duration"]) > 8.0
    seen = [(each["last_node_id"], each["next_node_id"], each["current_edge_id"]) for each in ended["feedback"]]
    assert sorted(set(seen), key=seen.index) == [(1, 2, 1), (2, 3, 2), (3, 0, 0)]
    driver.session.end()


# -- follow_object -----------------------------------------------------------------------------------------------------


def frame_at(x: float, y: float, now: float) -> TFMessage:
    return TFMessage([transform_message("map", "cart", Pose2D(x, y), Time.of(now))])


async def test_a_robot_follows_a_frame_at_a_distance(driven: DrivenPlace, navigator: StillClient) -> None:
    args = {"tracked_frame": "cart", "max_duration": {"sec": 20, "nanosec": 0}}
    navigator.say(op="send_action_goal", feedback=True, **goal("follow_object", "FollowObject", **args))
    states = set()
    for step in range(60):
        x = min(2.5 + 0.02 * step, 3.5)
        driven.driving.graph.inject("tf", frame_at(x, 2.5, driven.driving.clock()))
        driven.run(0.25)
    for frame in navigator.received():
        states.add(frame["values"]["state"])
    robot = driven.driving.world.pose
    assert robot.distance_to(Pose2D(3.5, 2.5)) == pytest.approx(1.0, abs=0.35)
    assert states >= {2, 3}
    ended = driven.next_result(navigator, 10.0)
    assert (ended["status"], ended["values"]["error_code"]) == (4, 0)
    assert seconds(ended["values"]["total_elapsed_time"]) == pytest.approx(20.0, abs=0.5)


async def test_a_robot_follows_the_poses_of_the_topic(driven: DrivenPlace, navigator: StillClient) -> None:
    navigator.say(op="send_action_goal", **goal("follow_object", "FollowObject", pose_topic="/dynamic_pose"))
    for _ in range(40):
        navigator.say(op="publish", topic="/dynamic_pose", msg=stamped(3.0, 1.0))
        driven.run(0.25)
    assert driven.driving.world.pose.x == pytest.approx(2.0, abs=0.35)
    navigator.say(op="call_service", service="/follow_object/_action/cancel_goal", id="c", args={})
    assert driven.next_result(navigator, 2.0)["status"] == 5
    driven.run(0.2)
    assert driven.driving.command.linear.x == 0.0


@pytest.mark.parametrize(
    ("args", "code", "reason"),
    [
        ({}, 999, "name a tracked_frame"),
        ({"pose_topic": "cart"}, 999, "poses of objects are taken from 'dynamic_pose', not from 'cart'"),
        ({"tracked_frame": "cart"}, 902, "the object was not seen for 10 s"),
    ],
)
async def test_an_object_that_cannot_be_followed_is_aborted_with_the_code_of_nav2(
    driven: DrivenPlace, navigator: StillClient, args: Json, code: int, reason: str
) -> None:
    ended = driven.result(navigator, goal("follow_object", "FollowObject", **args))
    assert (ended["status"], ended["values"]["error_code"]) == (6, code)
    assert reason in ended["values"]["error_msg"]


async def test_another_goal_ends_following(driven: DrivenPlace, navigator: StillClient) -> None:
    navigator.say(op="send_action_goal", **goal("follow_object", "FollowObject", pose_topic="dynamic_pose"))
    navigator.say(op="publish", topic="/dynamic_pose", msg=stamped(3.0, 1.0))
    driven.run(1.0)
    navigator.say(op="publish", topic="/goal_pose", msg=stamped(1.5, 2.0))
    ended = driven.next_result(navigator, 2.0)
    assert (ended["id"], ended["status"]) == ("follow_object", 5)
    driven.driving.run(30.0)
    assert driven.driving.world.pose.distance_to(Pose2D(1.5, 2.0)) < 0.3


# -- drive_on_heading --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("distance", "speed"), [(0.5, 0.2), (-0.3, -0.2)])
async def test_a_robot_drives_straight(
    driven: DrivenPlace, navigator: StillClient, distance: float, speed: float
) -> None:
    args = {"target": {"x": distance, "y": 0.0, "z": 0.0}, "speed": speed}
    ended = driven.result(navigator, goal("drive_on_heading", "DriveOnHeading", **args))
    assert (ended["status"], ended["values"]["error_code"]) == (4, 0)
    assert driven.driving.world.pose.x - START.x == pytest.approx(distance, abs=0.05)
    assert ended["feedback"][-1]["distance_traveled"] == pytest.approx(abs(distance), abs=0.05)


@pytest.mark.parametrize(
    ("x", "speed", "code", "reason"),
    [
        (9.0, 0.3, 723, "the space ahead is not free"),
        (0.5, -0.1, 724, "must have the same sign"),
        (0.5, 0.0, 724, "must have the same sign"),
    ],
)
async def test_a_straight_motion_that_is_not_possible_is_aborted_with_the_code_of_nav2(
    driven: DrivenPlace, navigator: StillClient, x: float, speed: float, code: int, reason: str
) -> None:
    args = {"target": {"x": x, "y": 0.0, "z": 0.0}, "speed": speed}
    ended = driven.result(navigator, goal("drive_on_heading", "DriveOnHeading", **args))
    assert (ended["status"], ended["values"]["error_code"]) == (6, code)
    assert reason in ended["values"]["error_msg"]
    assert driven.driving.clearance > 0.1
