import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D
from robots.sim.bodies.furniture import mirror
from robots.sim.depth.camera import ERROR, RESOLUTION, DepthCamera, DepthCameraModel, DepthImage, Scene
from robots.sim.depth.kernels import render
from robots.sim.depth.shapes import Shapes, box, capsule, ellipsoid, shapes_of
from tests.reference.driving import sensors
from tests.support.budget import examples
from tests.support.world.rooms import room

GRID = room(12.0, 10.0)
SMALL = DepthCameraModel(width=160, height=120)
HERE = Pose2D(1.0, 5.0, 0.0)


def camera(model: DepthCameraModel = SMALL, seed: int = 0) -> DepthCamera:
    return DepthCamera(GRID.data >= 65, GRID.info, model, np.random.default_rng(seed))


def board(distance: float, half: float = 3.0) -> Scene:
    """Return a board across the view at a distance from `HERE`."""
    return Scene(shapes_of([], [box((HERE.x + distance + 0.05, HERE.y, 1.0), (0.05, half, half))]))


@pytest.mark.parametrize("distance", [1.0, 3.0, 6.0])
def test_the_error_and_the_steps_of_depths_grow_with_their_square(distance: float) -> None:
    # The floor is below the horizon.
    image = camera().measure(HERE, board(distance))[:60] / 1000.0
    errors = image[image > 0.0] - distance
    assert errors.std() == pytest.approx(ERROR * distance**2, rel=0.08, abs=3e-4)
    assert abs(errors.mean()) < 0.1 * ERROR * distance**2 + 5e-4
    depths = np.unique(image[image > 0.0])
    assert np.diff(depths).min() == pytest.approx(RESOLUTION * distance**2, rel=0.2, abs=1e-3)


def test_depths_out_of_range_have_no_reading() -> None:
    near, far = camera().measure(HERE, board(0.4)), camera().measure(HERE, Scene())
    assert not near.any()
    # The wall at 11 m is out of range, while the floor before it is in range.
    assert not far[:60, 75:85].any()
    assert far[-1].all()


def test_the_background_beside_a_near_object_is_in_shadow_on_its_left() -> None:
    model = DepthCameraModel(width=640, height=20)
    back = box((HERE.x + 4.05, HERE.y, 1.0), (0.05, 4.0, 4.0))
    front = box((HERE.x + 1.05, HERE.y, 1.0), (0.05, 0.2, 1.0))
    row = camera(model).measure(HERE, Scene(shapes_of([], [back, front])))[10]
    empty = np.flatnonzero(row == 0)
    edge = np.flatnonzero((row > 0) & (row < 1500))[0]
    expected = model.focal_lengths[0] * model.baseline * (1.0 - 1.0 / 4.0)
    assert len(empty) == pytest.approx(expected, abs=2)
    assert empty[-1] == edge - 1
    without = camera(DepthCameraModel(width=640, height=20, baseline=0.0)).measure(
        HERE, Scene(shapes_of([], [back, front]))
    )
    assert without.all()


def test_a_mirror_shows_the_reflected_room_behind_the_wall() -> None:
    place = Pose2D(9.0, 5.0, 0.0)
    hung = mirror(Pose2D(11.9, 5.0, math.pi), 2.0).mirror
    behind = shapes_of([], [box((6.95, 5.0, 1.0), (0.05, 3.0, 1.0))])
    assert hung is not None
    image = camera(DepthCameraModel(width=41, height=41, error=0.0, range_max=9.0)).measure(
        place, Scene(behind, (hung,))
    )
    # 2.9 m to the mirror, and 4.9 m back to the box behind the robot.
    assert image[20, 20] == pytest.approx(7800, abs=100)
    dark = mirror(Pose2D(11.9, 5.0, math.pi), 2.0, reflects=False).mirror
    assert dark is not None
    assert camera().measure(place, Scene(behind, (dark,)))[60, 80] == 0


def test_a_person_before_a_mirror_hides_it_and_is_seen_again_in_it() -> None:
    place = Pose2D(9.0, 5.0, 0.0)
    hung = mirror(Pose2D(11.9, 5.0, math.pi), 2.0).mirror
    person = shapes_of([], [box((11.0, 4.8, 1.0), (0.1, 0.1, 1.0))])
    assert hung is not None
    model = DepthCameraModel(width=201, height=41, error=0.0, baseline=0.0)
    row = camera(model).measure(place, Scene(person, (hung,)))[20]
    assert ((row > 1850) & (row < 1950)).any()
    assert ((row > 3600) & (row < 3800)).any()


def test_the_same_seed_gives_the_same_images() -> None:
    images: list[list[DepthImage]] = []
    for _ in range(2):
        eye = camera(seed=3)
        images.append([eye.measure(HERE, board(2.0)) for _ in range(2)])
    assert (images[0][0] == images[1][0]).all()
    assert (images[0][1] == images[1][1]).all()
    assert (images[0][0] != images[0][1]).any()


def test_messages_describe_the_pixels() -> None:
    eye = camera()
    image, info = eye.image(eye.measure(HERE, board(2.0)), 12.5), eye.info(12.5)
    assert (image.width, image.height, image.step, image.encoding) == (160, 120, 320, "16UC1")
    assert len(image.data) == image.step * image.height
    assert (info.width, info.height) == (160, 120)
    assert 2.0 * math.degrees(math.atan(0.5 * info.width / info.K[0])) == pytest.approx(57.0)
    assert image.header == info.header


def test_the_mount_of_a_level_camera_is_the_optical_frame_of_ros() -> None:
    mount, optical = DepthCameraModel(z=0.8, pitch=0.2).transforms("base_link").transforms
    assert (mount.header.frame_id, optical.child_frame_id) == ("base_link", "camera_depth_optical_frame")
    assert mount.transform.translation.z == pytest.approx(0.8)
    assert mount.transform.rotation.y == pytest.approx(math.sin(0.1))


@pytest.mark.parametrize(
    "wrong",
    [{"width": 1}, {"field_of_view": (0.0, 1.0)}, {"range_min": 9.0}, {"z": 0.0}, {"pitch": 1.5}, {"resolution": 0.0}],
)
def test_parameters_out_of_range_are_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(InvalidParameter):
        DepthCameraModel(**wrong)  # type: ignore[arg-type]


RENDERED_GRID = room(6.0, 5.0, 0.1, Pose2D(-1.0, 2.0, 0.4))


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
    x, y = RENDERED_GRID.info.to_world((25, 30)).tolist()
    pose = Pose2D(x, y, heading)
    model = DepthCameraModel(width=20, height=15, x=0.1, y=-0.05, z=0.9, pitch=pitch, range_max=4.0)
    shapes = random_shapes(rng, pose)
    eye = pose @ Pose2D(model.x, model.y)
    if sensors.inside(shapes, np.array([[eye.x, eye.y, model.z]]))[0]:
        return
    camera = DepthCamera(RENDERED_GRID.data >= 65, RENDERED_GRID.info, model, rng)
    inverse = camera.inverse_depths(pose, Scene(shapes, wall_height=1.6))
    with np.errstate(divide="ignore"):
        depths = np.where(1.0 / inverse <= model.range_max, 1.0 / inverse, np.inf)
    expected = sensors.depths(RENDERED_GRID, pose, model, shapes, 1.6)
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
    assert ((image > 0) == (sensors.lit(inverse, 4.0, slack) & (inverse > 0.0))).all()


def test_a_shape_behind_the_camera_or_beside_the_image_is_not_drawn() -> None:
    slopes = np.linspace(-0.5, 0.5, 11)
    inverse = np.zeros((11, 11))
    for start in ((0.0, 0.0, -2.0), (3.0, 0.0, 2.0), (0.0, -3.0, 2.0)):
        render.draw_capsules(slopes, slopes, np.array([(*start, *start, 0.3)]), inverse)
    assert not inverse.any()
