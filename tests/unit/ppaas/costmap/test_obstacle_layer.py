"""Marking and clearing of cells by a laser."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from ppaas.cost_values import FREE_SPACE, LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.costmap.kernels import obstacle as kernels
from ppaas.costmap.obstacle_layer import LaserReading, ObstacleLayer
from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.sensor_msgs import LaserScan
from tests.reference.maps import maps as twin
from tests.support.world.maps import poses, sides

HAIR = 1e-5
WINDOWS = hnp.arrays(np.uint8, sides(12), elements=st.sampled_from([FREE_SPACE, LETHAL_OBSTACLE, NO_INFORMATION]))
REACHES = st.one_of(st.floats(0.0, 15.0), st.sampled_from([math.inf, math.nan, -1.0, -math.inf]))
BEAMS = st.lists(st.tuples(st.floats(-4.0, 4.0), REACHES), max_size=6)


@given(WINDOWS, poses(14.0), BEAMS, st.floats(0.0, 15.0), st.floats(0.0, 15.0))
def test_clearing_and_marking_agree_with_the_twin(before, laser, beams, obstacle_range, raytrace_range):
    """If a beam only grazes a corner of a cell, both results are correct."""
    angles = np.array([angle for angle, _ in beams]) + laser.theta
    ranges = np.array([reach for _, reach in beams], dtype=np.float64)
    cells = before.copy()
    kernels.mark_and_clear(cells, laser.x, laser.y, angles, ranges, obstacle_range, raytrace_range)

    must, may, marked = (np.zeros(cells.shape, np.bool_) for _ in range(3))
    for angle, reach in zip(angles.tolist(), ranges.tolist(), strict=True):
        ray = Pose2D(laser.x, laser.y, angle)
        must |= twin.crossed(cells.shape, ray, reach, raytrace_range, -HAIR)
        may |= twin.crossed(cells.shape, ray, reach, raytrace_range, HAIR)
        end = twin.ended_in(cells.shape, ray, reach)
        if end is not None and reach <= obstacle_range:
            marked[end] = True
    assert (cells[marked] == LETHAL_OBSTACLE).all()
    assert (cells[must & ~marked] == FREE_SPACE).all()
    untouched = ~may & ~marked
    assert np.array_equal(cells[untouched], before[untouched])


def layer(**parameters) -> ObstacleLayer:
    """Return a window of 1 × 10 m with cells of 0.1 m."""
    return ObstacleLayer(10, 100, 0.1, **parameters)


def see(window: ObstacleLayer, distance: float) -> str:
    """Apply a beam along the middle of the window from its left end; return the middle row in words."""
    window.see(Pose2D(0.05, 0.55), LaserReading(Pose2D(0.0, 0.0), np.zeros(1), np.array([distance])))
    signs = {FREE_SPACE: ".", LETHAL_OBSTACLE: "#", NO_INFORMATION: "?"}
    return "".join(signs[int(cell)] for cell in window.cells[5])


def test_hit_is_marked_and_cells_before_it_are_cleared():
    assert see(layer(), 1.0) == "." * 10 + "#" + "?" * 89


def test_hit_on_the_edge_of_a_cell_marks_the_cell_behind():
    assert see(layer(), 0.95).index("#") == 10


def test_a_hit_beyond_the_obstacle_range_clears_but_does_not_mark():
    assert see(layer(), 2.8) == "." * 28 + "?" * 72


def test_a_hit_beyond_the_raytrace_range_clears_up_to_it():
    assert see(layer(), 8.0) == "." * 31 + "?" * 69


def test_infinite_beam_clears_up_to_the_raytrace_range():
    assert see(layer(), math.inf) == "." * 31 + "?" * 69


def test_infinite_beam_is_ignored_if_infinity_is_not_valid():
    assert see(layer(inf_is_valid=False), math.inf) == "?" * 100


@pytest.mark.parametrize("reading", [math.nan, -math.inf, 0.0, -1.0])
def test_invalid_reading_changes_nothing(reading):
    assert see(layer(), reading) == "?" * 100


def test_strided_single_precision_scan_is_accepted():
    window = layer()
    reading = LaserReading(Pose2D(0.0, 0.0), np.zeros(4, np.float32)[::2], np.ones(4, np.float32)[::2])
    window.see(Pose2D(0.05, 0.55), reading)
    assert window.marked.sum() == 1


def test_mark_persists_until_a_beam_passes_through():
    window = layer()
    see(window, 1.0)
    assert see(window, 0.5)[10] == "#"
    assert see(window, 2.0)[10] == "."


def test_marks_move_with_the_map_and_are_forgotten_outside():
    window = layer()
    see(window, 1.0)
    window.move_to(2, 4)
    assert window.cells[3, 6] == LETHAL_OBSTACLE
    assert window.marked.sum() == 1
    assert (window.cells[-2:] == NO_INFORMATION).all()
    window.move_to(0, 0)
    assert window.cells[5, 10] == LETHAL_OBSTACLE
    assert (window.cells[5, :4] == NO_INFORMATION).all()
    window.move_to(0, 11)
    window.move_to(0, 0)
    assert not window.marked.any()


@given(*[st.integers(-15, 15)] * 4)
def test_rolling_keeps_the_cells_common_to_both_windows(row, column, row_after, column_after):
    window = ObstacleLayer(7, 9, 0.1)
    window.move_to(row, column)
    world = np.full((60, 60), NO_INFORMATION, np.uint8)
    window.cells[:] = np.arange(63).reshape(7, 9)
    world[row + 20 : row + 27, column + 20 : column + 29] = window.cells
    window.move_to(row_after, column_after)
    expected = world[row_after + 20 : row_after + 27, column_after + 20 : column_after + 29]
    assert np.array_equal(window.cells, expected)


def test_robot_clears_the_cells_of_its_footprint():
    window = layer()
    see(window, 1.0)
    window.clear_footprint(Pose2D(1.05, 0.55), 0.2)
    assert window.cells[5, 8:13].tolist() == [FREE_SPACE] * 5
    assert not window.marked.any()


def test_clear_removes_all_cells():
    window = layer()
    see(window, 1.0)
    window.clear()
    assert not window.seen.any()


def test_scan_ranges_are_read_within_their_limits():
    scan = LaserScan(Header(), -1.0, 1.0, 0.5, 0.1, 3.5, [0.05, None, 2.0, 3.5, 9.0])
    reading = LaserReading.of(scan, Pose2D(1.0, 2.0))
    assert reading.angles.tolist() == [-1.0, -0.5, 0.0, 0.5, 1.0]
    np.testing.assert_array_equal(reading.ranges, [math.nan, math.nan, 2.0, math.inf, math.inf])


@pytest.mark.parametrize(("range_min", "nearest"), [(0.0, 0.0), (0.0, -1.0), (0.05, 0.05), (-1.0, 0.0)])
def test_range_of_0_or_range_min_is_no_reading(range_min, nearest):
    """Drivers say 0 where there is no echo, also those whose ``range_min`` is 0; others clip to ``range_min``."""
    scan = LaserScan(Header(), 0.0, 0.1, 0.1, range_min, 8.0, [nearest, 2.0])
    np.testing.assert_array_equal(LaserReading.of(scan, Pose2D(0.0, 0.0)).ranges, [math.nan, 2.0])


@pytest.mark.parametrize(
    ("origin", "angles", "ranges"),
    [
        (Pose2D(math.nan, 0.0), np.zeros(1), np.ones(1)),
        (Pose2D(0.0, 0.0), np.array([math.inf]), np.ones(1)),
        (Pose2D(0.0, 0.0), np.zeros(2), np.ones(1)),
        (Pose2D(0.0, 0.0), np.zeros((1, 1)), np.ones((1, 1))),
    ],
)
def test_an_invalid_scan_is_refused(origin, angles, ranges):
    with pytest.raises(InvalidInput, match="angle"):
        LaserReading(origin, angles, ranges)


@pytest.mark.parametrize("name", ["obstacle_range", "raytrace_range"])
@pytest.mark.parametrize("value", [-1.0, math.inf, math.nan])
def test_parameter_out_of_range_is_refused_by_name(name, value):
    with pytest.raises(InvalidParameter, match=name):
        layer(**{name: value})


def test_warm_calls_the_kernel():
    kernels.warm()
    assert kernels.mark_and_clear.nopython_signatures
