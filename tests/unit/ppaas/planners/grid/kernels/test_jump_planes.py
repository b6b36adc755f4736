import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from ppaas.planners.grid.jps import JumpMap
from ppaas.planners.grid.kernels import jump_planes
from ppaas.planners.grid.kernels.jump_planes import AHEAD, BACK, FREE, MIXED, SQUARE
from tests.reference.planners import jumps as twin
from tests.support.budget import examples
from tests.support.world import grids

PLANES = {"free": FREE, "mixed": MIXED, "ahead": AHEAD, "back": BACK, "square": SQUARE}


def bits_of(planes, plane, shape):
    """Return a plane as a bool array, without the margin."""
    flags = np.unpackbits(planes[plane].view(np.uint8), axis=1, bitorder="little").astype(bool)
    return flags[1 : shape[0] + 1, 1 : shape[1] + 1]


def assert_planes(costs, allow_unknown=True):
    made = JumpMap(grids.of(costs), allow_unknown=allow_unknown)
    units = np.array([[twin.units_of(int(cost), allow_unknown) for cost in row] for row in costs])
    for planes, map_ in ((made.rows, units), (made.columns, units.T)):
        for name, flags in twin.ends_of_jumps(map_).items():
            assert np.array_equal(bits_of(planes, PLANES[name], map_.shape), flags), name


@given(grids.cost_arrays(), st.booleans())
def test_planes_agree_with_the_twin(costs, allow_unknown):
    assert_planes(costs, allow_unknown)


@given(hnp.arrays(np.uint8, (1, 200), elements=st.sampled_from([0, 0, 0, 254])))
@settings(max_examples=examples(20))
def test_planes_agree_with_the_twin_across_words(row):
    assert_planes(np.vstack((row, np.roll(row, 1), row[:, ::-1])))


@pytest.mark.parametrize("costs", [[0, 254], [0, 0, 0, 0, 9, 200, 253, 255]], ids=["one cost", "graded"])
def test_planes_agree_with_the_twin_on_several_words_and_blocks(costs):
    rng = np.random.default_rng(5)
    assert_planes(rng.choice(np.array(costs, np.uint8), (141, 133)))


def test_cells_beyond_the_map_are_blocked_and_end_a_jump():
    made = JumpMap(grids.of(np.zeros((3, 3), np.uint8)))
    whole = {plane: np.unpackbits(made.rows[plane].view(np.uint8), axis=1, bitorder="little") for plane in range(5)}
    assert whole[FREE].sum() == 9
    assert whole[SQUARE].sum() == 4
    assert whole[AHEAD][:, 4:].all()
    assert whole[BACK][:, 0].all()


def test_warm_compiles_the_kernels():
    jump_planes.warm()
    assert len(jump_planes.mark_jumps.signatures) == 1
