import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import GoalOccupied, PlanCancelled, StartOccupied
from ppaas.geometry import Pose2D
from ppaas.planners.base import PlanRequest
from ppaas.planners.ends import escape, place_ends
from ppaas.planners.weights import passable
from tests.support.world import grids


def proceed():
    pass


def ends(map_, start, goal, allow_unknown=True, check=proceed, **request):
    ask = PlanRequest(grids.centre(map_, *start), grids.centre(map_, *goal, theta=0.5), **request)
    return place_ends(map_, ask, allow_unknown=allow_unknown, check=check)


def test_free_ends_are_unchanged():
    found = ends(grids.costmap("...", 0.1), (0, 0), (0, 2))
    assert (found.start, found.goal, len(found.escape)) == ((0, 0), (0, 2), 0)
    assert found.goal_pose == grids.centre(grids.costmap("...", 0.1), 0, 2, 0.5)


def test_the_escape_is_the_shortest_path_around_obstacles():
    map_ = grids.costmap("#ii.\n###i\niii.\n#iii", resolution=0.1)
    assert escape(map_, (1, 1), passable(True), proceed).tolist() == [[1, 1], [1, 2], [1, 3]]


def test_no_escape_cuts_the_corner_of_an_obstacle():
    map_ = grids.costmap("#.\ni#", resolution=0.1)
    with pytest.raises(StartOccupied, match="drive the robot out"):
        ends(map_, (0, 0), (1, 1))


def test_an_escape_is_at_most_two_metres_long():
    map_ = grids.costmap("i" * 21 + ".", resolution=0.1)
    assert ends(map_, (0, 1), (0, 21)).start == (0, 21)
    with pytest.raises(StartOccupied, match=r"2\.0 m"):
        ends(map_, (0, 0), (0, 21))


def test_robot_may_leave_an_unknown_cell_even_if_not_allowed():
    map_ = grids.costmap("??..", resolution=0.1)
    assert ends(map_, (0, 0), (0, 3), allow_unknown=False).start == (0, 2)
    assert ends(map_, (0, 0), (0, 3), allow_unknown=True).start == (0, 0)


def test_the_search_for_an_escape_can_be_cancelled():
    def stop():
        raise PlanCancelled("enough")

    with pytest.raises(PlanCancelled):
        ends(grids.costmap("iii.", resolution=0.1), (0, 0), (0, 3), check=stop)


@given(grids.cost_arrays(), st.data(), st.floats(0.0, 12.0))
def test_a_blocked_goal_is_replaced_by_the_nearest_free_cell(costs, data, tolerance):
    costs[0, 0] = 0
    map_ = grids.of(costs, 1.0, Pose2D(2.0, -1.0, 0.7))
    goal = data.draw(st.tuples(st.integers(0, costs.shape[0] - 1), st.integers(0, costs.shape[1] - 1)))
    distances = {
        (r, c): math.hypot(r - goal[0], c - goal[1]) for r, c in np.argwhere((costs < 253) | (costs == 255)).tolist()
    }
    nearest = min(distances.values())
    if nearest > tolerance + 1e-6:
        with pytest.raises(GoalOccupied):
            ends(map_, (0, 0), goal, tolerance=tolerance)
    elif nearest < tolerance - 1e-6 or nearest == 0.0:
        found = ends(map_, (0, 0), goal, tolerance=tolerance)
        assert distances[found.goal] == pytest.approx(nearest)
        assert found.goal_pose.theta == 0.5


def test_an_infinite_tolerance_is_allowed():
    assert ends(grids.costmap(".####", 0.1), (0, 0), (0, 4), tolerance=math.inf).goal == (0, 0)


def test_a_goal_in_unknown_space_is_refused_in_words_if_paths_may_not_lead_there():
    map_ = grids.costmap("..??")
    assert ends(map_, (0, 0), (0, 3)).goal == (0, 3)
    with pytest.raises(GoalOccupied, match=r"is in unknown space, .* or set allow_unknown of the planner"):
        ends(map_, (0, 0), (0, 3), allow_unknown=False)
