"""Node ``planner_server``: paths on a map, without a robot."""

import json
import math

import numpy as np
import pytest

from ppaas.clone.planning_container import build_planning
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import (
    GoalOccupied,
    GoalOutsideMap,
    InvalidInput,
    InvalidPlanner,
    MalformedMessage,
    NoValidPath,
    PlanTimeout,
    StartOutsideMap,
)
from ppaas.geometry import Pose2D, quaternion_of
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.codec import decode, encode
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.nav_msgs import GetPlanRequest, GetPlanResponse
from ppaas.messages.ppaas_msgs import ComputeCostsRequest, ComputeCostsResponse, ComputePathRequest, ComputePathResponse
from ppaas.nodes.graph import Graph
from ppaas.nodes.planner_server.node import MAX_COSTS, MAX_ENDS
from ppaas.plans.encoding.codes import unpack_poses
from ppaas.plans.path_service import PathAnswer, PathRequest
from ppaas.plans.reuse.setup import ReuseSetup
from tests.support.world.planar_world import walled_map

LAYERS = build_layers(walled_map(6, 4, [(2.9, 0.0, 3.1, 2.5), (4.0, 3.0, 5.0, 3.5)]))
START, GOAL = Pose2D(1.0, 1.0, 0.0), Pose2D(5.0, 1.0, 1.0)


def ask(service: str, request):
    graph = Graph()
    build_planning(graph, LAYERS, reuse=ReuseSetup("house", "v1"))
    answers: list = []
    graph.call(service, request, answers.append)
    (answer,) = answers
    return answer


def path(start=START, goal=GOAL, **fields):
    return ask("compute_path", ComputePathRequest(Pose.of(start), Pose.of(goal), **fields))


def rows_of(answer: ComputePathResponse):
    return np.array(json.loads(answer.poses))


def stamped(pose: Pose2D, frame: str = "map") -> PoseStamped:
    return PoseStamped(Header(frame_id=frame), Pose.of(pose))


def test_path_connects_start_and_goal_with_length_and_cost():
    answer = decode(ComputePathResponse, encode(path()))
    rows = rows_of(answer)
    assert rows[0, :2] == pytest.approx(START[:2])
    assert rows[-1] == pytest.approx([GOAL.x, GOAL.y, 0.0, *quaternion_of(GOAL.theta)])
    along = np.hypot(*np.diff(rows[:, :2], axis=0).T).sum()
    assert answer.length == pytest.approx(along)
    assert answer.length > 5.0
    assert answer.cost > 0.0 < answer.expanded
    assert answer.planner == "dijkstra"


def test_a_packed_path_is_the_same_path_with_all_digits():
    question = decode(PathRequest, encode(PathRequest(START, GOAL)))
    packed = decode(PathAnswer, encode(ask("compute_packed_path", question)))
    plain = path()
    np.testing.assert_allclose(unpack_poses(packed.poses), rows_of(plain), rtol=0.0, atol=6e-10)
    for name in ("cost", "length", "expanded", "planner", "plan_id", "origin"):
        assert getattr(packed, name) == getattr(plain, name)
    assert (packed.reused, bytes(packed.conditions).decode()) == (None, plain.conditions)
    assert len(packed.poses) < len(plain.poses) / 10


@pytest.mark.parametrize("start", [[], [1.0], [1.0, 1.0, 0.0, 0.0], [1.0, 1.0, None], [1e12, 1.0, 0.0]])
def test_a_packed_path_starts_at_a_pose(start: list[float]):
    with pytest.raises(MalformedMessage, match="start"):
        decode(PathRequest, json.dumps({"start": start, "goal": GOAL}))


def test_a_planner_may_be_named_by_its_ros_name():
    assert path(planner="global_planner/GlobalPlanner").planner == "dijkstra"


def test_ros_get_plan_is_answered():
    answer = ask("make_plan", GetPlanRequest(stamped(START), stamped(GOAL)))
    assert isinstance(answer, GetPlanResponse)
    answer = decode(GetPlanResponse, encode(answer))
    assert answer.plan.header.frame_id == "map"
    assert answer.plan.poses[-1].pose.planar() == pytest.approx(GOAL)


def test_blocked_goal_is_replaced_within_the_tolerance():
    in_box = Pose2D(4.5, 3.05, 0.0)
    assert isinstance(path(goal=in_box), GoalOccupied)
    answer = path(goal=in_box, tolerance=0.5)
    assert np.hypot(*(rows_of(answer)[-1, :2] - in_box[:2])) <= 0.5


@pytest.mark.parametrize(
    ("fields", "error", "code"),
    [
        ({"planner": "teleport"}, InvalidPlanner, 201),
        ({"start": Pose2D(-50, 0, 0)}, StartOutsideMap, 203),
        ({"goal": Pose2D(50, 0, 0)}, GoalOutsideMap, 204),
        ({"timeout": 1e-9}, PlanTimeout, 207),
    ],
)
def test_planning_error_has_its_code(fields, error, code):
    answer = path(**fields)
    assert isinstance(answer, error)
    assert answer.code == code


def test_unknown_planner_error_lists_the_known_ones():
    assert "dijkstra" in str(path(planner="teleport"))


@pytest.mark.parametrize(
    "fields",
    [
        {"start": Pose2D(math.nan, 0, 0)},
        {"goal": Pose2D(0, math.inf, 0)},
        {"tolerance": -1.0},
        {"tolerance": math.nan},
        {"timeout": 0.0},
        {"timeout": 1e9},
    ],
)
def test_invalid_request_is_refused(fields):
    assert isinstance(path(**fields), InvalidInput)


def test_a_request_with_parameters_plans_with_them():
    usual, wide = path(), path(parameters='{"inflation_radius": 1.5, "cost_scaling_factor": 1.0}')
    assert wide.plan_id != usual.plan_id
    assert wide.cost > usual.cost
    assert json.loads(wide.conditions)["global_costmap"] == {"inflation_radius": 1.5, "cost_scaling_factor": 1.0}
    assert isinstance(path(parameters='{"robot_radius": 0.8}'), NoValidPath)
    assert path(parameters='{"allow_unknown": true}').plan_id == usual.plan_id


@pytest.mark.parametrize(
    ("parameters", "reason"),
    [
        ("[]", "parameters must be a JSON object"),
        ("{", "parameters must be a JSON object"),
        ("[" * 5000, "parameters must be a JSON object"),
        ('{"speed": 1}', "planner 'dijkstra' has no parameter 'speed'; known: allow_unknown"),
        ('{"inflation_radius": -1}', "inflation_radius must be from 0 to 100"),
    ],
)
def test_invalid_parameters_are_refused(parameters, reason):
    answer = path(parameters=parameters)
    assert isinstance(answer, InvalidInput)
    assert reason in str(answer)


def test_an_unknown_planner_with_parameters_has_its_code():
    assert isinstance(path(planner="teleport", parameters='{"smooth": true}'), InvalidPlanner)


def test_poses_outside_the_map_frame_are_refused():
    answer = ask("make_plan", GetPlanRequest(stamped(START, "odom"), stamped(GOAL)))
    assert isinstance(answer, InvalidInput)
    assert "odom" in str(answer)


def test_unreachable_goal_has_no_valid_path():
    graph = Graph()
    build_planning(graph, build_layers(walled_map(6, 4, [(2.9, 0.0, 3.1, 4.0)])))
    answers: list = []
    graph.call("compute_path", ComputePathRequest(Pose.of(START), Pose.of(GOAL)), answers.append)
    assert isinstance(answers[0], NoValidPath)


COST_LAYERS = build_layers(walled_map(6, 4, [(2.9, 0.0, 3.1, 2.5)]))
STARTS, GOALS = [Pose2D(1.0, 1.0), Pose2D(5.0, 3.0)], [Pose2D(5.0, 1.0), Pose2D(1.0, 3.0), Pose2D(1.0, 1.0)]


def ask_costs(service: str, request):
    graph = Graph()
    build_planning(graph, COST_LAYERS, threads=lambda: 2)
    answers: list = []
    graph.call(service, request, answers.append)
    (answer,) = answers
    return answer


def costs_of(starts=STARTS, goals=GOALS, **fields):
    return ask_costs("compute_costs", ComputeCostsRequest([*map(Pose.of, starts)], [*map(Pose.of, goals)], **fields))


def test_costs_equal_those_of_paths():
    answer = decode(ComputeCostsResponse, encode(costs_of()))
    costs = json.loads(answer.costs)
    assert np.shape(costs) == (2, 3)
    assert costs[0][2] == 0.0
    for i, start in enumerate(STARTS):
        for j, goal in enumerate(GOALS):
            path = ask_costs("compute_path", ComputePathRequest(Pose.of(start), Pose.of(goal)))
            assert costs[i][j] == pytest.approx(path.cost, rel=2e-4)
    assert answer.seconds >= 0.0


def test_costs_have_the_parameters_of_the_request():
    given = '{"inflation_radius": 1.5, "cost_scaling_factor": 1.0, "allow_unknown": false}'
    usual, wide = json.loads(costs_of().costs), json.loads(costs_of(parameters=given).costs)
    path = ask_costs("compute_path", ComputePathRequest(Pose.of(STARTS[0]), Pose.of(GOALS[0]), parameters=given))
    assert wide[0][0] == pytest.approx(path.cost, rel=2e-4)
    assert wide[0][0] > usual[0][0]
    refused = costs_of(parameters='{"smooth": true}')
    assert isinstance(refused, InvalidInput)
    assert "a cost matrix has no parameter 'smooth'" in str(refused)


def test_costs_may_be_lengths_of_paths_instead_and_are_null_for_ends_in_walls():
    given = '{"lengths": true}'
    lengths = json.loads(costs_of(goals=[*GOALS, Pose2D(3.0, 0.5), Pose2D(99.0, 0.0)], parameters=given).costs)
    path = ask_costs("compute_path", ComputePathRequest(Pose.of(STARTS[0]), Pose.of(GOALS[0]), planner="hub_labels"))
    assert lengths[0][0] == pytest.approx(path.length, abs=0.1)
    assert lengths[0][2] == 0.0
    assert lengths[0][4] is None


def test_unreachable_goal_has_a_null_cost():
    layers = build_layers(walled_map(6, 4, [(2.9, 0.0, 3.1, 4.0)]))
    graph, answers = Graph(), []
    build_planning(graph, layers)
    graph.call("compute_costs", ComputeCostsRequest([Pose.of(STARTS[0])], [*map(Pose.of, GOALS)]), answers.append)
    assert [cost is None for cost in json.loads(answers[0].costs)[0]] == [True, False, False]


@pytest.mark.parametrize(
    ("fields", "error"),
    [
        ({"starts": [Pose2D(float("nan"), 0.0)]}, "position and orientation of start 0 must be finite"),
        ({"goals": [*GOALS, Pose2D(0.0, float("inf"))]}, "position and orientation of goal 3 must be finite"),
        ({"goals": GOALS * MAX_ENDS}, f"at most {MAX_ENDS} goals"),
        ({"starts": STARTS * 200, "goals": GOALS * 50}, f"at most {MAX_COSTS} costs"),
        ({"timeout": 0.0}, "timeout must be above 0"),
        ({"timeout": 1e9}, "timeout must be above 0 and at most"),
    ],
)
def test_invalid_cost_request_is_refused(fields, error):
    answer = costs_of(**fields)
    assert isinstance(answer, InvalidInput)
    assert error in str(answer)


def test_goal_outside_the_map_is_refused():
    assert isinstance(costs_of(goals=[Pose2D(50.0, 1.0)]), GoalOutsideMap)


def test_timeout_is_obeyed():
    assert isinstance(costs_of(timeout=1e-6), PlanTimeout)


def test_no_starts_give_no_costs():
    assert json.loads(costs_of(starts=[]).costs) == []
