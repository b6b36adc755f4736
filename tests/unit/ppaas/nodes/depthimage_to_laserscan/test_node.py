"""Node ``depthimage_to_laserscan``, in a graph and in a clone."""

import math
from typing import Any

import numpy as np
import pytest

from ppaas.clock import ManualClock
from ppaas.clone.assembly import build_clone
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.messages import decode, encode
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.sensor_msgs import CameraInfo, CompressedImage, Image, LaserScan
from ppaas.nodes.depth_images import depths_of
from ppaas.nodes.depthimage_to_laserscan.node import DepthImageToLaserScanNode
from ppaas.nodes.graph import Graph
from ppaas.nodes.topics import COMPRESSED_DEPTH_IMAGE, DEPTH_CAMERA_INFO, DEPTH_IMAGE
from ppaas.perception.compressed_depth import compress
from ppaas.perception.depth_scan import DepthScanParameters
from tests.support.world.planar_world import walled_map

WIDTH, HEIGHT = 32, 24
HEADER = Header(stamp=Time(7, 5), frame_id="camera_depth_optical_frame")
INFO = CameraInfo(HEADER, HEIGHT, WIDTH, [28.0, 0.0, 15.5, 0.0, 28.0, 11.5, 0.0, 0.0, 1.0])


def image(depths: np.ndarray, encoding: str = "", **changed: Any) -> Image:
    encoding = encoding or ("16UC1" if depths.dtype.kind == "u" else "32FC1")
    big = int(depths.dtype.byteorder == ">")
    step = changed.pop("step", depths.strides[0])
    return Image(HEADER, *depths.shape, encoding, big, step, changed.pop("data", depths.tobytes()))


def wall(kind: str = "<u2") -> np.ndarray:
    return np.full((HEIGHT, WIDTH), 2000 if "u" in kind else 2.0, kind)


@pytest.fixture
def graph() -> Graph:
    made = Graph(stamp_clock=lambda: 9.0)
    made.add(lambda context: DepthImageToLaserScanNode(context, DepthScanParameters(scan_height=3)))
    return made


@pytest.fixture
def scans(graph: Graph) -> list[LaserScan]:
    received: list[Any] = []
    graph.tap("scan", lambda _, message: received.append(message))
    return received


@pytest.mark.parametrize("kind", ["<u2", ">u2", "<f4", ">f4"])
def test_image_is_converted_to_a_scan_in_the_camera_frame(graph, scans, kind):
    graph.inject(DEPTH_CAMERA_INFO.name, INFO)
    graph.inject(DEPTH_IMAGE.name, decode(Image, encode(image(wall(kind)))))
    [scan] = scans
    assert (scan.header.stamp, scan.header.frame_id) == (Time(7, 5), "camera_depth_frame")
    assert scan.angle_min == pytest.approx(-math.atan(15.5 / 28.0))
    assert scan.angle_max == pytest.approx(scan.angle_min + scan.angle_increment * (WIDTH - 1))
    assert np.nanmin(np.array(scan.ranges, float)) == pytest.approx(2.0, rel=1e-3)


def test_compressed_image_gives_the_same_scan(graph, scans):
    graph.inject(DEPTH_CAMERA_INFO.name, INFO)
    graph.inject(DEPTH_IMAGE.name, image(wall()))
    graph.inject(COMPRESSED_DEPTH_IMAGE.name, CompressedImage(HEADER, *compress(wall())))
    np.testing.assert_array_equal(scans[0].ranges, scans[1].ranges)


def test_images_without_camera_info_are_refused_after_a_second():
    """A camera may publish its first image before its parameters; one that never does would wait for ever."""
    clock, scans = ManualClock(9.0), []
    graph = Graph(clock=clock, stamp_clock=clock)
    graph.add(lambda context: DepthImageToLaserScanNode(context, DepthScanParameters(scan_height=3)))
    graph.tap("scan", lambda _, message: scans.append(message))
    graph.inject(DEPTH_IMAGE.name, image(wall()))
    clock.advance(1.0)
    with pytest.raises(InvalidInput, match="CameraInfo on 'camera/depth/camera_info'"):
        graph.inject(DEPTH_IMAGE.name, image(wall()))
    assert scans == []
    graph.inject(DEPTH_CAMERA_INFO.name, INFO)
    graph.inject(DEPTH_IMAGE.name, image(wall()))
    assert len(scans) == 1


def test_restored_node_knows_the_camera_info(graph, scans):
    assert graph.checkpoints() == []
    graph.inject(DEPTH_CAMERA_INFO.name, INFO)
    [known] = graph.checkpoints()
    graph.remove(known.node)
    graph.add(lambda context: DepthImageToLaserScanNode(context, DepthScanParameters(scan_height=3)))
    graph.restore([known])
    graph.inject(DEPTH_IMAGE.name, image(wall()))
    assert len(scans) == 1


def test_padded_rows_are_accepted():
    padded = np.zeros((HEIGHT, WIDTH + 5), np.uint16)
    padded[:, :WIDTH] = np.arange(WIDTH)
    seen = depths_of(Image(HEADER, HEIGHT, WIDTH, "16UC1", 0, 2 * (WIDTH + 5), padded.tobytes()))
    assert np.array_equal(seen, padded[:, :WIDTH])


@pytest.mark.parametrize(
    ("wrong", "why"),
    [
        (image(wall(), "rgb8"), "rgb8"),
        (image(wall(), data=b"short"), "5 bytes"),
        (image(wall(), step=3), "3 bytes per row"),
        (image(np.zeros((1, 1), np.uint16)), "32×24"),
        (Image(HEADER, 0, 0, "16UC1", 0, 0, b""), "0×0"),
    ],
)
def test_invalid_image_is_refused(graph, wrong, why):
    graph.inject(DEPTH_CAMERA_INFO.name, INFO)
    with pytest.raises(InvalidInput, match=why):
        graph.inject(DEPTH_IMAGE.name, wrong)


def test_invalid_camera_info_is_refused(graph):
    with pytest.raises(InvalidInput, match="9 numbers"):
        graph.inject(DEPTH_CAMERA_INFO.name, CameraInfo(HEADER, HEIGHT, WIDTH, []))
    with pytest.raises(InvalidInput, match="focal length"):
        graph.inject(DEPTH_CAMERA_INFO.name, CameraInfo(HEADER, HEIGHT, WIDTH, [0.0] * 9))


@pytest.mark.parametrize("parameters", [{}, {"depthimage_to_laserscan": {"scan_height": 5}}])
def test_clone_has_the_node_if_its_robot_has_a_depth_camera(parameters):
    graph = Graph(stamp_clock=lambda: 9.0)
    layers = build_layers(walled_map(4, 3, []))
    build_clone(graph, layers, model="turtlebot2", initial_pose=(1.0, 1.0, 0.0), parameters=parameters)
    assert (DEPTH_IMAGE.name in graph.topics) is bool(parameters)
    wrong = {"depthimage_to_laserscan": {"scan_height": 0}}
    with pytest.raises(InvalidParameter, match="scan_height"):
        build_clone(Graph(), layers, model="turtlebot2", initial_pose=(1.0, 1.0, 0.0), parameters=wrong)
