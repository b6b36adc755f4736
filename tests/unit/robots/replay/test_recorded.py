"""Recorded drives: what is sent again, of our files and those of others, and faults of files."""

from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from mcap.writer import Writer

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, Status
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, PoseWithCovarianceStamped, Twist, Vector3
from ppaas.messages.move_base_msgs import MoveBaseActionResult
from ppaas.messages.nav_msgs import MapMetaData, OccupancyGrid
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.transforms.planar import transform_message
from ppaas.wire.ros import ros_types
from robots.replay.outcomes import NO_END, Outcomes, compare
from robots.replay.recorded import Recorded
from tests.support.recordings.bags import KINDS, foreign_channels, make_bag
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


def overlapping(*messages: tuple[str, str, dict[str, Any], int]) -> bytes:
    """Return MCAP with a chunk for each message, given with its time [s]: chunks may be in any order."""
    types, stream = ros_types("jazzy"), BytesIO()
    writer: Any = Writer(stream, chunk_size=1)
    writer.start(profile="ros2")
    for topic, kind, content, at in messages:
        schema = writer.register_schema(kind, "ros2msg", types.definition(kind).encode())
        channel = writer.register_channel(topic, "cdr", schema)
        writer.add_message(channel, START + at * 10**9, types.encode(kind, content), START)
    writer.finish()
    return stream.getvalue()


def test_messages_whose_chunks_overlap_are_sent_in_the_order_of_time(tmp_path: Path) -> None:
    """As of writers with a chunk for each topic, and of files that were put together."""
    scan_type, odom_type, twist_type = "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry", "geometry_msgs/msg/Twist"
    turned = {"transforms": [{"child_frame_id": "laser", "transform": {"rotation": {"w": 1.0}}}]}
    scans = [("/scan", scan_type, LASER, at) for at in (2, 4)]
    odometry = [("/odom", odom_type, {"header": {"frame_id": "odom"}}, at) for at in (1, 3, 5)]
    speeds = [("/cmd_vel", twist_type, {"linear": {"x": 0.5}}, at) for at in (6, 2)]
    static = ("/tf_static", "tf2_msgs/msg/TFMessage", turned, -3600)
    recorded = Recorded(written(tmp_path, overlapping(*scans, *odometry, *speeds, static))).read()
    sent = [(one.topic, one.after) for one in recorded.inputs()]
    assert sent[0] == ("tf_static", -3601.0), "before the begin, so at once"
    assert sent[1:] == [("odom", 0.0), ("scan", 1.0), ("odom", 2.0), ("scan", 3.0), ("odom", 4.0)]
    assert recorded.seconds == 5.0
    assert [velocity.at for velocity in recorded.outcomes.velocities] == [1.0, 5.0]


def test_file_that_was_cut_off(tmp_path: Path) -> None:
    path = written(tmp_path, mcap(entry("scan", scan()), finish=False))
    recorded = Recorded(path).read()
    assert recorded.notes == [f"{path} is cut off, and was read up to the cut"]
    assert recorded.counts["scan"] == 1


@pytest.mark.parametrize("kind", KINDS)
def test_bags_of_all_formats_are_sent_in_the_order_of_their_files(tmp_path: Path, kind: str) -> None:
    bag = make_bag(tmp_path / "drive", kind, scans=12, files=3 if kind in ("mcap", "db3") else 1)
    recorded = Recorded(bag).read()
    assert (recorded.counts, recorded.notes) == ({"scan": 12, "odom": 12}, [])
    times = [one.after for one in recorded.inputs() if one.topic == "scan"]
    assert times == pytest.approx([number / 10 for number in range(12)])


def test_channels_in_json_are_read_and_others_noted(tmp_path: Path) -> None:
    channels = (("/scan", "json", b'{"ranges": [1.0]}'), ("/log", "protobuf", b"\x00"))
    recorded = Recorded(written(tmp_path, foreign_channels(*channels))).read()
    assert recorded.counts == {"scan": 1}
    assert recorded.notes == ["1 message on /log left out: 'protobuf' is no encoding that is read"]


def test_messages_of_another_type_are_left_out_and_counted(tmp_path: Path) -> None:
    data = mcap(entry("scan", twist()), entry("scan", scan(), 1))
    recorded = Recorded(written(tmp_path, data)).read()
    assert recorded.counts == {"scan": 1}
    assert [reason.split(":")[0] for reason in recorded.skipped] == ["/scan"]


def test_unusable_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="cannot read"):
        Recorded(tmp_path / "missing.mcap").read()
    with pytest.raises(
        InvalidInput, match=r"nothing to send .* Its topics are: /cmd_vel \(geometry_msgs/msg/Twist, 1\)"
    ):
        Recorded(written(tmp_path, mcap(entry("cmd_vel", twist(), up=False)))).read()
    with pytest.raises(InvalidInput, match="it is no bag: its first bytes"):
        Recorded(written(tmp_path, b"x" * 100)).read()


def drive(offset: float = 0.0, *, goals: tuple[tuple[str, Status], ...] = ()) -> Outcomes:
    """Return a drive straight ahead, off by a distance to the left."""
    found = Outcomes()
    for number in range(10):
        pose = PoseWithCovariance(Pose.of(Pose2D(0.1 * number, offset)))
        header = Header(stamp=Time(number + 1), frame_id="map")
        found.take("amcl_pose", PoseWithCovarianceStamped(header, pose), 0.1 * number)
        found.take("cmd_vel", Twist(linear=Vector3(x=0.5 + offset)), 0.1 * number + 0.01)
    for goal, status in goals:
        found.take("move_base/result", MoveBaseActionResult(Header(), GoalStatus(GoalID(id=goal), status)), 1.0)
    return found


def test_equal_drives_do_not_differ() -> None:
    goals = (("g1", Status.SUCCEEDED),)
    found = compare(drive(goals=goals), drive(goals=goals))
    assert (found.poses, found.velocities, found.most_distance, found.linear) == (10, 10, 0.0, 0.0)
    assert not found.differs
    assert found.words()[-1] == "Goal 'g1' ended with SUCCEEDED, as recorded."


def test_far_poses_differ() -> None:
    found = compare(drive(), drive(0.5))
    assert (found.median_distance, found.most_distance) == (0.5, 0.5)
    assert found.linear == pytest.approx(0.5)
    assert found.differs


def test_goal_that_ends_otherwise_differs() -> None:
    found = compare(drive(goals=(("g1", Status.SUCCEEDED),)), drive(goals=(("g1", Status.ABORTED),)))
    assert found.differs
    assert found.words()[-1] == "Goal 'g1' ended with ABORTED, but was recorded as SUCCEEDED."
    assert compare(drive(goals=(("g1", Status.ABORTED),)), drive()).goals == {"g1": ("ABORTED", NO_END)}


def test_goals_without_an_id_are_matched_by_their_order() -> None:
    recorded = drive(goals=(("a-1", Status.SUCCEEDED), ("named", Status.PREEMPTED), ("a-2", Status.ABORTED)))
    replayed = drive(goals=(("b-1", Status.SUCCEEDED), ("named", Status.PREEMPTED), ("b-2", Status.ABORTED)))
    assert not compare(recorded, replayed).differs


def test_nothing_in_common_is_said_so() -> None:
    found = compare(drive(), Outcomes())
    assert found.words() == ["No pose can be compared: there is no scan that both localized."]
    assert not found.differs
