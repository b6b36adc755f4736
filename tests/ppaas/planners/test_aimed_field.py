import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.planners import aimed_field as module
from ppaas.planners.aimed_field import AimedField
from ppaas.planners.kernels.aiming import estimate
from ppaas.planners.weights import fixed_weights
from tests.reference import dijkstra as twin
from tests.support import grids


@st.composite
def scenes(draw):
    """Draw costs and two free cells."""
    costs = draw(grids.cost_arrays())
    free = [cell for cell in np.ndindex(costs.shape) if costs[cell] < 253]
    if not free:
        costs[0, 0] = 0
        free = [(0, 0)]
    return costs, draw(st.sampled_from(free)), draw(st.sampled_from(free))


@given(scenes())
@settings(deadline=None)
def test_the_value_of_the_target_is_the_twins_in_fixed_point(scene):
    costs, goal, target = scene
    field = AimedField(grids.of(costs), goal, target)
    expected = twin.fixed_field(costs, [goal])[target[0]][target[1]]
    assert field.grow() == (expected >= 0)
    if expected >= 0:
        assert round(field.values()[target] * 85) == expected


@given(scenes())
@settings(deadline=None)
def test_slices_of_one_cell_and_a_heap_for_one_move_give_the_same(scene):
    costs, goal, target = scene
    whole = AimedField(grids.of(costs), goal, target)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "SLICE_CELLS", 1)
        patch.setattr(module, "FIRST_ROOM", 1)
        sliced = AimedField(grids.of(costs), goal, target)
        assert sliced.grow() == whole.grow()
    assert sliced.settled == whole.settled
    assert np.array_equal(sliced.values(), whole.values())


@given(scenes())
@settings(deadline=None)
def test_a_field_that_outgrows_32_bits_carries_on_in_64(scene):
    costs, goal, target = scene
    narrow, widened = (AimedField(grids.of(costs), goal, target) for _ in range(2))
    widened._limit = (1 << 15) + 20_000
    assert narrow.grow() == widened.grow()
    assert np.array_equal(narrow.values(), widened.values())
    if narrow.settled > 100:
        assert widened._field.dtype == np.int64


COSTS = st.integers(0, 255).filter(lambda cost: cost != 254)  # which is never entered


@given(st.integers(0, 40), st.integers(0, 40), st.integers(0, 40), st.integers(0, 40), COSTS)
def test_no_move_lowers_value_and_estimate_together(row, column, down, right, cost):
    """The estimate is consistent: a move weighs at least what it brings one nearer."""
    stride, (cardinal, diagonal) = 50, fixed_weights()[:, 0].tolist()
    target = (down + 1) * stride + right + 1
    here = (row + 1) * stride + column + 1
    for dr, dc in twin.MOVES:
        weight = int(fixed_weights()[1 if dr and dc else 0, cost])
        nearer = estimate(here, target, stride, cardinal, diagonal) - estimate(
            here + dr * stride + dc, target, stride, cardinal, diagonal
        )
        assert nearer <= weight
