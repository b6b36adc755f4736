"""Node ``torso_detector``, in a graph."""

import math
from typing import Any

import numpy as np
import pytest

from ppaas.clock import ManualClock
from ppaas.errors import InvalidInput, InvalidParameter, TransformError
from ppaas.messages import decode, encode
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import TransformStamped
from ppaas.messages.people_coordination import SensorView
from ppaas.messages.people_msgs import PositionMeasurementArray
from ppaas.messages.sensor_msgs import CompressedImage, Image
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.graph import Graph
from ppaas.nodes.topics import (
    COMPRESSED_DEPTH_IMAGE,
    DEPTH_CAMERA_INFO,
    DEPTH_IMAGE,
    TF_STATIC,
    TORSO_MEASUREMENTS,
    TORSO_VIEW,
)
from ppaas.nodes.torso_detector.node import CLOSE, TorsoDetectorNode
from ppaas.perception.compressed_depth import compress
from ppaas.perception.torso.parameters import TorsoDetectorParameters
from ppaas.transforms.spatial import Rigid
from robots.sim.depth.camera import OPTICAL_FRAME, DepthCamera, DepthCameraModel, DepthImage
from tests.support.world.depth_images import GRID, SMALL, image_of, person

HEADER = Header(stamp=Time(7, 5), frame_id=OPTICAL_FRAME)
INFO = DepthCamera(GRID.data >= 65, GRID.info, SMALL, np.random.default_rng(0)).info(7.0)


def raw(depths: DepthImage) -> Image:
    height, width = depths.shape
    return Image(HEADER, height, width, "16UC1", 0, 2 * width, depths.tobytes())


class Fixture:
    """A graph with the node, and what it published."""

    def __init__(self, parameters: TorsoDetectorParameters | None = None) -> None:
        self.clock = ManualClock(9.0)
        self.graph = Graph(clock=self.clock, stamp_clock=self.clock)
        own = parameters or TorsoDetectorParameters()
        self.graph.add(lambda context: TorsoDetectorNode(context, own))
        self.found: list[PositionMeasurementArray] = []
        self.views: list[SensorView] = []
        self.graph.tap(TORSO_MEASUREMENTS.name, lambda _, message: self.found.append(_whole(message)))
        self.graph.tap(TORSO_VIEW.name, lambda _, message: self.views.append(_whole(message)))

    def mounted(self, model: DepthCameraModel = SMALL) -> "Fixture":
        self.graph.inject(TF_STATIC.name, model.transforms("base_link"))
        self.graph.inject(DEPTH_CAMERA_INFO.name, INFO)
        return self

    def see(self, topic: str, message: Any) -> None:
        self.clock.advance(0.2)
        self.graph.inject(topic, message)


def _whole(message: Any) -> Any:
    assert not isinstance(message, bytes)
    return message


@pytest.fixture(scope="module")
def image() -> DepthImage:
    return image_of(person(2.5, 0.3))


def test_people_are_published_in_the_frame_of_the_body_at_the_time_of_the_image(image: DepthImage) -> None:
    fixture = Fixture().mounted()
    fixture.see(DEPTH_IMAGE.name, decode(Image, encode(raw(image))))
    [found] = fixture.found
    assert (found.header.stamp, found.header.frame_id) == (Time(7, 5), "base_link")
    [one] = found.people
    assert math.hypot(one.pos.x - 2.5, one.pos.y - 0.3) < 0.12
    assert 0.9 < one.pos.z < 1.5
    assert (one.name, one.initialization) == ("torso_detector", 1)
    assert one.reliability > 0.6
    assert np.linalg.eigvalsh(np.array(one.covariance).reshape(3, 3)).min() > 0.0


def test_compressed_images_give_the_same_people(image: DepthImage) -> None:
    fixture = Fixture().mounted()
    fixture.see(DEPTH_IMAGE.name, raw(image))
    fixture.see(COMPRESSED_DEPTH_IMAGE.name, CompressedImage(HEADER, *compress(image)))
    assert fixture.found[0].people == fixture.found[1].people


def test_an_image_without_people_gives_an_empty_message() -> None:
    fixture = Fixture().mounted()
    fixture.see(DEPTH_IMAGE.name, raw(image_of()))
    assert [found.people for found in fixture.found] == [[]]


def test_the_view_is_published_when_it_is_known_or_changes(image: DepthImage) -> None:
    fixture = Fixture().mounted()
    fixture.see(DEPTH_IMAGE.name, raw(image))
    fixture.see(DEPTH_IMAGE.name, raw(image))
    [view] = fixture.views
    assert view.field_of_view == pytest.approx(math.radians(57.0), abs=0.01)
    assert (view.x, view.y, view.yaw) == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    assert (view.range_min, view.range_max) == (CLOSE, 6.0)
    fixture.mounted(DepthCameraModel(320, 240, x=0.2)).see(DEPTH_IMAGE.name, raw(image))
    assert fixture.views[-1].x == pytest.approx(0.2)


def test_heights_count_from_the_floor_if_the_base_is_above_it(image: DepthImage) -> None:
    fixture = Fixture().mounted(DepthCameraModel(320, 240, z=0.9))
    footprint = Rigid(z=-0.1).to_message()
    fixture.graph.inject(
        TF_STATIC.name, TFMessage([TransformStamped(Header(frame_id="base_link"), "base_footprint", footprint)])
    )
    fixture.see(DEPTH_IMAGE.name, raw(image))
    other = Fixture().mounted()
    other.see(DEPTH_IMAGE.name, raw(image))
    [low], [high] = fixture.found[0].people, other.found[0].people
    assert high.pos.z - low.pos.z == pytest.approx(0.1, abs=1e-6)


def test_images_that_come_faster_than_the_largest_rate_are_left_out(image: DepthImage) -> None:
    fixture = Fixture(TorsoDetectorParameters(max_rate=2.0)).mounted()
    for _ in range(5):
        fixture.see(DEPTH_IMAGE.name, raw(image))
    assert len(fixture.found) == 2


def test_images_without_camera_info_or_mount_are_refused() -> None:
    fixture = Fixture()
    fixture.see(DEPTH_IMAGE.name, raw(image_of()))
    fixture.clock.advance(1.0)
    with pytest.raises(InvalidInput, match="CameraInfo"):
        fixture.see(DEPTH_IMAGE.name, raw(image_of()))
    fixture.graph.inject(DEPTH_CAMERA_INFO.name, INFO)
    with pytest.raises(TransformError, match=OPTICAL_FRAME):
        fixture.see(DEPTH_IMAGE.name, raw(image_of()))


def test_a_broken_compressed_image_is_told_with_the_next(image: DepthImage) -> None:
    fixture = Fixture().mounted()
    fixture.see(COMPRESSED_DEPTH_IMAGE.name, CompressedImage(HEADER, "16UC1; compressedDepth png", b"x" * 40))
    with pytest.raises(InvalidInput, match="PNG"):
        fixture.see(DEPTH_IMAGE.name, raw(image))
    fixture.see(DEPTH_IMAGE.name, raw(image))
    assert len(fixture.found) == 1


def test_an_image_of_another_size_is_refused() -> None:
    fixture = Fixture().mounted()
    fixture.see(DEPTH_IMAGE.name, raw(np.zeros((4, 4), np.uint16)))
    with pytest.raises(InvalidInput, match="320×240"):
        fixture.see(DEPTH_IMAGE.name, raw(image_of()))


def test_restored_node_knows_the_camera(image: DepthImage) -> None:
    fixture = Fixture()
    assert fixture.graph.checkpoints() == []
    [known] = fixture.mounted().graph.checkpoints()
    other = Fixture()
    other.graph.restore([known])
    other.graph.inject(TF_STATIC.name, SMALL.transforms("base_link"))
    other.see(DEPTH_IMAGE.name, raw(image))
    assert len(other.found[0].people) == 1


@pytest.mark.parametrize(
    "wrong",
    [{"range_min": 7.0}, {"range_max": 30.0}, {"threshold": 0.9}, {"initialization_threshold": 1.5}, {"max_rate": 0.0}],
)
def test_parameters_out_of_range_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(InvalidParameter):
        TorsoDetectorParameters(**wrong)
