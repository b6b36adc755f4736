"""Messages of CARMEN: lasers with and without poses, old forms, places of lasers, true poses."""

import math
from pathlib import Path

import numpy as np
import pytest

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from robots.recordings.reader import read_recording
from robots.recordings.recording import NO_ODOMETRY, RecordedFrames
from robots.recordings.scan_logs import read_scan_log
from robots.recordings.text_logs import read_lines

END = "{stamp} nohost 0.1\n"
ODOM = "ODOM {x} 0.0 0.0 0.5 0.0 0.0 " + END
RAW = "RAWLASER{laser} 99 -1.57 3.14 0.785 30.0 0.01 0 5 1.0 2.0 3.0 4.0 30.0 0 " + END
FRONT = "FLASER 5 1.0 2.0 3.0 4.0 81.91 1.1 0.0 0.0 1.0 0.0 0.0 " + END
REAR = FRONT.replace("FLASER", "RLASER").replace("1.1 0.0 0.0 1.0", "0.8 0.0 3.141593 1.0")
ROBOT = (
    "ROBOTLASER1 0 -1.0 2.0 0.5 20.0 0.01 0 5 1.0 2.0 3.0 4.0 5.0 0 1.1 0.0 0.0 1.0 0.0 0.0 0.5 0.0 0.3 0.2 0.0 " + END
)


def log(folder: Path, *lines: str) -> Path:
    path = folder / "drive.log"
    path.write_text("".join(lines))
    return path


def drive(line: str, **values: object) -> list[str]:
    """Return a line at 1, 2 and 3 s."""
    return [line.format(stamp=stamp, x=0.5 * stamp, **values) for stamp in (1.0, 2.0, 3.0)]


def test_scans_without_poses_get_them_from_the_odometry_and_the_parameters(tmp_path: Path) -> None:
    scans = [RAW.format(laser=1, stamp=stamp) for stamp in (1.5, 2.0)]
    place = "PARAM robot_frontlaser_offset 0.2 0.0 nohost 0.0\nPARAM robot_frontlaser_side_offset -0.1 0.0 nohost 0.0\n"
    found = read_scan_log(log(tmp_path, *drive(ODOM), *scans, "SYNC tag 1.0 nohost 1.0\n", place))
    np.testing.assert_allclose(found.odometry[:, 0], [0.75, 1.0])
    assert tuple(found.geometry.mount) == pytest.approx((0.2, -0.1, 0.0))
    assert (found.geometry.angle_min, found.geometry.angle_increment) == (-1.57, 0.785)
    np.testing.assert_array_equal(found.ranges[0], [1.0, 2.0, 3.0, 4.0, np.nan])


@pytest.mark.parametrize(
    ("laser", "parameters", "place"),
    [
        (2, "PARAM robot_rearlaser_offset -0.3 0 nohost 0\n", (-0.3, 0.0, math.pi)),
        (2, "PARAM robot_rearlaser_angular_offset 3.0 0 nohost 0\n", (0.0, 0.0, 3.0)),
        (1, "PARAM robot_frontlaser_offset none 0 nohost 0\n", (0.0, 0.0, 0.0)),
        (3, "POSITIONLASER 3 0.1 0.2 0.5 0.0 0.0 1.5 0 nohost 0\n", (0.1, 0.2, 1.5)),
        (5, "", (0.0, 0.0, 0.0)),
    ],
)
def test_each_laser_has_its_place(tmp_path: Path, laser: int, parameters: str, place: tuple[float, ...]) -> None:
    found = read_scan_log(log(tmp_path, parameters, *drive(ODOM), *drive(RAW, laser=laser)))
    x, y, theta = found.geometry.mount
    assert (x, y, math.cos(theta)) == pytest.approx((*place[:2], math.cos(place[2])), abs=1e-3)


def test_scans_at_whose_time_there_is_no_odometry_are_left_out_with_a_note(tmp_path: Path) -> None:
    notes: list[str] = []
    early = [RAW.format(laser=1, stamp=stamp) for stamp in (0.5, 1.0, 4.0)]
    found = read_scan_log(log(tmp_path, *drive(ODOM), *early), note=notes.append)
    assert (found.stamps.tolist(), notes) == (
        [1.0],
        ["2 of 3 scans RAWLASER1 left out: there is no ODOM at their time"],
    )
    with pytest.raises(InvalidInput, match="no ODOM is at the time of any of the 2 scans RAWLASER1"):
        read_scan_log(log(tmp_path, *drive(ODOM), early[0], early[2]))


def test_scans_without_any_odometry_are_mapped_by_themselves(tmp_path: Path) -> None:
    notes: list[str] = []
    path = log(tmp_path, "PARAM robot_frontlaser_offset 0.2 0 nohost 0\n", *drive(RAW, laser=1))
    assert read_scan_log(path, note=notes.append).geometry.mount.x == pytest.approx(0.2)
    recording = read_recording(path)
    assert (notes, recording.has_odometry, recording.looks[0].true) == ([NO_ODOMETRY], False, None)


def test_the_front_laser_is_used_and_another_one_by_its_name(tmp_path: Path) -> None:
    notes: list[str] = []
    path = log(tmp_path, *drive(FRONT), *drive(REAR), REAR.format(stamp=4.0))
    assert len(read_scan_log(path, note=notes.append)) == 3
    assert notes == ["4 scans RLASER left out: they are of another laser than FLASER; --scan-topic RLASER uses them"]
    rear = read_scan_log(path, frames=RecordedFrames(scan_topic="rlaser"))
    assert (len(rear), rear.geometry.mount.x) == (4, pytest.approx(-0.2))
    with pytest.raises(InvalidInput, match=r"no scans 'LASER3'; there are FLASER \(3\), RLASER \(4\)"):
        read_scan_log(path, frames=RecordedFrames(scan_topic="LASER3"))


def test_one_scan_in_two_messages_counts_once(tmp_path: Path) -> None:
    notes: list[str] = []
    path = log(tmp_path, *drive(ODOM), *drive(RAW, laser=1), *drive(ROBOT))
    found = read_scan_log(path, note=notes.append)
    assert (len(found), found.geometry.angle_min, notes) == (3, -1.0, [])


def test_a_message_without_a_number_of_remissions_is_read(tmp_path: Path) -> None:
    short = ROBOT.replace("5.0 0 1.1", "5.0 1.1")
    for line in (ROBOT, short, ROBOT.replace("5.0 0 1.1", "5.0 2 7.5 8.5 1.1")):
        lines = read_lines(log(tmp_path, line.format(stamp=7.0)))
        (scan,) = lines.scans
        assert (scan.laser.x, scan.robot.x, scan.stamp) == (1.1, 1.0, 7.0)


@pytest.mark.parametrize(
    ("count", "resolution", "field"), [
        (181, "", 180.0), (361, "0.5", 180.0), (401, "", 100.0), (541, "", 270.0), (681, "0.3515625", 239.0625),
    ],
)  # fmt: skip
def test_old_scans_have_the_field_of_view_of_their_laser(
    tmp_path: Path, count: int, resolution: str, field: float
) -> None:
    given = f"PARAM laser_front_laser_resolution {resolution} 0 nohost 0\n" if resolution else ""
    ranges = " ".join(["2.0"] * count)
    (scan,) = read_lines(log(tmp_path, given, f"FLASER {count} {ranges} 0 0 0 0 0 0 1.0 nohost 1.0\n")).scans
    assert math.degrees(scan.angle_increment * (count - 1)) == pytest.approx(field)
    assert math.degrees(scan.angle_min) == pytest.approx(-field / 2.0)


def test_old_scans_end_at_the_maximum_range_that_the_log_has(tmp_path: Path) -> None:
    path = log(tmp_path, "PARAM robot_front_laser_max 3.5 0 nohost 0\n", *drive(FRONT))
    assert read_lines(path).scans[0].range_max == 3.5


def test_lasers_three_and_four_have_no_poses(tmp_path: Path) -> None:
    line = "LASER3 5 1.0 2.0 3.0 4.0 5.0 " + END
    found = read_scan_log(log(tmp_path, *drive(ODOM), *drive(line)))
    assert found.odometry[:, 0].tolist() == [0.5, 1.0, 1.5]


def test_true_poses_are_those_of_truepos(tmp_path: Path) -> None:
    truth = "TRUEPOS {x} 1.0 0.0 {x} 0.0 0.0 " + END
    recording = read_recording(log(tmp_path, *drive(FRONT), *drive(truth)))
    assert [look.true for look in recording.looks] == [Pose2D(x, 1.0, 0.0) for x in (0.5, 1.0, 1.5)]
    assert recording.looks[0].odom == Pose2D(1.0, 0.0, 0.0)


@pytest.mark.parametrize(
    "line",
    ["RAWLASER1 99 -1.57 3.14 0.785\n", "RAWLASER1 0 0 0 0 0 0 0 9 1 2\n", "POSITIONLASER 1 0.1\n", "RLASER x\n"],
)
def test_a_malformed_message_is_refused_with_its_line(tmp_path: Path, line: str) -> None:
    with pytest.raises(InvalidInput, match=f"line 4 of .* is not a valid {line.split(maxsplit=1)[0]}"):
        read_lines(log(tmp_path, *drive(FRONT), line))
