import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from ppaas.errors import GoalOccupied, GoalOutsideMap, InvalidInput, PlanCancelled, StartOccupied, StartOutsideMap
from ppaas.geometry import Pose2D
from ppaas.planners import PlanRequest, create
from ppaas.planners.batch import cost_matrix as module
from ppaas.planners.batch.cost_matrix import cost_matrix
from ppaas.planners.field.start_field import StartField
from ppaas.planners.weights import RELATIVE_ERROR
from tests.reference.planners import dijkstra as twin
from tests.support.world import grids


@st.composite
def scenes(draw):
    costs, allow_unknown = draw(grids.cost_arrays(9)), draw(st.booleans())
    free = [cell for cell in np.ndindex(costs.shape) if math.isfinite(twin.weight(int(costs[cell]), allow_unknown))]
    assume(free)
    cells = st.lists(st.sampled_from(free), min_size=1, max_size=6)
    return costs, draw(cells), draw(cells), allow_unknown


def centres(map_, cells):
    return map_.info.to_world(np.array(cells))


def by_the_twin(costs, starts, goals, allow_unknown):
    fields = [twin.cost_field(costs, [goal], allow_unknown) for goal in goals]
    return np.array([[field[start] for field in fields] for start in starts])


@given(scenes(), st.sampled_from([0, 1, 1000]), st.integers(1, 3))
def test_matrix_agrees_with_the_twin_for_any_field_and_threads(scene, start_field_takes, threads):
    costs, starts, goals, allow_unknown = scene
    map_ = grids.of(costs)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "START_FIELD_TAKES", start_field_takes)
        matrix = cost_matrix(
            map_, centres(map_, starts), centres(map_, goals), threads=threads, allow_unknown=allow_unknown
        )
    np.testing.assert_allclose(matrix, by_the_twin(costs, starts, goals, allow_unknown), rtol=2 * RELATIVE_ERROR)


@given(scenes())
def test_start_field_agrees_with_the_twin(scene):
    costs, starts, goals, allow_unknown = scene
    values = StartField(grids.of(costs), starts[0], allow_unknown=allow_unknown).grow(np.array(goals))
    np.testing.assert_allclose(values, by_the_twin(costs, starts[:1], goals, allow_unknown)[0], rtol=1e-12)


def test_start_field_on_a_large_map_grows_its_list_and_pauses():
    costs = np.random.default_rng(4).integers(0, 253, (700, 900)).astype(np.uint8)
    calls = itertools.count()
    field = StartField(grids.of(costs), (0, 0), check=lambda: next(calls))
    far = field.grow(np.array([(699, 899)]))
    assert far[0] == pytest.approx(
        create("dijkstra").plan(grids.of(costs), request((0, 0), (699, 899))).cost, rel=2 * RELATIVE_ERROR
    )
    assert next(calls) > 10


def request(start, goal):
    return PlanRequest(*(Pose2D(column + 0.5, row + 0.5) for row, column in (start, goal)))


@pytest.mark.parametrize(("starts", "goals"), [(2, 40), (40, 2)])
def test_the_matrix_equals_the_costs_of_plans_also_from_inflated_cells(starts, goals):
    rng = np.random.default_rng(5)
    costs = rng.choice(np.array([0, 90, 200, 253, 254], np.uint8), (40, 40), p=[0.4, 0.2, 0.2, 0.1, 0.1])
    map_, planner = grids.of(costs, 0.5, Pose2D(3.0, -4.0, 0.6)), create("dijkstra")
    stands = np.argwhere(costs == 253)[:starts]
    aims = rng.permutation(np.argwhere(costs < 253))[:goals]
    matrix = cost_matrix(map_, centres(map_, stands), centres(map_, aims), threads=2)
    for (i, stand), (j, aim) in itertools.product(enumerate(stands), enumerate(aims)):
        if math.isfinite(matrix[i, j]):
            ends = grids.centre(map_, *stand), grids.centre(map_, *aim)
            assert matrix[i, j] == pytest.approx(planner.plan(map_, PlanRequest(*ends)).cost, rel=2 * RELATIVE_ERROR)
    assert np.isfinite(matrix).any()


def test_fields_are_grown_from_the_fewer_of_starts_and_goals():
    map_, reported = grids.of(np.zeros((30, 30), np.uint8)), []
    many, few = centres(map_, np.argwhere(map_.data == 0)[::40]), [(0.5, 0.5), (7.2, 3.1)]
    there = cost_matrix(map_, few, many, progress=lambda done, total: reported.append((done, total)))
    back = cost_matrix(map_, many, few, progress=lambda done, total: reported.append((done, total)))
    assert reported == [(1, 2), (2, 2)] * 2
    np.testing.assert_allclose(there, back.T, rtol=2 * RELATIVE_ERROR)


def test_without_starts_or_goals_the_matrix_is_empty():
    map_ = grids.costmap("...")
    assert cost_matrix(map_, [], [(0.5, 0.5)]).shape == (0, 1)
    assert cost_matrix(map_, [(0.5, 0.5), (1.5, 0.5)], np.empty((0, 2))).shape == (2, 0)


@pytest.mark.parametrize(
    ("starts", "goals", "error"),
    [
        ([(0.5, 0.5)], [(9.0, 0.5)], GoalOutsideMap),
        ([(-1.0, 0.5)], [(0.5, 0.5)], StartOutsideMap),
        ([(0.5, 0.5)], [(0.5, 0.5), (2.5, 0.5)], GoalOccupied),
        ([(0.5, 0.5), (2.5, 0.5)], [(0.5, 0.5)], StartOccupied),
        ([(0.5, math.nan)], [(0.5, 0.5)], InvalidInput),
        ([0.5, 0.5], [(0.5, 0.5)], InvalidInput),
        ([(0.5, 0.5), (0.5,)], [(0.5, 0.5)], InvalidInput),
        ([(0.5, 0.5, 0.0, 1.0)], [(0.5, 0.5)], InvalidInput),
    ],
)
def test_invalid_ends_are_refused(starts, goals, error):
    with pytest.raises(error):
        cost_matrix(grids.costmap("..#."), starts, goals)


def test_zero_threads_are_refused():
    with pytest.raises(InvalidInput, match="threads must be at least 1"):
        cost_matrix(grids.costmap("."), [(0.5, 0.5)], [(0.5, 0.5)], threads=0)


@pytest.mark.parametrize("threads", [1, 2])
def test_an_error_of_the_check_ends_the_work(threads):
    calls = itertools.count()

    def check():
        if next(calls) > 30:
            raise PlanCancelled("enough")

    map_ = grids.of(np.random.default_rng(6).integers(0, 200, (300, 300)).astype(np.uint8))
    ends = np.random.default_rng(7).uniform(1.0, 299.0, (100, 2))
    with pytest.raises(PlanCancelled, match="enough"):
        cost_matrix(map_, ends, ends, threads=threads, check=check)
