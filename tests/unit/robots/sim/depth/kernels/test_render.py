import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from robots.sim.depth.camera import DepthCamera, DepthCameraModel, Scene
from robots.sim.depth.kernels import render
from robots.sim.depth.shapes import Shapes, box, capsule, ellipsoid, shapes_of
from tests.reference.driving import depth as slow
from tests.support.budget import examples
from tests.support.world.rooms import room

GRID = room(6.0, 5.0, 0.1, Pose2D(-1.0, 2.0, 0.4))


def random_shapes(rng: np.random.Generator, at: Pose2D) -> Shapes:
    """Return shapes of all kinds ahead of a pose."""

    def somewhere() -> tuple[float, float, float]:
        return float(rng.uniform(0.5, 3.0)), float(rng.uniform(-1.0, 1.0)), float(rng.uniform(0.0, 1.8))

    def size() -> tuple[float, float, float]:
        a, b, c = rng.uniform(0.05, 0.4, 3).tolist()
        return a, b, c

    capsules = [capsule(somewhere(), somewhere(), float(rng.uniform(0.05, 0.2))) for _ in range(2)]
    yaw, pitch = rng.uniform(-3.0, 3.0, 2).tolist()
    return shapes_of(
        capsules, [ellipsoid(somewhere(), size(), yaw, pitch), box(somewhere(), size(), pitch, yaw)]
    ).placed(at)


@settings(max_examples=examples(6), deadline=None)
@given(st.integers(0, 10**6), st.floats(-math.pi, math.pi), st.sampled_from([0.0, 0.3, -0.2]))
def test_depths_equal_those_of_the_slow_camera(seed: int, heading: float, pitch: float) -> None:
    rng = np.random.default_rng(seed)
    x, y = GRID.info.to_world((25, 30)).tolist()
    pose = Pose2D(x, y, heading)
    model = DepthCameraModel(width=20, height=15, x=0.1, y=-0.05, z=0.9, pitch=pitch, range_max=4.0)
    shapes = random_shapes(rng, pose)
    eye = pose @ Pose2D(model.x, model.y)
    if slow.inside(shapes, np.array([[eye.x, eye.y, model.z]]))[0]:
        return
    camera = DepthCamera(GRID.data >= 65, GRID.info, model, rng)
    inverse = camera.inverse_depths(pose, Scene(shapes, wall_height=1.6))
    with np.errstate(divide="ignore"):
        depths = np.where(1.0 / inverse <= model.range_max, 1.0 / inverse, np.inf)
    expected = slow.depths(GRID, pose, model, shapes, 1.6)
    # A ray that only grazes something is seen by one and missed between two steps of the other.
    # With pitch, the directions of walls are rounded to an eighth of a pixel, which is coarse in this image.
    within = 0.01 if pitch == 0.0 else 0.04
    close = (depths == expected) | (np.abs(np.minimum(depths, 9.0) - np.minimum(expected, 9.0)) < within)
    assert close.mean() >= 0.97


@given(st.integers(0, 10**6), st.floats(0.0, 1.0))
def test_shadows_equal_those_found_by_pairs(seed: int, slack: float) -> None:
    rng = np.random.default_rng(seed)
    inverse = np.repeat(rng.choice([0.0, 0.2, 0.5, 1.0], (3, 12)), 3, axis=1)
    steps = np.ones(2000, np.uint16)
    image = np.empty(inverse.shape, np.uint16)
    render.measure(inverse, 4.0, slack, np.zeros(36, np.float32), np.zeros(3, np.int64), 350.0, steps, image)
    assert ((image > 0) == (slow.lit(inverse, 4.0, slack) & (inverse > 0.0))).all()


def test_a_shape_behind_the_camera_or_beside_the_image_is_not_drawn() -> None:
    slopes = np.linspace(-0.5, 0.5, 11)
    inverse = np.zeros((11, 11))
    for start in ((0.0, 0.0, -2.0), (3.0, 0.0, 2.0), (0.0, -3.0, 2.0)):
        render.draw_capsules(slopes, slopes, np.array([(*start, *start, 0.3)]), inverse)
    assert not inverse.any()
