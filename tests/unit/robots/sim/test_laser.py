import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from robots.sim.laser import Laser, LaserModel, cast_at_discs
from tests.reference.driving import sensors
from tests.support.budget import examples
from tests.support.world.rooms import room

RADIUS = 0.18
EXACT = LaserModel(beams=40, range_max=3.0, sigma=0.0)


def furnished(seed: int) -> GridMap:
    grid = room(6.0, 5.0, 0.1, Pose2D(-1.0, 2.0, 0.4))
    cells = grid.data.copy()
    rng = np.random.default_rng(seed)
    cells[rng.random(cells.shape) < 0.03] = 100
    cells[22:29, 27:34] = 0
    return GridMap(cells, grid.info)


@settings(max_examples=examples(25))
@given(st.integers(0, 10**6), st.floats(-math.pi, math.pi), st.integers(0, 3))
def test_ranges_equal_those_of_the_slow_laser(seed: int, heading: float, others: int) -> None:
    grid = furnished(seed)
    x, y = grid.info.to_world((25, 30)).tolist()
    rng = np.random.default_rng(seed)
    bearing, distance = rng.uniform(-math.pi, math.pi, others), rng.uniform(0.4, 2.5, others)
    centres = np.stack((x + distance * np.cos(bearing), y + distance * np.sin(bearing)), axis=1)
    pose = Pose2D(x, y, heading)
    laser = Laser(grid.data >= 65, grid.info, EXACT, rng)
    ranges = laser.measure(pose, (centres, RADIUS))
    discs = [(cx, cy, RADIUS) for cx, cy in centres.tolist()]
    expected = sensors.measure(grid, pose, EXACT.angles, discs, EXACT.range_max)
    # A beam that only grazes something is seen by one and missed between two steps of the other. The laser is in the
    # centre of a cell, so four beams may run along diagonals, through the corners of cells.
    close = np.isclose(ranges, expected, atol=0.006) | (ranges == expected)
    assert close.mean() >= 0.9
    assert (np.minimum(ranges, 9.0) <= np.minimum(expected, 9.0) + 1e-6).all()


@given(st.floats(0.2, 7.0), st.floats(-math.pi, math.pi), st.floats(-math.pi, math.pi))
def test_the_range_to_a_disc_is_one_radius_less_than_to_its_centre(
    distance: float, heading: float, bearing: float
) -> None:
    origin = Pose2D(3.0, -4.0, heading)
    x, y, _ = origin @ Pose2D(distance * math.cos(bearing), distance * math.sin(bearing))
    [ahead, behind] = cast_at_discs(origin, np.array([bearing, bearing + math.pi]), np.array([[x, y]]), RADIUS)
    assert ahead == pytest.approx(distance - RADIUS)
    assert behind == math.inf


def test_no_beam_hits_a_robot_if_there_is_none() -> None:
    assert (cast_at_discs(Pose2D(0.0, 0.0), EXACT.angles, np.empty((0, 2)), RADIUS) == math.inf).all()


def test_noise_has_the_configured_deviation() -> None:
    grid = room(6.0, 6.0)
    pose = Pose2D(3.0, 3.0, 0.0)
    model = LaserModel(sigma=0.01)
    laser = Laser(grid.data >= 65, grid.info, model, np.random.default_rng(1))
    scans = np.array([laser.measure(pose) for _ in range(200)])
    exact = Laser(grid.data >= 65, grid.info, LaserModel(sigma=0.0), np.random.default_rng(1))
    errors = scans - exact.measure(pose)
    assert errors.std() == pytest.approx(0.01, rel=0.02)
    assert abs(errors.mean()) < 0.0005


def test_ranges_beyond_the_maximum_are_empty_and_beams_start_backwards() -> None:
    grid = room(20.0, 4.0)
    model = LaserModel(beams=4, range_max=5.0, sigma=0.0)
    laser = Laser(grid.data >= 65, grid.info, model, np.random.default_rng(1))
    ranges = laser.measure(Pose2D(3.05, 1.55, 0.0))
    scan = laser.scan(ranges, 12.5, "base_link")
    assert scan.ranges == pytest.approx([3.0, 1.5, None, 2.4])
    assert (scan.angle_min, scan.angle_increment) == pytest.approx((-math.pi, math.pi / 2))
    assert scan.angle_min + 3 * scan.angle_increment == pytest.approx(scan.angle_max)
    assert scan.header.stamp.seconds() == pytest.approx(12.5)


def test_a_narrow_field_of_view_runs_from_right_to_left() -> None:
    model = LaserModel(beams=720, field_of_view=math.radians(270.0))
    assert model.angles[[0, -1]] == pytest.approx((-0.75 * math.pi, 0.75 * math.pi))
    scan = Laser(np.zeros((1, 1), bool), room(2.0, 2.0).info, model, np.random.default_rng(1)).scan(
        np.full(720, math.inf), 0.0, "base_link"
    )
    assert scan.angle_min + 719 * scan.angle_increment == pytest.approx(scan.angle_max)
