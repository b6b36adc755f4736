"""Actions ``compute_path_to_pose`` and ``compute_path_through_poses`` in a whole clone, without I/O."""

import itertools
import math

import msgspec
import pytest

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages import nav2_msgs
from ppaas.messages.actionlib_msgs import GoalID, GoalStatusArray, Status
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.codec import decode, encode
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.nodes.jobs import Worker
from ppaas.nodes.move_base.path_actions import MAX_POSES
from ppaas.nodes.planner_server.planner_queue import MAX_WAITING
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World, walled_map

START = Pose2D(1.0, 1.0, 0.0)
FAR, CORNER = Pose2D(4.0, 3.0, 0.0), Pose2D(1.0, 3.0, 0.0)
OUTSIDE = Pose2D(40.0, 1.0, 0.0)
TO, THROUGH = "compute_path_to_pose", "compute_path_through_poses"


class LaterWorker:
    """Worker whose jobs run when the test says so."""

    def __init__(self) -> None:
        self.jobs: list = []

    def __call__(self, work, cancelled, done) -> None:
        self.jobs.append((work, cancelled, done))

    def run(self) -> None:
        while self.jobs:
            work, cancelled, done = self.jobs.pop(0)
            try:
                result = work(cancelled)
            except Exception as error:  # noqa: BLE001 - as a worker does
                result = error
            done(result)


class Asking:
    """A client of both actions, and what it hears."""

    def __init__(self, worker: Worker | None = None) -> None:
        options = {} if worker is None else {"worker": worker}
        self.driving = ClosedLoop(World(walled_map(6, 4, []), START), **options)
        self.results: list = []
        self.statuses: dict[str, list] = {TO: [], THROUGH: []}
        for name in (TO, THROUGH):
            self.driving.graph.tap(f"{name}/result", lambda _, message: self.results.append(message))
            self.driving.graph.tap(f"{name}/status", self._on_status)
        for _ in range(6):
            self.driving.step()

    def _on_status(self, topic: str, message: GoalStatusArray) -> None:
        self.statuses[topic.removesuffix("/status")] = [
            (each.goal_id.id, Status(each.status)) for each in message.status_list
        ]

    def ask(self, goal, start=None, *, planner="", name="p", frame="map", via=()):
        """Ask for a path to a pose, or through a list of poses; return the result if there is one."""
        had = len(self.results)
        first = stamped(start or Pose2D(0.0, 0.0, 0.0), frame if start else "")
        rest = {"start": first, "planner_id": planner, "use_start": start is not None}
        if isinstance(goal, list):
            content = nav2_msgs.ComputePathThroughPosesGoal([stamped(each, frame) for each in goal], **rest)
            message = nav2_msgs.ComputePathThroughPosesActionGoal(goal=content, goal_id=GoalID(id=name))
        else:
            content = nav2_msgs.ComputePathToPoseGoal(
                stamped(goal, frame), viapoints=[stamped(each, frame) for each in via], **rest
            )
            message = nav2_msgs.ComputePathToPoseActionGoal(goal=content, goal_id=GoalID(id=name))
        topic = f"{THROUGH if isinstance(goal, list) else TO}/goal"
        self.driving.graph.inject(topic, decode(type(message), encode(message)))
        return self.results[-1] if len(self.results) > had else None


def stamped(pose: Pose2D, frame: str = "map") -> PoseStamped:
    return PoseStamped(Header(frame_id=frame), Pose.of(pose))


def points(result) -> list[tuple[float, float]]:
    poses = msgspec.json.decode(encode(result.result.path))["poses"]
    return [(each["pose"]["position"]["x"], each["pose"]["position"]["y"]) for each in poses]


def test_a_path_begins_at_the_robot_which_does_not_move():
    asking = Asking()
    result = asking.ask(FAR)
    assert (result.status.goal_id.id, result.status.status) == ("p", Status.SUCCEEDED)
    assert (result.result.error_code, result.result.error_msg) == (0, "")
    assert points(result)[0] == pytest.approx(START[:2], abs=0.05)
    assert points(result)[-1] == pytest.approx(FAR[:2])
    assert result.result.planning_time.seconds() > 0.0
    assert not asking.driving.commands
    assert not asking.driving.plans


@pytest.mark.parametrize("planner", ["", "GridBased", "astar", "navfn/NavfnROS"])
def test_start_and_planner_may_be_chosen(planner):
    result = Asking().ask(FAR, CORNER, planner=planner)
    assert result.status.status == Status.SUCCEEDED, result.status.text
    assert points(result)[0] == pytest.approx(CORNER[:2])


def test_a_path_through_poses_passes_each_of_them_in_order():
    result = Asking().ask([FAR, CORNER, Pose2D(4.0, 1.0, 0.0)])
    path = points(result)
    passed = [min(range(len(path)), key=lambda index: math.dist(path[index], pose[:2])) for pose in (FAR, CORNER)]
    assert passed == sorted(passed)
    assert [math.dist(path[index], pose[:2]) for index, pose in zip(passed, (FAR, CORNER), strict=True)] == [0.0, 0.0]
    assert path[-1] == pytest.approx((4.0, 1.0))
    assert all(one != other for one, other in itertools.pairwise(path)), "the parts have one pose in common"


def test_a_path_to_a_pose_passes_its_viapoints():
    asking = Asking()
    result = asking.ask(FAR, via=[CORNER])
    path = points(result)
    assert result.status.status == Status.SUCCEEDED, result.status.text
    assert min(math.dist(point, CORNER[:2]) for point in path) == 0.0
    assert path[-1] == pytest.approx(FAR[:2])
    with pytest.raises(InvalidInput, match="viapoints may have at most 99 poses, not 100"):
        asking.ask(FAR, via=[CORNER] * 100)


@pytest.mark.parametrize(("goals", "reached"), [([FAR, CORNER], 1), ([FAR, OUTSIDE], -1), ([], -1)])
def test_the_result_names_the_goal_at_which_the_path_ends(goals, reached):
    assert Asking().ask(goals).result.last_reached_index == reached


@pytest.mark.parametrize(
    ("goal", "options", "code", "text"),
    [
        (FAR, {"planner": "teleport"}, 201, "teleport"),
        (FAR, {"frame": "mars"}, 202, "mars"),
        (FAR, {"start": OUTSIDE}, 203, "outside"),
        (OUTSIDE, {}, 204, "outside"),
        (FAR, {"start": Pose2D(0.0, 1.0, 0.0)}, 205, "in an obstacle"),
        (Pose2D(0.0, 1.0, 0.0), {}, 206, "goal"),
        ([FAR], {"planner": "teleport"}, 301, "teleport"),
        ([FAR, OUTSIDE], {}, 304, "pose 2 of 2: "),
        ([], {}, 309, "empty"),
    ],
)
def test_a_path_that_is_not_found_has_the_error_code_of_nav2_and_a_reason(goal, options, code, text):
    result = Asking().ask(goal, **options)
    assert result.status.status == Status.ABORTED
    assert (result.result.error_code, points(result)) == (code, [])
    assert text in result.result.error_msg
    assert result.result.error_msg == result.status.text


def test_a_robot_whose_pose_is_not_known_is_told_so():
    asking = Asking()
    asking.driving.sensing = False
    for _ in range(40):
        asking.driving.step()
    result = asking.ask(FAR)
    assert (result.status.status, result.result.error_code) == (Status.ABORTED, 202)
    assert "odom" in result.status.text
    assert asking.ask(FAR, CORNER, name="q").status.status == Status.SUCCEEDED


def test_an_invalid_goal_is_refused():
    asking = Asking()
    with pytest.raises(InvalidInput, match="position and orientation of pose 1 must be finite"):
        asking.driving.graph.inject(f"{TO}/goal", nav2_msgs.ComputePathToPoseActionGoal(
            goal=nav2_msgs.ComputePathToPoseGoal(stamped(Pose2D(math.nan, 0.0, 0.0)), stamped(START))
        ))  # fmt: skip
    with pytest.raises(InvalidInput, match=rf"at most {MAX_POSES} poses, not 101"):
        asking.ask([FAR] * 101)
    assert asking.results == []


def test_paths_of_several_clients_do_not_end_each_other():
    worker = LaterWorker()
    asking = Asking(worker)
    for name in "abc":
        assert asking.ask(FAR, name=name) is None
    assert [status for _, status in asking.statuses[TO]] == [Status.ACTIVE] * 3
    asking.driving.graph.inject(f"{TO}/cancel", GoalID(id="b"))
    asking.driving.graph.inject(f"{THROUGH}/cancel", GoalID())
    worker.run()
    ended = {each.status.goal_id.id: Status(each.status.status) for each in asking.results}
    assert ended == {"a": Status.SUCCEEDED, "b": Status.PREEMPTED, "c": Status.SUCCEEDED}
    assert dict(asking.statuses[TO]) == ended


def test_a_goal_that_is_sent_again_is_planned_once():
    asking = Asking()
    asking.ask(FAR)
    assert asking.ask(FAR) is None


def test_too_many_waiting_paths_end_with_a_reason():
    asking = Asking(LaterWorker())
    for number in range(MAX_WAITING + 1):
        assert asking.ask(FAR, name=f"p{number}") is None
    result = asking.ask(FAR, name="last")
    assert (result.status.status, result.result.error_code) == (Status.ABORTED, 200)
    assert "already waiting" in result.result.error_msg


def test_paths_in_progress_are_planned_again_by_another_container():
    asking = Asking(LaterWorker())
    asking.ask(FAR)
    asking.ask([FAR, CORNER])
    again = Asking()
    again.driving.graph.nodes["move_base"].restore(asking.driving.graph.nodes["move_base"].checkpoint())
    assert [each.status.status for each in again.results] == [Status.SUCCEEDED] * 2
    assert points(again.results[0])[0] == pytest.approx(START[:2], abs=0.05)
