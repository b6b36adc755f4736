import math

import numpy as np
import pytest

from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D
from robots.sim.bodies.furniture import mirror
from robots.sim.depth.camera import ERROR, RESOLUTION, DepthCamera, DepthCameraModel, DepthImage, Scene
from robots.sim.depth.shapes import box, shapes_of
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
