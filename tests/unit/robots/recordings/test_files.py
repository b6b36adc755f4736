"""Files of bags, and their messages as objects."""

from pathlib import Path

import pytest

from ppaas.errors import InvalidInput
from ppaas.recording.reader import RecordedChannel, RecordedMessage
from robots.recordings.bag import Bag
from robots.recordings.bag_objects import BagObjects, full_type
from robots.recordings.files import files_of
from tests.support.recordings.bags import SCAN, make_bag, room


def folder(tmp_path: Path, *names: str, listed: tuple[str, ...] = (), more: str = "") -> Path:
    for name in names:
        (tmp_path / name).write_bytes(b"")
    if listed:
        lines = "".join(f"  - {name}\n" for name in listed)
        (tmp_path / "metadata.yaml").write_text(f"rosbag2_bagfile_information:\n  relative_file_paths:\n{lines}{more}")
    return tmp_path


def names(path: Path) -> list[str]:
    return [file.name for file in files_of(path).paths]


def test_numbers_in_names_are_ordered_by_value(tmp_path: Path) -> None:
    files = [f"drive_{number}.mcap" for number in (0, 1, 2, 10, 11)]
    assert names(folder(tmp_path, *reversed(files), "notes.txt")) == files


def test_split_bags_of_ros_1_are_one_recording(tmp_path: Path) -> None:
    files = [
        "drive_2026-11-28-10-00-00_0.bag",
        "drive_2026-11-28-10-05-00_1.bag",
        "drive_2026-11-28-10-10-00_2.bag.active",
    ]
    assert names(folder(tmp_path, *reversed(files))) == files


def test_metadata_gives_the_order_and_later_files_follow(tmp_path: Path) -> None:
    listed = ("b_1.mcap", "run/b_0.mcap", "..\\run\\b_3.mcap")
    assert names(folder(tmp_path, "b_0.mcap", "b_1.mcap", "b_2.mcap", "b_3.mcap", "other.mcap", listed=listed)) == [
        "b_1.mcap",
        "b_0.mcap",
        "b_3.mcap",
        "b_2.mcap",
    ]


def test_files_that_were_compressed_or_decompressed_since_are_found(tmp_path: Path) -> None:
    listed = ("b_0.mcap.zstd", "b_1.mcap")
    assert names(folder(tmp_path, "b_0.mcap", "b_1.mcap.gz", listed=listed)) == ["b_0.mcap", "b_1.mcap.gz"]


def test_files_that_were_all_renamed_are_read_without_their_metadata(tmp_path: Path) -> None:
    found = files_of(folder(tmp_path, "hall_1.mcap", "hall_0.mcap", listed=("drive_0.mcap", "drive_1.mcap")))
    assert [file.name for file in found.paths] == ["hall_0.mcap", "hall_1.mcap"]
    assert found.notes == (f"metadata.yaml of {tmp_path} lists other files: it is not used",)
    with pytest.raises(InvalidInput, match="has several bags"):
        files_of(folder(tmp_path, "other.mcap"))


def test_hidden_files_of_other_systems_are_no_bags(tmp_path: Path) -> None:
    assert names(folder(tmp_path, "._drive_0.mcap", "drive_0.mcap", ".drive_1.mcap")) == ["drive_0.mcap"]


def test_missing_files_are_noted(tmp_path: Path) -> None:
    found = files_of(folder(tmp_path, "b_1.db3", listed=("b_0.db3", "b_1.db3")))
    assert [file.name for file in found.paths] == ["b_1.db3"]
    assert found.notes == (f"metadata.yaml of {tmp_path} lists b_0.db3, which is not there",)
    (tmp_path / "b_1.db3").unlink()
    with pytest.raises(InvalidInput, match=r"lists b_0\.db3, which is not there"):
        files_of(tmp_path)


def test_a_folder_of_several_bags_is_refused_by_their_names(tmp_path: Path) -> None:
    with pytest.raises(
        InvalidInput, match=r"has several bags \(a_1.mcap, b.mcap\) and no metadata.yaml of them: name one"
    ):
        files_of(folder(tmp_path, "a_0.mcap", "a_1.mcap", "b.mcap"))


def test_compression_of_messages_that_is_not_known_is_refused(tmp_path: Path) -> None:
    more = "  compression_format: lz4\n  compression_mode: MESSAGE\n"
    with pytest.raises(InvalidInput, match="are compressed by lz4, and only zstd is known: run ros2 bag convert"):
        files_of(folder(tmp_path, "b_0.db3", listed=("b_0.db3",), more=more))


@pytest.mark.parametrize("definition", ["kept", "missing", "nonsense", "damaged"])
@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_messages_are_read_by_the_definition_in_the_bag_or_by_the_release(
    tmp_path: Path, kind: str, definition: str
) -> None:
    messages = [each for each in Bag(make_bag(tmp_path / "drive", kind, 1)).messages() if each.channel.topic == "/scan"]
    (message,) = messages
    text = {"kept": message.channel.definition, "missing": b"", "nonsense": b"uint99 @@", "damaged": b"float32 ranges"}[
        definition
    ]
    objects = BagObjects()
    found = objects.read(message._replace(channel=message.channel._replace(definition=text)))
    assert found is not None and found.ranges.tolist() == room(-0.5).tolist()
    assert not objects.damaged


def test_types_that_the_release_lacks_are_read() -> None:
    channel = RecordedChannel("/old", "cdr", "old_msgs/Pair", "ros2msg", b"uint8 first\nfloat32 second\n", {})
    found = BagObjects().read(RecordedMessage(channel, 0, 0, 0, b"\x00\x01\x00\x00\x07\x00\x00\x00\x00\x00\x80\x3f"))
    assert (found.first, found.second) == (7, 1.0)


@pytest.mark.parametrize(
    "name",
    [
        "sensor_msgs/LaserScan",
        "sensor_msgs/msg/LaserScan",
        "sensor_msgs::msg::dds_::LaserScan_",
        "sensor_msgs::msg::LaserScan",
    ],
)
def test_types_are_known_by_their_names_in_ros_1_ros_2_and_dds(name: str) -> None:
    assert full_type(name) == SCAN


def test_idl_is_read() -> None:
    text = b"=" * 80 + b"\nIDL: a/msg/B\nmodule a { module msg { struct B { long first; }; }; };\n"
    channel = RecordedChannel("/idl", "cdr", "a/msg/B", "ros2idl", text, {})
    assert BagObjects().read(RecordedMessage(channel, 0, 0, 0, b"\x00\x01\x00\x00\x05\x00\x00\x00")).first == 5


def test_damaged_messages_are_counted() -> None:
    objects = BagObjects()
    assert (
        objects.read(
            RecordedMessage(RecordedChannel("/scan", "cdr", SCAN, "", b"", {}), 0, 0, 0, b"\x00\x01\x00\x00\x01")
        )
        is None
    )
    assert objects.damaged == {"/scan": 1}
