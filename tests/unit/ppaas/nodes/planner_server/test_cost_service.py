"""Costs from many starts to many goals, by the planner server."""

import json

import numpy as np
import pytest

from ppaas.clone.planning_container import build_planning
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import GoalOutsideMap, InvalidInput, PlanTimeout
from ppaas.geometry import Pose2D
from ppaas.messages.codec import decode, encode
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.ppaas_msgs import ComputeCostsRequest, ComputeCostsResponse, ComputePathRequest
from ppaas.nodes.graph import Graph
from ppaas.nodes.planner_server.cost_service import MAX_COSTS, MAX_ENDS
from tests.support.world.planar_world import walled_map

LAYERS = build_layers(walled_map(6, 4, [(2.9, 0.0, 3.1, 2.5)]))
STARTS, GOALS = [Pose2D(1.0, 1.0), Pose2D(5.0, 3.0)], [Pose2D(5.0, 1.0), Pose2D(1.0, 3.0), Pose2D(1.0, 1.0)]


def ask(service: str, request):
    graph = Graph()
    build_planning(graph, LAYERS, threads=lambda: 2)
    answers: list = []
    graph.call(service, request, answers.append)
    (answer,) = answers
    return answer


def costs_of(starts=STARTS, goals=GOALS, **fields):
    return ask("compute_costs", ComputeCostsRequest([*map(Pose.of, starts)], [*map(Pose.of, goals)], **fields))


def test_costs_equal_those_of_paths():
    answer = decode(ComputeCostsResponse, encode(costs_of()))
    costs = json.loads(answer.costs)
    assert np.shape(costs) == (2, 3)
    assert costs[0][2] == 0.0
    for i, start in enumerate(STARTS):
        for j, goal in enumerate(GOALS):
            path = ask("compute_path", ComputePathRequest(Pose.of(start), Pose.of(goal)))
            assert costs[i][j] == pytest.approx(path.cost, rel=2e-4)
    assert answer.seconds >= 0.0


def test_costs_have_the_parameters_of_the_request():
    given = '{"inflation_radius": 1.5, "cost_scaling_factor": 1.0, "allow_unknown": false}'
    usual, wide = json.loads(costs_of().costs), json.loads(costs_of(parameters=given).costs)
    path = ask("compute_path", ComputePathRequest(Pose.of(STARTS[0]), Pose.of(GOALS[0]), parameters=given))
    assert wide[0][0] == pytest.approx(path.cost, rel=2e-4)
    assert wide[0][0] > usual[0][0]
    refused = costs_of(parameters='{"smooth": true}')
    assert isinstance(refused, InvalidInput)
    assert "a cost matrix has no parameter 'smooth'" in str(refused)


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
def test_invalid_request_is_refused(fields, error):
    answer = costs_of(**fields)
    assert isinstance(answer, InvalidInput)
    assert error in str(answer)


def test_goal_outside_the_map_is_refused():
    assert isinstance(costs_of(goals=[Pose2D(50.0, 1.0)]), GoalOutsideMap)


def test_timeout_is_obeyed():
    assert isinstance(costs_of(timeout=1e-6), PlanTimeout)


def test_no_starts_give_no_costs():
    assert json.loads(costs_of(starts=[]).costs) == []
