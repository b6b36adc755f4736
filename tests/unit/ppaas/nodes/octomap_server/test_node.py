"""Node ``octomap_server``: clouds and depth images, key frames, services, and what is published."""

import base64

import numpy as np
import pytest

from ppaas.errors import InvalidInput, InvalidParameter, TransformError
from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED
from ppaas.maps.occupancy import from_message
from ppaas.maps.octomap import parse_octomap
from ppaas.messages import decode, encode
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.octomap_msgs import BoundingBoxQueryRequest, GetOctomapFileRequest, GetOctomapFileResponse, Octomap
from ppaas.messages.sensor_msgs import CameraInfo, CompressedImage, Image
from ppaas.nodes.octomap_server.parameters import OctomapServerParameters, spelled
from ppaas.parameters import read_parameters
from ppaas.perception.compressed_depth import compress
from tests.support.world.cloud_robot import HEIGHT, START, CloudRobot, cloud_message, tree_of, wall
from tests.support.world.mapping_robot import HeldJobs

HERE = Pose2D(0.0, 0.0)
MAPS = ("octomap_binary", "octomap_full", "projected_map")


def ready(**parameters) -> CloudRobot:
    robot = CloudRobot(**parameters)
    robot.move(HERE)
    return robot


def test_a_cloud_is_occupied_where_the_sensor_saw_it():
    robot = ready()
    robot.send(wall(2.05))
    found = robot.occupied()
    assert np.allclose(found[:, 0], 2.05)
    assert found[:, 2].min() == pytest.approx(0.15)
    assert len(found) == 21 * 9


def test_clouds_wait_for_the_transform_at_their_stamp():
    robot = ready()
    robot.clock.advance(0.1)
    robot.send(wall(2.05))
    assert not len(robot.occupied())
    robot.move(Pose2D(0.5, 0.0))
    assert np.allclose(robot.occupied()[:, 0], 2.55)


def test_clouds_without_any_pose_wait_and_the_status_says_why():
    robot = CloudRobot()
    robot.move(HERE, correction=None)
    robot.send(wall(2.05))
    assert "localize the robot" in robot.status
    robot.clock.advance(0.1)
    robot.move(HERE)
    robot.send(wall(2.05))
    assert robot.status == ""


def test_a_depth_image_gives_the_points_of_its_pixels():
    robot = ready()
    header = Header(stamp=Time.of(START), frame_id="camera")
    info = CameraInfo(header, 24, 32, [28.0, 0.0, 15.5, 0.0, 28.0, 11.5, 0.0, 0.0, 1.0])
    depths = np.full((24, 32), 2050, np.uint16)
    robot.graph.inject("camera/depth/image_raw", Image(header, 24, 32, "16UC1", 0, 64, depths.tobytes()))
    robot.graph.inject("camera/depth/camera_info", info)
    robot.graph.inject("camera/depth/image_raw", Image(header, 24, 32, "16UC1", 0, 64, depths.tobytes()))
    plain = robot.occupied()
    assert np.allclose(plain[:, 0], 2.05)
    assert abs(plain[:, 1].mean()) < 0.1
    robot.call("octomap_server/reset")
    robot.graph.inject("camera/depth/image_raw/compressedDepth", CompressedImage(header, *compress(depths)))
    assert np.array_equal(robot.occupied(), plain)
    [kept] = robot.graph.checkpoints()
    other = CloudRobot()
    other.graph.restore([kept])
    assert other.graph.checkpoints() == [kept]


def test_images_without_camera_info_are_refused_after_a_second():
    robot = ready()
    header = Header(frame_id="camera")
    image = Image(header, 24, 32, "16UC1", 0, 64, bytes(24 * 64))
    robot.graph.inject("camera/depth/image_raw", image)
    robot.clock.advance(1.0)
    with pytest.raises(InvalidInput, match="CameraInfo"):
        robot.graph.inject("camera/depth/image_raw", image)


def test_clouds_move_with_their_key_frames_when_a_loop_is_closed():
    robot = CloudRobot()
    robot.move(HERE, correction=None)
    robot.key_frames((START, HERE))
    robot.clock.advance(1.0)
    robot.move(Pose2D(0.1, 0.0), correction=None)
    robot.send(wall(2.05))
    assert np.allclose(robot.occupied()[:, 0], 2.15)
    robot.key_frames((START, Pose2D(0.0, 1.0)), (START + 1.0, Pose2D(0.1, 1.0)))
    moved = robot.occupied()
    assert np.allclose(moved[:, 0], 2.15)
    assert moved[:, 1].mean() == pytest.approx(1.0, abs=0.06)
    robot.send(wall(1.05))
    assert (np.isclose(robot.occupied()[:, 0], 1.15) & (robot.occupied()[:, 1] > 0.0)).any()


def test_a_cleared_2d_map_clears_the_3d_map():
    robot = CloudRobot()
    robot.move(HERE, correction=None)
    robot.key_frames((START, HERE))
    robot.send(wall(2.05))
    assert len(robot.occupied())
    robot.key_frames()
    assert not len(robot.occupied())


def test_maps_are_published_once_a_second_to_those_who_subscribe():
    robot = ready(resolution=0.1)
    for topic in MAPS:
        robot.hear(topic)
    robot.send(wall(2.05))
    robot.clock.advance(1.0)
    robot.graph.run_due()
    binary, full, projected = (robot.heard[topic][0] for topic in MAPS)
    assert decode(Octomap, encode(binary)).id == "OcTree"
    assert (binary.binary, full.binary) == (True, False)
    assert tree_of(full).occupied.sum() == tree_of(binary).occupied.sum() == 21 * 9
    grid = from_message(projected)
    cells = grid.info.to_cells([[2.05, 0.05], [1.05, 0.05]])
    assert grid.data[tuple(cells.T)].tolist() == [OCCUPIED, FREE]
    robot.clock.advance(1.0)
    robot.graph.run_due()
    assert {len(robot.heard[topic]) for topic in MAPS} == {1}


@pytest.mark.parametrize(("latch", "messages"), [(True, 1), (False, 0)])
def test_later_subscribers_get_the_map_if_it_is_latched(latch, messages):
    robot = ready(latch=latch)
    robot.send(wall(2.05))
    robot.clock.advance(1.0)
    robot.graph.run_due()
    robot.hear("octomap_binary")
    robot.clock.advance(1.0)
    robot.graph.run_due()
    assert len(robot.heard.get("octomap_binary", [])) == messages


def test_clear_bbx_frees_a_box_and_reset_forgets_all():
    robot = ready()
    robot.send(wall(2.05))
    before = len(robot.occupied())
    for service in ("octomap_server/clear_bbx", "octomap_server/clear_bbox"):
        robot.call(service, BoundingBoxQueryRequest(Point(2.0, 0.0, 0.0), Point(2.2, 2.0, 2.0)))
    assert 0 < len(robot.occupied()) < before
    with pytest.raises(InvalidInput):
        robot.call("octomap_server/clear_bbx", BoundingBoxQueryRequest(Point(float("nan"), 0.0), Point(1.0, 1.0)))
    robot.call("octomap_server/reset")
    assert not len(robot.tree().depths)


def test_clouds_that_come_faster_than_they_are_inserted_are_left_out():
    jobs = HeldJobs()
    robot = CloudRobot(jobs)
    robot.move(HERE)
    for _ in range(5):
        robot.send(wall(2.05))
    for _ in range(5):
        jobs.release()
    assert "faster than they are inserted" in "".join(message.data for message in robot.heard["octomap_server/status"])
    robot.send(wall(2.05))
    jobs.release()
    assert robot.status == ""


def test_the_floor_is_free_with_the_ground_filter():
    across, ahead = np.meshgrid(np.linspace(-1.0, 1.0, 41), np.linspace(0.5, 2.0, 31))
    floor = np.stack([ahead.ravel(), across.ravel(), np.full(across.size, -HEIGHT)], axis=1).astype(np.float32)
    for wanted in (False, True):
        robot = ready(filter_ground=wanted)
        robot.send(np.concatenate((floor, wall(2.55))))
        assert (robot.occupied()[:, 2] < 0.1).any() != wanted
        assert np.isclose(robot.occupied()[:, 0], 2.55).any()


def test_points_outside_the_limits_are_left_out():
    robot = ready(pointcloud_max_x=1.5)
    robot.send(np.concatenate((wall(1.05), wall(2.05))))
    assert np.allclose(robot.occupied()[:, 0], 1.05)


def test_a_map_that_would_be_too_large_is_reported():
    robot = ready(max_blocks=3)
    robot.send(wall(5.05))
    assert "max_blocks allows 3" in robot.status


def test_a_broken_cloud_is_refused_at_once_and_an_unknown_sensor_too():
    robot = ready()
    with pytest.raises(InvalidInput, match="fields x, y and z"):
        robot.graph.inject("cloud_in", _without_fields(robot))
    with pytest.raises(TransformError, match="unknown"):
        robot.send(wall(1.0), frame="unknown")
    assert "unknown" in robot.status


def _without_fields(robot):
    message = cloud_message(wall(1.0), robot.clock())
    message.fields = []
    return message


def test_registered_clouds_are_put_where_those_before_were():
    pytest.importorskip("small_gicp")
    robot = ready(registration=True, resolution=0.02)
    corner = np.concatenate((wall(2.01), wall(2.01)[:, [1, 0, 2]], wall(2.01)[:, [2, 1, 0]] - np.float32([0, 0, 2.3])))
    robot.send(corner)
    before = robot.occupied()
    robot.clock.advance(0.1)
    robot.move(Pose2D(0.06, 0.0))
    robot.send(corner)
    assert np.abs(robot.occupied()[:, 0].max() - before[:, 0].max()) <= 0.03


def test_the_file_is_got_page_by_page_and_is_empty_without_a_map():
    robot, file = ready(), b""
    assert robot.call("octomap_server/file", GetOctomapFileRequest()) == GetOctomapFileResponse()
    robot.send(wall(2.05))
    while True:
        page = robot.call("octomap_server/file", GetOctomapFileRequest(len(file)))
        file += base64.b64decode(page.data)
        if not page.data:
            break
    assert page.size == len(file)
    assert np.array_equal(parse_octomap(file).corners, robot.tree().corners)
    with pytest.raises(InvalidInput, match="begin at 0"):
        robot.call("octomap_server/file", GetOctomapFileRequest(5))


def read(given):
    return read_parameters(OctomapServerParameters, "octomap_server", spelled(given))


@pytest.mark.parametrize(
    "given",
    [
        {"sensor_model/max_range": 4.0, "pointcloud_min_z": -0.5, "ground_filter/distance": 0.1, "filter_ground": True},
        {"sensor_model.max_range": 4.0, "point_cloud_min_z": -0.5, "ground_filter.distance": 0.1,
         "filter_ground_plane": True},
        {"sensor_model": {"max_range": 4.0}, "point_cloud_min_z": -0.5, "ground_filter": {"distance": 0.1},
         "filter_ground": True},
    ],
)  # fmt: skip
def test_names_of_ros_1_and_ros_2_are_read(given):
    parameters = read(given)
    assert (parameters.volume().max_range, parameters.volume().point_cloud_min_z) == (4.0, -0.5)
    assert (parameters.ground_filter().distance, parameters.filter_ground_plane) == (0.1, True)


def test_parameters_of_markers_and_compression_have_no_effect():
    given = {
        "compress_map": False,
        "color": {"r": 1.0},
        "color_free/a": 0.5,
        "max_depth": 16,
        "incremental_2D_projection": True,
    }
    assert read(given) == OctomapServerParameters()


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"colored_map": True}, "no colours"),
        ({"max_depth": 14}, "coarser 'resolution'"),
        ({"octomap_path": "/tmp/a.bt"}, "reads no files"),
        ({"sensor_model/hit": 0.2}, "sensor_model.hit"),
        ({"filter_ground": True, "pointcloud_min_z": 0.5}, "points of the floor"),
        ({"ground_filter/angle": 0.0}, "angle"),
        ({"point_cloud_max_x": float("inf")}, "finite"),
        ({"min_x_size": -1.0}, "min_x_size"),
        ({"max_blocks": 1 << 30}, "at most 1048576"),
        ({"nonsense": 1}, "nonsense"),
    ],
)
def test_parameters_that_are_not_supported_are_refused_with_the_reason(given, why):
    with pytest.raises(InvalidParameter, match=why):
        read(given)
