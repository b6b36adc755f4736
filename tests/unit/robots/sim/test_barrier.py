import numpy as np
import pymunk
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo
from robots.sim.barrier import Barrier, cells_between

INFO = GridInfo(0.05, 60, 40, Pose2D(-1.0, 0.5, 0.3))
PLACES = st.tuples(st.floats(-3.0, 4.0), st.floats(-3.0, 4.0))


@given(st.tuples(PLACES, PLACES))
def test_a_ray_between_two_cells_of_a_line_does_not_exist(
    ends: tuple[tuple[float, float], tuple[float, float]],
) -> None:
    big = GridInfo(0.05, 400, 400, Pose2D(-6.0, -6.0, 0.3))
    cells = {tuple(cell) for cell in np.argwhere(cells_between(big, ends)).tolist()}
    for end in ends:
        assert tuple(big.to_cells(end).tolist()) in cells
    # Rays pass between cells that have but a corner in common: from the first, all others are reached over edges.
    reached, new = set(), {next(iter(cells))}
    while new:
        reached |= new
        near = {(row + up, column + right) for row, column in new for up, right in ((0, 1), (1, 0), (0, -1), (-1, 0))}
        new = (near & cells) - reached
    assert reached == cells


def test_a_line_that_is_partly_outside_of_the_map_has_the_cells_inside() -> None:
    whole = cells_between(INFO, ((-5.0, 1.0), (5.0, 1.0)))
    assert 0 < np.count_nonzero(whole) < 140
    assert not cells_between(INFO, ((50.0, 1.0), (51.0, 1.0))).any()


def test_walls_at_the_ends_stay_when_it_opens() -> None:
    info = GridInfo(0.1, 10, 10)
    occupied = np.zeros((10, 10), bool)
    occupied[:, 0] = True
    space = pymunk.Space()
    barrier = Barrier(space, occupied, info, ((0.05, 0.55), (0.95, 0.55)))
    before = occupied.copy()
    for _ in range(2):
        barrier.close()
    assert occupied[5].all() and np.count_nonzero(occupied) == 19
    assert space.point_query_nearest((0.5, 0.55), 0.0, pymunk.ShapeFilter()) is not None
    for _ in range(2):
        barrier.open()
    assert (occupied == before).all()
    assert space.point_query_nearest((0.5, 0.55), 0.0, pymunk.ShapeFilter()) is None


@pytest.mark.parametrize(("y", "blocked"), [(1.0, True), (1.25, True), (1.35, False), (0.75, True), (0.6, False)])
def test_a_disc_blocks_it_until_it_is_clear_of_the_line(y: float, blocked: bool) -> None:
    info = GridInfo(0.05, 60, 60)
    barrier = Barrier(pymunk.Space(), np.zeros(info.shape, bool), info, ((1.0, 1.0), (2.0, 1.0)))
    assert barrier.is_blocked_by(np.array([(1.5, y)]), 0.2) == blocked
    assert not barrier.is_blocked_by(np.array([(0.5, 1.0), (2.5, 1.0)]), 0.2)
    assert not barrier.is_blocked_by(np.empty((0, 2)), 0.2)
