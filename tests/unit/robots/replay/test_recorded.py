"""Recorded drives: what is sent again, of our files and those of others, and faults of files."""

from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from mcap.writer import Writer

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, PoseWithCovarianceStamped
from ppaas.messages.nav_msgs import MapMetaData, OccupancyGrid
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.transforms.planar import transform_message
from ppaas.wire.ros import ros_types
from robots.replay.recorded import Recorded
from tests.support.recordings.entries import START, entry, mcap, scan, twist

MAP = OccupancyGrid(Header(frame_id="map"), MapMetaData(0.5, 2, 1, Pose.of(Pose2D(0.0, 0.0))), [0, 100])
ESTIMATE = PoseWithCovarianceStamped(
    Header(stamp=Time(5), frame_id="map"), PoseWithCovariance(Pose.of(Pose2D(1.0, 2.0)))
)
TF = TFMessage(
    [
        transform_message("map", "odom", Pose2D(0.0, 0.0), Time(1)),
        transform_message("odom", "base_link", Pose2D(1.0, 0.0), Time(1)),
    ]
)


def written(tmp_path: Path, data: bytes) -> Path:
    path = tmp_path / "drive.mcap"
    path.write_bytes(data)
    return path


def foreign(encoding: str, *messages: tuple[str, str, dict[str, Any]]) -> bytes:
    """Return a file of somebody else, of messages given as topic, type and content."""
    types = ros_types("noetic" if encoding == "ros1" else "jazzy")
    stream = BytesIO()
    writer: Any = Writer(stream)
    writer.start(profile=encoding)
    for number, (topic, kind, content) in enumerate(messages):
        schema = writer.register_schema(kind, f"{encoding}msg", types.definition(kind).encode())
        channel = writer.register_channel(topic, "ros1" if encoding == "ros1" else "cdr", schema)
        writer.add_message(channel, START + number * 10**8, types.encode(kind, content), START)
    writer.finish()
    return stream.getvalue()


def test_own_recording(tmp_path: Path) -> None:
    data = mcap(
        entry("map", MAP, latched=True, up=False),
        entry("scan", scan(1), 1),
        entry("tf", TF, 1, up=False),
        entry("amcl_pose", ESTIMATE, 2, up=False),
        entry("cmd_vel", twist(), 3, up=False),
        entry("robots", twist(), 3),
    )
    recorded = Recorded(written(tmp_path, data)).read()
    assert [(one.topic, one.after) for one in recorded.inputs()] == [("scan", 1.0)]
    assert recorded.counts == {"scan": 1}
    assert recorded.initial_pose == (1.0, 2.0, 0.0)
    assert recorded.grid is not None
    assert recorded.grid.data.tolist() == [[0, 100]]
    assert recorded.file is not None
    assert (recorded.file.map, recorded.file.model) == ("office", "turtlebot2")
    assert list(recorded.outcomes.poses) == [5 * 10**9]
    assert recorded.seconds == 3.0


LASER = {"header": {"frame_id": "base_scan"}, "ranges": [1.0, 2.0], "angle_max": 0.1, "angle_increment": 0.1}


@pytest.mark.parametrize(
    ("encoding", "package"), [("ros1", "sensor_msgs/LaserScan"), ("ros2", "sensor_msgs/msg/LaserScan")]
)
def test_bags_of_others(tmp_path: Path, encoding: str, package: str) -> None:
    moved = {"header": {"frame_id": "odom"}, "child_frame_id": "base_footprint", "transform": {"rotation": {"w": 1.0}}}
    located = {"header": {"frame_id": "/map"}, "child_frame_id": "odom", "transform": {"rotation": {"w": 1.0}}}
    data = foreign(
        encoding,
        ("/front/scan", package, LASER),
        ("/tf", "tf2_msgs/TFMessage", {"transforms": [located, moved]}),
        ("/tf", "tf2_msgs/TFMessage", {"transforms": [located]}),
        ("/rosout_2", "std_msgs/String", {"data": "x"}),
    )
    recorded = Recorded(written(tmp_path, data), {"front/scan": "scan"}).read()
    first, second = recorded.inputs()
    assert isinstance(first.message, LaserScan)
    assert first.message.ranges == [1.0, 2.0]
    assert isinstance(second.message, TFMessage)
    assert [each.child_frame_id for each in second.message.transforms] == ["base_footprint"]
    assert (recorded.grid, recorded.file) == (None, None)


def test_file_that_was_cut_off(tmp_path: Path) -> None:
    recorded = Recorded(written(tmp_path, mcap(entry("scan", scan()), finish=False))).read()
    assert (recorded.cut, recorded.counts["scan"]) == (True, 1)


def test_messages_of_another_type_are_left_out_and_counted(tmp_path: Path) -> None:
    data = mcap(entry("scan", twist()), entry("scan", scan(), 1))
    recorded = Recorded(written(tmp_path, data)).read()
    assert recorded.counts == {"scan": 1}
    assert [reason.split(":")[0] for reason in recorded.skipped] == ["/scan"]


def test_unusable_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="cannot read"):
        Recorded(tmp_path / "missing.mcap").read()
    with pytest.raises(InvalidInput, match="nothing to send"):
        Recorded(written(tmp_path, mcap(entry("cmd_vel", twist(), up=False)))).read()
    with pytest.raises(InvalidInput, match="not an MCAP file"):
        Recorded(written(tmp_path, b"x" * 100)).read()
