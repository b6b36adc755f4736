"""Numbers, names and typed-out commands of recording.md are those of the code."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from engine.recorder import robot_recorder
from engine.recorder.robot_recorder import FLUSH_PERIOD
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Point, Pose, PoseWithCovariance, PoseWithCovarianceStamped, Quaternion
from ppaas.messages.nav_msgs import MapMetaData, OccupancyGrid
from ppaas.nodes.recorder.node import PERIOD, PERIODS, SAMPLE_PERIOD
from ppaas.recording.parameters import HEAVY, MOST_MB, MOST_MINUTES, RecorderParameters
from ppaas.recording.writer import ABOUT, DIRECTION, PARAMETERS, ROBOT_FILE
from robots.cli.command_parser import CommandParser
from robots.cli.commands import replay, robot
from robots.replay.outcomes import FAR, FAR_TURNED
from tests.support.documents import table, text_of
from tests.support.recordings.entries import entry, mcap, scan
from tests.support.sources import ROOT

PAGE = "docs/recording.md"
TEXT = re.sub(r"\s+", " ", text_of(PAGE))


def test_parameters_are_those_of_the_node() -> None:
    defaults = RecorderParameters()
    shown = {row[0].strip("`"): row[1:] for row in table(PAGE, "parameter of the node", "default", "meaning")}
    assert set(shown) == set(defaults.__struct_fields__)
    assert shown["ring_minutes"][0] == f"{defaults.ring_minutes:g}"
    assert f"at most {MOST_MINUTES:g}" in shown["ring_minutes"][1]
    assert shown["max_mb"][0] == f"{defaults.max_mb}"
    assert f"at most {MOST_MB}" in shown["max_mb"][1]


def test_numbers_are_those_of_the_code() -> None:
    assert f"segments of {robot_recorder.SEGMENT:g} s" in TEXT
    assert f"at most {robot_recorder.MOST_BYTES >> 20} MiB and takes" in TEXT
    assert f"have at most {robot_recorder.MOST_USER_BYTES >> 20} MiB" in TEXT
    assert FLUSH_PERIOD + PERIOD < 3.0 and "up to the last three seconds" in TEXT
    assert sorted(PERIODS.values()) == [0.2, 2.0] and "feedback five times a second, the plan every two" in TEXT
    assert SAMPLE_PERIOD == 5.0 and "a local costmap every five seconds" in TEXT
    assert f"more than {FAR:g} m or {FAR_TURNED:g} rad" in TEXT


def test_names_in_files_are_those_of_the_code() -> None:
    for name in (ABOUT, DIRECTION, PARAMETERS, ROBOT_FILE):
        assert f"`{name}`" in TEXT
    for topic in ("camera/*", "cloud_in", "particlecloud", "key_frames", "local_plan", "diagnostics"):
        assert topic in HEAVY and f"`{topic}`" in TEXT


def test_typed_out_commands_are_understood() -> None:
    commands = re.findall(r"^ppaas (robot|replay) ([^#&\n]*)", text_of(PAGE), re.MULTILINE)
    assert len(commands) >= 9
    for name, words in commands:
        parser = CommandParser()
        (robot if name == "robot" else replay).configure(parser)
        parser.parse_args([word.strip("'") for word in words.split()])


ORIGIN = Pose(Point(x=0.0, y=0.0, z=0.0), Quaternion(x=0.0, y=0.0, z=0.0, w=1.0))
PLOTTED = {
    "map": OccupancyGrid(
        Header(frame_id="map"), MapMetaData(resolution=0.5, width=2, height=1, origin=ORIGIN), [0, 100]
    ),
    "scan": scan(),
    "amcl_pose": PoseWithCovarianceStamped(Header(frame_id="map"), PoseWithCovariance(ORIGIN)),
}


@pytest.mark.parametrize(
    ("topics", "said"),
    [
        (("map", "scan", "amcl_pose"), "has no plan: the robot had no goal"),
        (("scan", "amcl_pose"), "has no message of /map: record a drive"),
        ((), "has no message of /map, /scan, /amcl_pose: record a drive"),
    ],
)
def test_the_plot_of_a_recording_says_what_the_recording_lacks(
    tmp_path: Path, topics: tuple[str, ...], said: str
) -> None:
    recording, image = tmp_path / "drive.mcap", tmp_path / "drive.png"
    recording.write_bytes(mcap(*(entry(topic, PLOTTED[topic], number) for number, topic in enumerate(topics))))
    command = [sys.executable, "docs/examples/plot_recording.py", recording, image]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120, check=False)
    assert said in done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    assert image.exists() is (done.returncode == 0) is (len(topics) == 3)
