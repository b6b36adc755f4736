import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.navigation.barn.environment import Environment, box_clearance
from benchmarks.navigation.barn.jackal import NOISE
from benchmarks.navigation.barn.worlds import START, read_worlds
from ppaas.errors import InvalidInput, NotFound
from ppaas.geometry import Pose2D
from ppaas.messages.geometry_msgs import Twist, Vector3
from tests.support.world import barn

AHEAD = Twist(Vector3(x=2.0))


def course(noise: str = "none", seed: int = 1, start: Pose2D = START) -> Environment:
    return Environment(barn.world(), NOISE[noise], np.random.default_rng(seed), start)


def go(where: Environment, seconds: float, twist: Twist = AHEAD) -> None:
    where.command(twist)
    for _ in range(round(seconds / 0.01)):
        where.step()


def test_odometry_and_laser_are_exact_without_noise() -> None:
    where = course()
    go(where, 0.5)
    measured = START @ where.odometry().pose.pose.planar()
    assert measured.distance_to(where.pose) <= 2.0 * 0.01 + 1e-9, "at most the distance of one step"
    scan = where.scan()
    assert len(scan.ranges) == 720
    assert scan.ranges[360] == pytest.approx(6.0 - 0.075 - where.pose.y, abs=0.01)
    assert scan.angle_max == pytest.approx(math.radians(135.0))


@pytest.mark.parametrize("noise", ["nominal", "hard"])
def test_noise_delays_commands_and_makes_odometry_drift(noise: str) -> None:
    where = course(noise)
    go(where, NOISE[noise].drive.delay)
    assert where.pose.distance_to(START) == 0.0
    go(where, 1.0)
    assert 0.5 < where.pose.distance_to(START) < 2.0
    assert 0.0 < (START @ where.odometry().pose.pose.planar()).distance_to(where.pose) < 0.3


def test_the_laser_noise_has_the_stated_deviation() -> None:
    exact = np.array(course("none").scan().ranges, np.float64)
    for noise, sigma in (("nominal", 0.01), ("hard", 0.02)):
        errors = np.array(course(noise).scan().ranges, np.float64) - exact
        assert np.nanstd(errors) == pytest.approx(sigma, rel=0.15)


def test_runs_differ_only_by_the_seed() -> None:
    runs = []
    for seed in (1, 1, 2):
        where = course("hard", seed)
        go(where, 0.6)
        runs.append((where.pose, where.odometry(), where.scan().ranges))
    assert runs[0] == runs[1] != runs[2]


def test_clearance_is_measured_from_the_outline_and_contact_stops() -> None:
    beside = course(start=Pose2D(-4.425 + 0.075 + 0.215 + 0.1, 3.0, math.pi / 2))
    assert beside.clearance() == pytest.approx(0.1, abs=0.01)
    where = course()
    go(where, 3.0)
    assert where.clearance() <= 0.0
    assert where.pose.y < 6.0


@given(st.integers(0, 10_000), st.floats(-3.2, 3.2))
def test_box_clearance_equals_that_of_its_nearest_point(seed: int, theta: float) -> None:
    rng = np.random.default_rng(seed)
    centres, radius = rng.uniform(-1.5, 1.5, (4, 2)), 0.1
    got = box_clearance(Pose2D(0.1, -0.2, theta), 0.254, 0.215, centres, radius)
    across, up = np.meshgrid(np.linspace(-0.254, 0.254, 150), np.linspace(-0.215, 0.215, 150))
    x = 0.1 + math.cos(theta) * across - math.sin(theta) * up
    y = -0.2 + math.sin(theta) * across + math.cos(theta) * up
    measured = min(float(np.hypot(x - cx, y - cy).min()) for cx, cy in centres.tolist()) - radius
    if measured > -radius + 0.005:
        assert got == pytest.approx(measured, abs=0.004)
    else:
        assert got <= -radius + 0.005


def test_clearance_decreases_with_the_depth_of_a_disc_in_the_box() -> None:
    depths = [box_clearance(Pose2D(0.0, 0.0), 0.5, 0.3, np.array([[0.0, y]]), 0.1) for y in (0.5, 0.35, 0.3, 0.1)]
    assert depths == pytest.approx([0.1, -0.05, -0.1, -0.3])


def test_worlds_are_read_with_their_own_or_another_radius(tmp_path: Path) -> None:
    path = barn.write(tmp_path / "worlds.json", barn.world(3), barn.world(9))
    assert [each.world for each in read_worlds(path)] == [3, 9]
    [one] = read_worlds(path, (9,), 0.115)
    assert (one.world, one.radius) == (9, 0.115)
    assert one.centres.shape == (len(one.cylinders), 2)
    assert one.best_time == pytest.approx(5.1)


def test_an_unknown_world_is_named(tmp_path: Path) -> None:
    with pytest.raises(NotFound, match="world '4'; known: 3"):
        read_worlds(barn.write(tmp_path / "worlds.json", barn.world(3)), (4,))


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        '[{"world": 1}]',
        '[{"world": 1, "radius": 0.1, "cylinders": [[1.0]], "path_length": 1.0}]',
        '[{"world": 1, "radius": 0.0, "cylinders": [], "path_length": 1.0}]',
        '[{"world": 1, "radius": 0.1, "cylinders": [[1.0, 1e999]], "path_length": 1.0}]',
        '[{"world": 1, "radius": 0.1, "cylinders": [], "path_length": -1.0}]',
    ],
)
def test_an_invalid_file_of_worlds_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "worlds.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InvalidInput):
        read_worlds(path)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=r"worlds\.json"):
        read_worlds(tmp_path / "worlds.json")
