"""The particle filter tracks the pose of a moving robot."""

import math

import numpy as np
import pytest

from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidInput, InvalidMap, InvalidParameter
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.particle_filter import ParticleFilter
from ppaas.maps.grid import GridInfo, GridMap
from tests.support.world.planar_world import World, error_of, walled_map

GRID = walled_map(12, 9, [(3, 0, 3.2, 5), (6, 3, 6.2, 9), (8, 2, 9, 3), (9, 6, 10, 6.5), (1, 6.5, 2, 7.2)])
LAYERS = build_layers(GRID)
ROUND = [(1.2, 5.7), (4.5, 6.5), (4.6, 1.5), (7, 1.5), (7.5, 7.5), (10.5, 7.5), (10.5, 4), (7.2, 4.5), (7, 1.5),
         (4.6, 2), (4.2, 6), (1.5, 5.8), (1.2, 1)]  # fmt: skip
START = Pose2D(1.0, 1.0, math.pi / 2)


def search_now(localization: ParticleFilter) -> bool:
    """Search for a lost robot at once; return whether particles were redrawn."""
    search = localization.next_search()
    found = None if search is None else search.run(bool)
    return found is not None and localization.adopt(found)


class Drive:
    """A robot that is steered by its true pose, and localized at the same time."""

    def __init__(self, world: World, parameters: AmclParameters, spread: float = 0.1) -> None:
        self.world = world
        self.parameters = parameters
        self.filter = ParticleFilter(LAYERS, parameters)
        self.filter.initialise(world.pose, np.diag([spread**2] * 3))
        self.map_to_odom = world.pose @ world.odom.inverse()
        self.errors: list[tuple[float, float]] = []
        self.travelled = 0.0

    def update(self) -> None:
        world = self.world
        if self.filter.needs_update(world.odom):
            beams = self.filter.sensor.beams(world.scan(0.0), Pose2D(0, 0, 0))
            estimate = self.filter.update(world.odom, beams, world.range_max)
            self.map_to_odom = estimate.pose @ world.odom.inverse()
            search_now(self.filter)
        self.errors.append(error_of(self.map_to_odom @ world.odom, world.pose))

    def to(self, x: float, y: float) -> None:
        while math.hypot(x - self.world.pose.x, y - self.world.pose.y) > 0.2:
            off = wrap_angle(math.atan2(y - self.world.pose.y, x - self.world.pose.x) - self.world.pose.theta)
            speed = 0.5 if abs(off) < 0.5 else 0.0
            self.world.move(speed, max(-1.5, min(1.5, 3.0 * off)), 0.1)
            self.travelled += 0.1 * speed
            self.update()


@pytest.mark.parametrize("seed", [1, 2])
def test_pose_is_tracked_over_a_long_drive_with_drifting_odometry(seed):
    drive = Drive(World(GRID, START, drift=3.0, seed=seed), AmclParameters(seed=seed))
    for _ in range(2):
        for point in ROUND:
            drive.to(*point)
    errors = np.array(drive.errors)
    unaided = error_of(START @ drive.world.odom, drive.world.pose)[0]
    assert drive.travelled > 50.0
    assert unaided > 1.0, "odometry alone must be lost, or the test is void"
    assert errors[:, 0].max() < 0.15
    assert np.percentile(errors[:, 0], 95) < 0.10
    assert errors[:, 1].max() < 0.15


def test_wrong_initial_pose_is_corrected():
    drive = Drive(World(GRID, START), AmclParameters(), spread=0.3)
    drive.filter.initialise(Pose2D(1.3, 0.8, math.pi / 2 + 0.2), np.diag([0.3**2] * 3))
    for point in ROUND[:3]:
        drive.to(*point)
    assert np.array(drive.errors)[-20:, 0].max() < 0.1


def test_particles_depend_on_the_seed():
    def particles(seed: int) -> np.ndarray:
        drive = Drive(World(GRID, START), AmclParameters(seed=seed))
        drive.to(1.2, 3.0)
        return drive.filter.particles

    first, again, other = particles(7), particles(7), particles(8)
    np.testing.assert_array_equal(first, again)
    assert first.shape != other.shape or (first != other).any()


def test_robot_at_rest_needs_no_update():
    drive = Drive(World(GRID, START), AmclParameters())
    assert drive.filter.needs_update(drive.world.odom)
    drive.update()
    assert not drive.filter.needs_update(drive.world.odom)
    assert drive.filter.needs_update(drive.world.odom @ Pose2D(0.11, 0.0, 0.0))
    assert drive.filter.needs_update(drive.world.odom @ Pose2D(0.0, 0.0, -0.21))


def test_number_of_particles_falls_when_they_agree():
    parameters = AmclParameters(min_particles=100, max_particles=2000)
    drive = Drive(World(GRID, START), parameters, spread=0.5)
    assert len(drive.filter.particles) == 2000
    for point in ROUND[:3]:
        drive.to(*point)
    assert 100 <= len(drive.filter.particles) < 1500


def test_empty_scan_updates_the_pose_by_odometry_only():
    localization = ParticleFilter(LAYERS, AmclParameters())
    localization.initialise(START, np.zeros((3, 3)))
    localization.update(Pose2D(0, 0, 0), np.empty((0, 2)), 8.0)
    estimate = localization.update(Pose2D(1.0, 0, 0), np.empty((0, 2)), 8.0)
    assert error_of(estimate.pose, START @ Pose2D(1.0, 0, 0))[0] < 0.1
    assert np.isfinite(localization.weights).all()


def test_pose_outside_the_map_stays_finite():
    localization = ParticleFilter(LAYERS, AmclParameters())
    localization.initialise(Pose2D(-500.0, 1e6, 0.0), np.zeros((3, 3)))
    estimate = localization.update(Pose2D(0, 0, 0), np.array([[1.0, 0.0]]), 8.0)
    assert estimate.pose.is_finite()


@pytest.mark.parametrize(
    ("pose", "covariance"),
    [
        (Pose2D(math.nan, 0, 0), np.zeros((3, 3))),
        (Pose2D(0, 0, 0), np.full((3, 3), np.inf)),
        (Pose2D(0, 0, 0), np.diag([1.0, -1.0, 0.0])),
    ],
)
def test_invalid_initial_pose_is_refused(pose, covariance):
    localization = ParticleFilter(LAYERS, AmclParameters())
    with pytest.raises(InvalidInput):
        localization.initialise(pose, covariance)


@pytest.mark.parametrize(
    "wrong",
    [
        {"min_particles": 0},
        {"min_particles": 300, "max_particles": 200},
        {"laser_sigma_hit": 0.0},
        {"laser_max_beams": 0},
        {"odom_alpha2": -0.1},
        {"kld_err": math.nan},
        {"initial_cov_aa": math.inf},
        {"laser_min_range": 3.0, "laser_max_range": 2.0},
        {"recovery_alpha_slow": 0.2, "recovery_alpha_fast": 0.1},
    ],
)
def test_parameters_out_of_range_are_refused_by_name(wrong):
    with pytest.raises(InvalidParameter, match=next(iter(wrong))):
        AmclParameters(**wrong)


@pytest.mark.parametrize("model", ["beam", "likelihood_field_prob"])
def test_every_laser_model_tracks_the_pose(model):
    drive = Drive(World(GRID, START, drift=2.0), AmclParameters(laser_model_type=model))
    for point in ROUND[:4]:
        drive.to(*point)
    assert np.array(drive.errors)[:, 0].max() < 0.2


@pytest.mark.parametrize("model", ["diff", "omni", "omni-corrected"])
def test_every_odometry_model_tracks_the_pose(model):
    noise = 0.2 if model in ("diff", "omni") else 0.02
    alphas = {f"odom_alpha{number}": noise for number in range(1, 6)}
    drive = Drive(World(GRID, START), AmclParameters(odom_model_type=model, **alphas))
    for point in ROUND[:4]:
        drive.to(*point)
    assert np.array(drive.errors)[:, 0].max() < 0.2


@pytest.mark.parametrize("model", ["likelihood_field", "beam"])
def test_particles_do_not_depend_on_threads(model):
    def particles(threads: int) -> np.ndarray:
        parameters = AmclParameters(laser_model_type=model, min_particles=9000, max_particles=9000, resample_interval=1)
        localization = ParticleFilter(LAYERS, parameters, lambda: threads)
        localization.initialise(START, np.diag([0.1, 0.1, 0.1]))
        scan = World(GRID, START).scan(0.0)
        for x in (0.0, 0.2):
            localization.update(Pose2D(x, 0, 0), localization.sensor.beams(scan, Pose2D(0, 0, 0)), 8.0)
        return localization.particles

    np.testing.assert_array_equal(particles(1), particles(2))


def test_displaced_robot_is_relocalized_unless_recovery_is_off():
    def error_after(**recovery: float) -> float:
        drive = Drive(World(GRID, START), AmclParameters(**recovery))
        for point in ROUND[:1]:
            drive.to(*point)
        drive.world.pose = Pose2D(10.5, 5.0, -2.0)
        for point in [(10.5, 4.0), (7.2, 4.5), (7, 1.5), (4.6, 2)]:
            drive.to(*point)
        return drive.errors[-1][0]

    assert error_after() < 0.15
    assert error_after(recovery_alpha_slow=0.0, recovery_alpha_fast=0.0) > 0.5


def test_ranges_outside_the_laser_limits_are_dropped():
    sensor = ParticleFilter(
        LAYERS, AmclParameters(laser_min_range=1.5, laser_max_range=3.0, laser_max_beams=500)
    ).sensor
    scan = World(GRID, START).scan(0.0)
    gone = np.hypot(*sensor.beams(scan, Pose2D(0, 0, 0)).T)
    assert 1.5 < gone.min() < gone.max() < 3.0
    assert sensor.range_max(scan) == 3.0


def test_map_without_a_free_cell_is_refused():
    grid = GridMap(np.full((1, 1), 100, np.int8), GridInfo(0.05, 1, 1))
    with pytest.raises(InvalidMap, match="no free cell"):
        ParticleFilter(build_layers(grid), AmclParameters()).initialise_globally()


def lost() -> tuple[ParticleFilter, World, np.ndarray]:
    """Return a filter with particles all over the map, after one scan."""
    localization, world = ParticleFilter(LAYERS, AmclParameters()), World(GRID, START)
    localization.initialise_globally()
    beams = localization.sensor.beams(world.scan(0.0), Pose2D(0, 0, 0))
    localization.update(world.odom, beams, world.range_max)
    return localization, world, beams


def test_search_result_is_moved_by_odometry_since_the_search():
    localization, world, _ = lost()
    found = localization.next_search().run(bool)
    for _ in range(3):
        world.move(0.5, 0.0, 0.4)
        localization.update(world.odom, np.empty((0, 2)), world.range_max)
    assert localization.adopt(found)
    nearest = np.hypot(*(localization.particles[:, :2] - (world.pose.x, world.pose.y)).T).min()
    assert nearest < 0.1


@pytest.mark.parametrize("begin", ["pose", "anywhere"])
def test_search_result_from_before_a_restart_is_discarded(begin):
    localization, world, beams = lost()
    found = localization.next_search().run(bool)
    if begin == "pose":
        localization.initialise(START, np.zeros((3, 3)))
    else:
        localization.initialise_globally()
    localization.update(world.odom, beams, world.range_max)
    before = localization.particles.copy()
    assert not localization.adopt(found)
    np.testing.assert_array_equal(localization.particles, before)


def test_robot_at_rest_is_searched_for_once():
    localization, world, beams = lost()
    assert search_now(localization)
    localization.update(world.odom, beams, world.range_max)
    assert localization.next_search() is None


def settled_filter() -> tuple[ParticleFilter, Pose2D]:
    """Return a filter after one update at `START`, and the odometry at that time."""
    made, odom = ParticleFilter(LAYERS, AmclParameters()), Pose2D(5.0, -2.0, 1.0)
    made.initialise(START, np.diag([0.1**2] * 3))
    made.update(odom, made.sensor.beams(World(GRID, START).scan(0.0), Pose2D(0, 0, 0)), 8.0)
    return made, odom


def test_expected_pose_is_the_estimate_moved_by_odometry() -> None:
    made, odom = settled_filter()
    motion = Pose2D(0.05, 0.01, 0.1)
    assert error_of(made.expected(odom @ motion).pose, made.estimate.pose @ motion) == pytest.approx((0.0, 0.0))


def test_corrected_particles_have_the_pose_at_the_given_odometry() -> None:
    made, odom = settled_filter()
    spread, published = made.particles.std(axis=0), made.particles.copy()
    held = made.particles
    now, pose = odom @ Pose2D(0.0, 0.0, 0.15), Pose2D(1.05, 0.98, math.pi - 0.001)
    made.correct(now, pose)
    assert error_of(made.expected(now).pose, pose) == pytest.approx((0.0, 0.0), abs=1e-9)
    assert made.particles[:, 2].min() >= -math.pi and made.particles[:, 2].max() < math.pi
    np.testing.assert_allclose(made.particles.std(axis=0)[:2], spread[:2])
    np.testing.assert_array_equal(held, published, err_msg="particles that were published do not change")


def test_headings_are_spread_by_noise() -> None:
    made, _ = settled_filter()
    before = made.particles
    made.spread_heading(0.001)
    assert made.particles is before
    made.spread_heading(0.3)
    np.testing.assert_array_equal(made.particles[:, :2], before[:, :2])
    assert (made.particles[:, 2] - before[:, 2]).std() == pytest.approx(0.3, rel=0.1)
