import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from ppaas.planners.grid.jps import JumpMap
from ppaas.planners.grid.kernels import jump_planes
from ppaas.planners.grid.kernels.jump_planes import AHEAD, BACK, FREE, MIXED, SQUARE
from ppaas.planners.grid.kernels.jump_turns import ANY, DOWN, RIGHT, turns
from ppaas.planners.grid.kernels.jump_turns import MIXED as MIXED_TURNS
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


CELLS = [(down, right) for down in (-1, 0, 1) for right in (-1, 0, 1)]


def neighbourhoods(*free):
    """Return all neighbourhoods in which (0, 0) and these cells are free."""
    found = (({cell for bit, cell in enumerate(CELLS) if n >> bit & 1}, n) for n in range(512))
    return [(cells, number) for cells, number in found if {(0, 0), *free} <= cells]


def directions(number):
    return {(DOWN[d], RIGHT[d]) for d in range(8) if number >> d & 1}


def test_neighbours_after_a_straight_move_follow_the_definition():
    for came in range(4):
        parent = (-DOWN[came], -RIGHT[came])
        for free, number in neighbourhoods(parent):
            assert directions(turns()[came, number]) == twin.kept_neighbours(free, parent), (came, free)


def test_neighbours_after_a_diagonal_move_follow_the_definition():
    for came in range(4, 8):
        down, right = DOWN[came], RIGHT[came]
        for free, number in neighbourhoods((-down, -right), (-down, 0), (0, -right)):
            assert directions(turns()[came, number]) == twin.kept_neighbours(free, (-down, -right)), (came, free)


def test_moves_from_the_start_cut_no_corner():
    for free, number in neighbourhoods():
        assert directions(turns()[ANY, number]) == twin.kept_neighbours(free, None)


def test_mixed_cell_keeps_all_moves_of_cheapest_paths():
    """For any weights: the previous cell reaches the cells of the dropped moves at less cost."""
    rng = np.random.default_rng(8)
    for came in range(8):
        parent = (-DOWN[came], -RIGHT[came])
        kept = set()
        for _ in range(300):
            weights = {cell: float(rng.choice([1.0, 1.1, 2.0, 5.0])) for cell in CELLS}
            kept |= twin.kept_by_weights(weights, parent)
        everywhere = 511
        assert directions(turns()[MIXED_TURNS + came, everywhere]) == kept


def test_table_has_one_byte_per_entry():
    assert (turns().shape, turns().dtype) == ((17, 512), np.uint8)
