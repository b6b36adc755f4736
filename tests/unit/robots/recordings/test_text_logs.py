"""Text logs: recordings, and scans with odometry of which a map is made."""

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
from robots.recordings.carmen import NO_READING
from robots.recordings.recording import Look, Recording
from robots.recordings.scan_logs import read_scan_log
from robots.recordings.text_logs import read_log
from tests.support.world.drive_log import START, graph_log

FLASER = "FLASER 5 1.0 2.0 3.0 4.0 81.91 1.1 2.0 0.5 1.0 2.0 0.5 100.0 host 0.1\n"


def log(folder: Path, text: str) -> Path:
    path = folder / "drive.log"
    path.write_text(text)
    return path


def test_a_graph_has_true_poses_odometry_and_scans(tmp_path: Path) -> None:
    recording = read_log(log(tmp_path, graph_log(6)))
    assert len(recording.looks) == 6
    assert recording.looks[0].true == START
    assert recording.looks[0].odom == Pose2D(0.0, 0.0)
    assert recording.looks[0].laser.distance_to(Pose2D(0.0, 0.0)) < 1e-9
    assert [look.stamp for look in recording.looks[:2]] == [10.0, 10.5]
    drifted = START @ recording.looks[-1].odom
    assert 0.0 < drifted.distance_to(recording.looks[-1].true) < 0.1
    assert len(recording.looks[0].scan.ranges) == 180


def test_a_carmen_scan_covers_180_degrees_and_locates_the_laser(tmp_path: Path) -> None:
    recording = read_log(log(tmp_path, "NEFF 3\n" + FLASER))
    (look,) = recording.looks
    assert look.true == look.odom == Pose2D(1.0, 2.0, 0.5)
    assert recording.looks[0].laser.distance_to(Pose2D(0.1 * math.cos(0.5), -0.1 * math.sin(0.5))) < 1e-9
    assert (look.scan.angle_min, look.scan.angle_increment) == (-math.pi / 2.0, math.pi / 4.0)
    assert look.scan.ranges == [1.0, 2.0, 3.0, 4.0, 81.91]
    assert look.scan.range_max == NO_READING


def test_stamps_with_too_few_digits_are_replaced_by_numbers(tmp_path: Path) -> None:
    recording = read_log(log(tmp_path, FLASER * 3))
    assert [look.stamp for look in recording.looks] == [1.0, 2.0, 3.0]


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("", "no scan"),
        ("ODOM 0 0 0\n", "no scan"),
        ("FLASER 5 1.0 2.0\n", "line 1 .* is not a valid FLASER"),
        ("\nFLASER many 1.0 2.0\n", "line 2 .* is not a valid FLASER"),
        (FLASER.replace("0.5 100", "nan 100"), "not finite"),
        ("ROBOTLASER1 0 0 1 1 1 1 0 -3\n", "is not a valid ROBOTLASER1"),
        ("VERTEX2 0 0\n", "is not a valid VERTEX2"),
        ("VERTEX2 0 0 0 0\nVERTEX2 1 0 0 0\n" + FLASER, "1 scans and 2 poses"),
        ("EDGE2 1 2 0 0 0\n" + FLASER * 3, "no EDGE2 from 0 to 1"),
    ],
)
def test_a_malformed_log_is_refused_with_its_line(tmp_path: Path, text: str, error: str) -> None:
    with pytest.raises(InvalidInput, match=error):
        read_log(log(tmp_path, text))


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1"])
def test_comments_of_a_log_may_be_in_any_encoding(tmp_path: Path, encoding: str) -> None:
    path = tmp_path / "drive.log"
    path.write_bytes(f"{FLASER.strip()}\r\n# Gebäude 079\r\n".encode(encoding))
    assert len(read_log(path).looks) == 1


def test_a_binary_or_missing_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "drive.log").write_bytes(b"\xff\xfe\x00")
    for name, why in (("drive.log", "it is no log of text"), ("nowhere.log", "no such file")):
        with pytest.raises(InvalidInput, match=rf"cannot read .*{name}: {why}"):
            read_log(tmp_path / name)


SCAN_LINE = "FLASER 5 1.0 2.0 3.0 0.0 81.91 1.1 2.0 0.5 1.0 2.0 0.5 {stamp} host 0.1\n"


def scan_log(folder: Path, text: str) -> Path:
    path = folder / "drive.clf"
    path.write_text(text)
    return path


def test_stamps_and_order_are_those_of_the_file(tmp_path: Path) -> None:
    found = read_scan_log(scan_log(tmp_path, "".join(SCAN_LINE.format(stamp=stamp) for stamp in (7.5, 6.25, 8.0))))
    np.testing.assert_array_equal(found.stamps, [7.5, 6.25, 8.0])
    np.testing.assert_array_equal(found.odometry, [(1.0, 2.0, 0.5)] * 3)


def test_ranges_without_a_reading_are_nan_and_the_laser_has_its_place(tmp_path: Path) -> None:
    found = read_scan_log(scan_log(tmp_path, SCAN_LINE.format(stamp=1.0)))
    np.testing.assert_array_equal(found.ranges, [[1.0, 2.0, 3.0, np.nan, np.nan]])
    assert found.geometry.mount.x == pytest.approx(0.1 * math.cos(0.5), abs=1e-3)
    assert found.geometry.mount.y == pytest.approx(-0.1 * math.sin(0.5), abs=1e-3)


def test_a_compressed_log_is_the_same_and_one_cut_in_the_middle_keeps_its_start(tmp_path: Path) -> None:
    text = "".join(SCAN_LINE.format(stamp=stamp) for stamp in range(20_000))
    whole, cut = tmp_path / "drive.clf.bz2", tmp_path / "cut.clf.bz2"
    packed = bz2.compress(text.encode())
    whole.write_bytes(packed)
    cut.write_bytes(packed[: 3 * len(packed) // 4])
    assert len(read_scan_log(whole)) == 20_000
    assert 0 < len(read_scan_log(cut)) < 20_000


def test_a_last_line_without_its_end_is_left_out(tmp_path: Path) -> None:
    line = SCAN_LINE.format(stamp=1.0)
    assert len(read_scan_log(scan_log(tmp_path, line + line[:30]))) == 1
    with pytest.raises(InvalidInput, match="line 2"):
        read_scan_log(scan_log(tmp_path, line + line[:30] + "\n"))


def test_a_graph_has_the_odometry_of_its_edges_unless_read_as_carmen(tmp_path: Path) -> None:
    scans = SCAN_LINE.format(stamp=1.0) * 2
    path = scan_log(tmp_path, scans + "VERTEX2 0 0 0 0\nVERTEX2 1 1 0 0\nEDGE2 0 1 0.5 0 0 1 0 1 1 0 0\n")
    for form in (None, "flirt"):
        np.testing.assert_array_equal(read_scan_log(path, form).odometry, [(0, 0, 0), (0.5, 0, 0)])
    np.testing.assert_array_equal(read_scan_log(path, "carmen").odometry, [(1.0, 2.0, 0.5)] * 2)
    with pytest.raises(InvalidInput, match="not a pose graph"):
        read_scan_log(scan_log(tmp_path, scans), "flirt")


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
