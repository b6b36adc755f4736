"""Path services of a clone whose robot stands or drives."""

import json
import math

import numpy as np
import pytest

from ppaas.errors import GoalOccupied, InvalidInput, NoValidPath, PPaaSError, TransformError
from ppaas.geometry import Pose2D
from ppaas.maps.grid import UNKNOWN
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.codec import decode, encode
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.nav_msgs import GetPlanRequest, GetPlanResponse
from ppaas.messages.ppaas_msgs import ComputePathRequest, ComputePathResponse
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World, fill, walled_map
from tests.support.world.touring import stamped

START, GOAL, ELSEWHERE = Pose2D(1.0, 1.0, 0.0), Pose2D(4.5, 3.0, 0.0), Pose2D(1.0, 3.0, 0.0)
NOWHERE = stamped(Pose2D(0.0, 0.0, 0.0), "")


def loop(boxes=(), **options) -> ClosedLoop:
    driving = ClosedLoop(World(walled_map(6, 4, list(boxes)), START), **options)
    for _ in range(6):
        driving.step()
    return driving


def ask(driving: ClosedLoop, start, goal, tolerance: float = 0.0) -> GetPlanResponse | PPaaSError:
    answers: list = []
    driving.graph.call("move_base/make_plan", GetPlanRequest(start, goal, tolerance), answers.append)
    (answer,) = answers
    return decode(GetPlanResponse, encode(answer)) if isinstance(answer, GetPlanResponse) else answer


def compute(driving: ClosedLoop, start: Pose2D, goal: Pose2D) -> ComputePathResponse:
    answers: list = []
    request = ComputePathRequest(Pose.of(start), Pose.of(goal))
    driving.graph.call("move_base/compute_path", request, answers.append)
    assert isinstance(answers[0], ComputePathResponse), answers
    return answers[0]


def ends(answer) -> tuple[Pose2D, Pose2D]:
    assert isinstance(answer, GetPlanResponse), answer
    return answer.plan.poses[0].pose.planar(), answer.plan.poses[-1].pose.planar()


def length(answer) -> float:
    points = np.array([pose.pose.planar()[:2] for pose in answer.plan.poses])
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def test_make_plan_neither_moves_the_robot_nor_publishes():
    driving = loop()
    start, goal = ends(ask(driving, stamped(ELSEWHERE), stamped(GOAL)))
    assert start.distance_to(ELSEWHERE) < 0.05
    assert goal == pytest.approx(GOAL)
    driving.run(1.0)
    assert (driving.commands, driving.plans, driving.texts) == ([], [], set())


def test_make_plan_does_not_disturb_a_driving_robot():
    """Of two equal robots, one plans for a service all the time, and drives exactly as the other does."""
    queried, undisturbed = loop(), loop()
    for driving in (queried, undisturbed):
        driving.send_goal(GOAL)
    answers = 0
    while not undisturbed.results:
        undisturbed.step()
        plans = len(queried.plans)
        if not queried.results:
            ends(ask(queried, stamped(GOAL), stamped(ELSEWHERE)))
            answers += 1
        assert len(queried.plans) == plans, "a plan on request is not published"
        queried.step()
    assert answers > 50
    assert queried.last_status() is Status.SUCCEEDED
    assert [plan.poses[-1].tolist() for plan in queried.plans] == [
        plan.poses[-1].tolist() for plan in undisturbed.plans
    ]
    assert queried.world.pose.distance_to(undisturbed.world.pose) < 0.05


def test_start_without_a_frame_is_the_robots_pose():
    driving = loop()
    assert ends(ask(driving, NOWHERE, stamped(GOAL)))[0].distance_to(START) < 0.15
    driving.send_goal(GOAL)
    driving.run(4.0)
    assert driving.world.pose.distance_to(START) > 0.5
    start, goal = ends(ask(driving, NOWHERE, stamped(ELSEWHERE)))
    assert start.distance_to(driving.world.pose) < 0.15
    assert goal == pytest.approx(ELSEWHERE)


def test_occupied_goal_is_planned_to_within_the_tolerance_only():
    driving = loop([(4.0, 2.5, 5.0, 3.5)])
    assert isinstance(ask(driving, stamped(START), stamped(GOAL)), GoalOccupied)
    _, end = ends(ask(driving, stamped(START), stamped(GOAL), tolerance=1.2))
    assert 0.5 < end.distance_to(GOAL) <= 1.2


WALL_WITH_DOORS = [(2.9, 0.0, 3.1, 0.6), (2.9, 1.6, 3.1, 2.4), (2.9, 3.4, 3.1, 4.0)]


@pytest.mark.parametrize("drives", [False, True])
def test_plans_avoid_obstacles_that_the_robot_sees(drives):
    driving = loop(WALL_WITH_DOORS)
    beyond = Pose2D(4.5, 1.1, 0.0)
    straight = length(ask(driving, NOWHERE, stamped(beyond)))
    cells = driving.world.grid.data.copy()
    fill(cells, driving.world.grid.info, (2.9, 0.6, 3.1, 1.6))
    driving.world.truth[cells != driving.world.grid.data] = True
    if drives:
        driving.send_goal(Pose2D(1.3, 1.0, 0.0))
    driving.run(0.5)
    assert length(ask(driving, NOWHERE, stamped(beyond))) > straight + 1.0
    assert compute(driving, START, beyond).length > straight + 1.0


def test_make_plan_uses_the_planners_parameters():
    grid = walled_map(6, 4, [])
    grid.data[:, 60:80] = UNKNOWN
    for allowed, expected in ((True, GetPlanResponse), (False, NoValidPath)):
        driving = ClosedLoop(World(grid, START), parameters={"dijkstra": {"allow_unknown": allowed}})
        assert isinstance(ask(driving, stamped(START), stamped(GOAL)), expected)


def test_plan_between_map_poses_needs_no_transform():
    """Localization is stamped later than its scan, so at the first one there is no time at which both are known.

    Then the pose of the robot is that of the first of each.
    """
    driving = ClosedLoop(World(walled_map(6, 4, []), START))
    driving.step()
    for start in (stamped(START), NOWHERE):
        here, there = ends(ask(driving, start, stamped(GOAL)))
        assert here.distance_to(START) < 0.06 and there.distance_to(GOAL) < 0.05


def test_unlocalized_robot_plans_from_a_given_start_only():
    driving = ClosedLoop(World(walled_map(6, 4, []), START))
    ends(ask(driving, stamped(START), stamped(GOAL)))
    refused = ask(driving, NOWHERE, stamped(GOAL))
    assert isinstance(refused, TransformError)
    assert str(refused).startswith("no odometry yet: publish nav_msgs/Odometry")


@pytest.mark.parametrize(
    ("start", "goal", "tolerance", "error"),
    [
        (stamped(START), stamped(GOAL, ""), 0.0, InvalidInput),
        (stamped(START, "mars"), stamped(GOAL), 0.0, TransformError),
        (stamped(START), stamped(GOAL, "mars"), 0.0, TransformError),
        (stamped(START), stamped(Pose2D(math.nan, 1.0)), 0.0, InvalidInput),
        (stamped(START), stamped(GOAL), -1.0, InvalidInput),
        (stamped(START), stamped(GOAL), math.nan, InvalidInput),
    ],
)
def test_invalid_request_is_refused_and_the_active_goal_continues(start, goal, tolerance, error):
    driving = loop()
    driving.send_goal(Pose2D(1.8, 1.0, 0.0))
    driving.run(0.5)
    assert isinstance(ask(driving, start, goal, tolerance), error)
    driving.run(20.0)
    assert driving.last_status() is Status.SUCCEEDED


def test_compute_path_returns_the_path_and_its_computation_time():
    answer = compute(loop(), ELSEWHERE, GOAL)
    rows = np.array(json.loads(answer.poses))
    assert rows[0, :2] == pytest.approx(ELSEWHERE[:2])
    assert rows[-1, :2] == pytest.approx(GOAL[:2])
    assert answer.seconds > 0.0
