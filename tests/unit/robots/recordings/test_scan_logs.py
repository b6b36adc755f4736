"""Scans and odometry of recordings, for mapping."""

import bz2
import math
from pathlib import Path

import numpy as np
import pytest

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.sensor_msgs import LaserScan
from robots.recordings import ros_bags
from robots.recordings.recording import Look, Recording
from robots.recordings.scan_logs import read_scan_log

FLASER = "FLASER 5 1.0 2.0 3.0 0.0 81.91 1.1 2.0 0.5 1.0 2.0 0.5 {stamp} host 0.1\n"


def log(folder: Path, text: str) -> Path:
    path = folder / "drive.clf"
    path.write_text(text)
    return path


def test_stamps_and_order_are_those_of_the_file(tmp_path: Path) -> None:
    found = read_scan_log(log(tmp_path, "".join(FLASER.format(stamp=stamp) for stamp in (7.5, 6.25, 8.0))))
    np.testing.assert_array_equal(found.stamps, [7.5, 6.25, 8.0])
    np.testing.assert_array_equal(found.odometry, [(1.0, 2.0, 0.5)] * 3)


def test_ranges_without_a_reading_are_nan_and_the_laser_has_its_place(tmp_path: Path) -> None:
    found = read_scan_log(log(tmp_path, FLASER.format(stamp=1.0)))
    np.testing.assert_array_equal(found.ranges, [[1.0, 2.0, 3.0, np.nan, np.nan]])
    assert found.geometry.mount.x == pytest.approx(0.1 * math.cos(0.5), abs=1e-3)
    assert found.geometry.mount.y == pytest.approx(-0.1 * math.sin(0.5), abs=1e-3)


def test_a_compressed_log_is_the_same_and_one_cut_in_the_middle_keeps_its_start(tmp_path: Path) -> None:
    text = "".join(FLASER.format(stamp=stamp) for stamp in range(20_000))
    whole, cut = tmp_path / "drive.clf.bz2", tmp_path / "cut.clf.bz2"
    packed = bz2.compress(text.encode())
    whole.write_bytes(packed)
    cut.write_bytes(packed[: 3 * len(packed) // 4])
    assert len(read_scan_log(whole)) == 20_000
    assert 0 < len(read_scan_log(cut)) < 20_000


def test_a_last_line_without_its_end_is_left_out(tmp_path: Path) -> None:
    line = FLASER.format(stamp=1.0)
    assert len(read_scan_log(log(tmp_path, line + line[:30]))) == 1
    with pytest.raises(InvalidInput, match="line 2"):
        read_scan_log(log(tmp_path, line + line[:30] + "\n"))


def test_a_graph_has_the_odometry_of_its_edges_unless_read_as_carmen(tmp_path: Path) -> None:
    scans = FLASER.format(stamp=1.0) * 2
    path = log(tmp_path, scans + "VERTEX2 0 0 0 0\nVERTEX2 1 1 0 0\nEDGE2 0 1 0.5 0 0 1 0 1 1 0 0\n")
    for form in (None, "flirt"):
        np.testing.assert_array_equal(read_scan_log(path, form).odometry, [(0, 0, 0), (0.5, 0, 0)])
    np.testing.assert_array_equal(read_scan_log(path, "carmen").odometry, [(1.0, 2.0, 0.5)] * 2)
    with pytest.raises(InvalidInput, match="not a pose graph"):
        read_scan_log(log(tmp_path, scans), "flirt")


def test_a_bag_has_the_times_of_its_beams(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scan = LaserScan(
        Header(), angle_min=0.0, angle_max=0.2, angle_increment=0.1, time_increment=0.01, range_min=0.5,
        range_max=8.0, ranges=[1.0, None, 0.1],
    )  # fmt: skip
    look = Look(4.0, Pose2D(1.0, 0.0), scan, None, Pose2D(0.2, 0.0))
    monkeypatch.setattr(ros_bags, "read_bag", lambda path, frames: Recording((look,)))
    found = read_scan_log(tmp_path)
    assert (found.geometry.time_increment, found.geometry.stamped_at) == (0.01, 0.0)
    np.testing.assert_array_equal(found.ranges, [[1.0, np.nan, np.nan]])
