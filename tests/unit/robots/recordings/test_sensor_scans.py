"""Bags of robots without a laser: depth images and point clouds become scans, and points of a 3D map."""

from pathlib import Path

import numpy as np
import pytest

from ppaas.errors import InvalidInput
from robots.recordings.bag_points import BagPoints
from robots.recordings.reader import read_recording
from robots.recordings.recording import RecordedFrames
from robots.recordings.sensor_scans import scan_of_cloud
from tests.support.recordings.bags import make_bag
from tests.support.recordings.sensor_bags import KINDS, RISE, ROOM, STEP, WIDTH, make_sensor_bag


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "cloud"])
def test_depth_images_of_any_format_become_scans(tmp_path: Path, kind: str) -> None:
    recording = read_recording(make_sensor_bag(tmp_path / "bag", kind, images=4))
    assert recording.notes == ("there is no laser: 4 depth images are taken as scans",)
    look = recording.looks[-1]
    assert (len(recording.looks), look.odom.x) == (4, pytest.approx(3 * STEP))
    assert tuple(look.laser) == pytest.approx((0.1, 0.0, 0.0), abs=1e-6)
    ranges = np.array(look.scan.ranges, float)
    angles = look.scan.angle_min + look.scan.angle_increment * np.arange(WIDTH)
    ahead = (np.abs(angles) < 0.3) & np.isfinite(ranges)  # two columns may share a beam, so that another has none
    assert ahead.sum() > 40
    np.testing.assert_allclose((ranges * np.cos(angles))[ahead], ROOM[0] - look.odom.x - 0.1, atol=0.03)


@pytest.mark.parametrize("ros1", [False, True])
def test_clouds_become_scans_all_around(tmp_path: Path, ros1: bool) -> None:
    recording = read_recording(make_sensor_bag(tmp_path / "bag", "cloud", images=3, ros1=ros1))
    assert recording.notes == ("there is no laser: 3 point clouds are taken as scans",)
    scan, x = recording.looks[-1].scan, recording.looks[-1].odom.x
    ranges = np.array(scan.ranges, float)
    seen = np.flatnonzero(np.isfinite(ranges))
    assert len(seen) > 300
    angles = scan.angle_min + scan.angle_increment * seen
    along, across = ranges[seen] * np.cos(angles) + x, ranges[seen] * np.sin(angles)
    assert np.max(np.minimum(abs(np.abs(along) - ROOM[0]), abs(np.abs(across) - ROOM[1]))) < 0.05


def test_a_depth_camera_of_ros_1_is_read(tmp_path: Path) -> None:
    assert len(read_recording(make_sensor_bag(tmp_path / "bag", "png", images=2, ros1=True)).looks) == 2


def test_a_camera_without_a_transform_is_taken_to_look_ahead(tmp_path: Path) -> None:
    recording = read_recording(make_sensor_bag(tmp_path / "bag", "16UC1", images=2, transforms=False))
    assert any("camera_depth_optical_frame_scan: it is taken to be there" in note for note in recording.notes)
    assert tuple(recording.looks[0].laser) == (0.0, 0.0, 0.0)


def test_a_laser_is_used_rather_than_clouds_and_clouds_by_their_topic(tmp_path: Path) -> None:
    folder = tmp_path / "both"
    make_bag(folder, "mcap", scans=3)
    cloud = make_sensor_bag(tmp_path / "cloud", "cloud", images=3)
    (folder / "both_1.mcap").write_bytes(next(cloud.glob("*.mcap")).read_bytes())
    for metadata in folder.glob("metadata.yaml"):
        metadata.unlink()
    assert {len(look.scan.ranges) for look in read_recording(folder).looks} == {90}
    chosen = read_recording(folder, RecordedFrames(scan_topic="/points"))
    assert {len(look.scan.ranges) for look in chosen.looks} == {720}


def test_a_broken_cloud_is_refused(tmp_path: Path) -> None:
    class Broken:
        fields = ()
        is_bigendian, width, height = False, 1, 1

    with pytest.raises(InvalidInput, match="must have the fields x, y and z"):
        scan_of_cloud(Broken())


@pytest.mark.parametrize("kind", KINDS)
def test_points_of_a_bag_are_in_the_frame_of_the_robot(tmp_path: Path, kind: str) -> None:
    bag = BagPoints(make_sensor_bag(tmp_path / "bag", kind, images=2), RecordedFrames())
    seen = list(bag.read())
    assert (len(seen), dict(bag.left_out)) == (2, {})
    assert seen[0].sensor.z == pytest.approx(RISE)
    points = seen[0].points
    on_floor = points[:, 2] < 0.05
    walls = points[~on_floor & (points[:, 2] > 0.15)]
    assert np.max(np.minimum(abs(np.abs(walls[:, 0]) - ROOM[0]), abs(np.abs(walls[:, 1]) - ROOM[1]))) < 0.03
    assert on_floor.any() == (kind != "cloud")


def test_points_without_a_transform_are_counted(tmp_path: Path) -> None:
    bag = BagPoints(make_sensor_bag(tmp_path / "bag", "cloud", images=2, transforms=False), RecordedFrames())
    assert list(bag.read()) == []
    assert dict(bag.left_out) == {"no transform leads from base_link to lidar": 2}
