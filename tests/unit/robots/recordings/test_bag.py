"""Bags of ROS of any format, whole, cut off and damaged."""

import bz2
import gzip
import lzma
from contextlib import suppress
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import lz4.frame
import pytest
import zstandard
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ppaas.errors import InvalidInput
from ppaas.recording.reader import RecordedMessage
from robots.recordings.bag import Bag, is_bag_file
from robots.recordings.reader import is_bag, read_recording
from tests.support.fuzzing import EXAMPLES
from tests.support.recordings.bags import KINDS, foreign_channels, make_bag

SCANS = 30
COMPRESSIONS = {
    "zst": zstandard.compress,
    "zstd": zstandard.compress,
    "gz": gzip.compress,
    "bz2": lambda data: bz2.compress(data, 1),
    "xz": lzma.compress,
    "lz4": lz4.frame.compress,
}


def single(tmp_path: Path, kind: str, scans: int = SCANS) -> Path:
    """Return a bag that is one file."""
    bag = make_bag(tmp_path / "drive", kind, scans)
    return bag / f"drive.{kind}" if bag.is_dir() else bag


def read(path: Path) -> tuple[list[RecordedMessage], Bag]:
    bag = Bag(path)
    return list(bag.messages()), bag


def check_whole(path: Path) -> None:
    """Check that all scans are read, with their odometry, and that nothing is noted."""
    recording = read_recording(path)
    assert len(recording.looks) == SCANS
    assert [look.odom.x for look in recording.looks] == pytest.approx([-0.5 + k / SCANS for k in range(SCANS)])
    assert (recording.notes, recording.has_odometry) == ((), True)


@pytest.mark.parametrize("kind", KINDS)
def test_bags_of_all_formats_are_read(tmp_path: Path, kind: str) -> None:
    check_whole(make_bag(tmp_path / "drive", kind, SCANS))


@pytest.mark.parametrize("kind", KINDS)
def test_files_are_known_by_their_content(tmp_path: Path, kind: str) -> None:
    bag = single(tmp_path, kind).rename(tmp_path / "of a friend")
    assert is_bag(bag)
    check_whole(bag)


@pytest.mark.parametrize("suffix", COMPRESSIONS)
@pytest.mark.parametrize("kind", ["bag", "mcap", "db3"])
def test_compressed_files_are_read(tmp_path: Path, kind: str, suffix: str) -> None:
    bag = single(tmp_path, kind)
    packed = bag.with_name(f"{bag.name}.{suffix}")
    packed.write_bytes(COMPRESSIONS[suffix](bag.read_bytes()))
    assert is_bag(packed)
    check_whole(packed)


@pytest.mark.parametrize("compress", ["file", "message"])
@pytest.mark.parametrize("kind", ["mcap", "db3"])
def test_what_ros2_bag_compresses_is_read_with_and_without_its_metadata(
    tmp_path: Path, kind: str, compress: str
) -> None:
    bag = make_bag(tmp_path / "drive", kind, SCANS, compress=compress)
    check_whole(bag)
    (bag / "metadata.yaml").unlink()
    check_whole(bag)
    (file,) = bag.iterdir()
    check_whole(file)


def cuts(data: bytes) -> list[int]:
    """Return places at which a file is cut: begin, end, and evenly between."""
    return sorted({len(data) * part // 16 for part in range(1, 16)} | {20, 100, len(data) - 1, len(data) - 20})


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "db3"])
def test_a_file_that_is_cut_anywhere_is_read_up_to_the_cut(tmp_path: Path, kind: str) -> None:
    whole, _ = read(path := single(tmp_path, kind))
    data, numbers = path.read_bytes(), []
    for place in cuts(data):
        path.write_bytes(data[:place])
        found, bag = read(path)
        assert found == whole[: len(found)]
        assert bag.cut == [path] or len(found) == len(whole)
        numbers.append(len(found))
    assert numbers == sorted(numbers)
    assert numbers[0] == 0
    assert numbers[-1] == len(whole)
    # The library that writes ``mcap`` puts all messages into one chunk.
    assert kind == "mcap" or 0 < numbers[len(numbers) // 2] < len(whole)


def test_a_database_that_is_cut_is_read_up_to_the_cut(tmp_path: Path) -> None:
    whole, _ = read(path := single(tmp_path, "db3"))
    data = path.read_bytes()
    path.write_bytes(data[: len(data) * 2 // 3])
    found, bag = read(path)
    assert 0 < len(found) < len(whole) and found == whole[: len(found)]
    assert bag.notes() == [f"{path} is cut off, and was read up to the cut"]


@pytest.mark.parametrize("suffix", COMPRESSIONS)
def test_a_compressed_file_that_is_cut_is_read_up_to_the_cut(tmp_path: Path, suffix: str) -> None:
    path = make_bag(tmp_path / "drive", "bag", 1000)
    whole, _ = read(path)
    packed = COMPRESSIONS[suffix](path.read_bytes())
    path.write_bytes(packed[: len(packed) * 3 // 4])
    found, bag = read(path)
    assert len(whole) // 4 < len(found) < len(whole)
    assert found == whole[: len(found)]
    assert bag.notes() == [f"{path} is cut off, and was read up to the cut"]


def test_zeros_after_the_content_are_a_cut(tmp_path: Path) -> None:
    for kind in ("bag", "mcap"):
        path = single(tmp_path, kind)
        path.write_bytes(path.read_bytes()[:-3000] + bytes(5000))
        found, bag = read(path)
        assert found and bag.cut == [path]


@pytest.mark.parametrize("kind", ["mcap", "db3"])
@pytest.mark.parametrize("metadata", ["kept", "removed", "unfinished"])
def test_files_of_a_folder_are_read_in_their_order(tmp_path: Path, kind: str, metadata: str) -> None:
    bag = make_bag(tmp_path / "drive", kind, SCANS, files=11)
    if metadata == "removed":
        (bag / "metadata.yaml").unlink()
    elif metadata == "unfinished":
        (bag / "metadata.yaml").write_text("rosbag2_bagfile_information:\n  version: [")
    check_whole(bag)
    times = [message.log_time for message in Bag(bag).messages()]
    assert times == sorted(times)


def test_a_folder_whose_last_file_is_cut_is_read_up_to_there(tmp_path: Path) -> None:
    bag = make_bag(tmp_path / "drive", "mcap", SCANS, files=3)
    (bag / "metadata.yaml").unlink()
    last = bag / "drive_2.mcap"
    last.write_bytes(last.read_bytes()[:-2000])
    recording = read_recording(bag)
    assert len(recording.looks) >= SCANS * 2 // 3
    assert recording.notes == (f"{last} is cut off, and was read up to the cut",)


@pytest.mark.parametrize("content", [b"", b"\x89MCA", bytes(5000)], ids=["empty", "begun", "zeros"])
@pytest.mark.parametrize("number", [0, 2])
def test_a_folder_is_read_without_a_file_that_has_no_content_yet(tmp_path: Path, number: int, content: bytes) -> None:
    bag = make_bag(tmp_path / "drive", "mcap", SCANS, files=3)
    blank = bag / f"drive_{number}.mcap"
    blank.write_bytes(content)
    recording = read_recording(bag)
    assert 0.6 * SCANS < len(recording.looks) < SCANS
    assert recording.notes == (f"{blank} is cut off, and was read up to the cut",)
    with pytest.raises(InvalidInput, match=r"it is (empty|no bag)"):
        read_recording(blank)


def test_a_bag_of_ros_1_whose_recorder_was_killed_is_read(tmp_path: Path) -> None:
    """It has no index, its last chunk has no sizes yet, and its name ends with ``.active``."""
    path = single(tmp_path, "bag")
    whole, _ = read(path)
    data = path.read_bytes()
    begin = data.index(b"op=\x05") - 8
    header_size = int.from_bytes(data[begin : begin + 4], "little")
    size = begin + 4 + header_size
    header = data[begin : begin + 4 + header_size]
    mark = header.index(b"size=") + len(b"size=")
    unsized = header[:mark] + bytes(4) + header[mark + 4 :]
    active = tmp_path / "drive.bag.active"
    active.write_bytes(data[:begin] + unsized + bytes(4) + data[size + 4 : size + 4000])
    found, bag = read(active)
    assert 0 < len(found) < len(whole) and found == whole[: len(found)]
    assert bag.cut == [active]


def test_channels_of_others_are_left_out_and_counted(tmp_path: Path) -> None:
    path = tmp_path / "drive.mcap"
    path.write_bytes(foreign_channels(("/log", "json", b"{}"), ("/log", "json", b"{}"), ("/odom", "protobuf", b"\x08")))
    with pytest.raises(InvalidInput) as error:
        read_recording(path)
    assert str(error.value) == (
        f"{path} has no scans (sensor_msgs/msg/LaserScan); its topics are: /log (tests.Any, 2), /odom (tests.Any, 1); "
        "2 messages on /log left out: 'json' is no encoding that is read; "
        "1 message on /odom left out: 'protobuf' is no encoding that is read"
    )


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"", "it is empty$"),
        (b"rubbish", "it is no bag: its first bytes"),
        (zstandard.compress(b"rubbish"), "it is no bag: its first bytes"),
        (b"\x28\xb5\x2f\xfd" + bytes(64), "its compressed content is damaged$"),
        (b"#ROSBAG V1.2\n" + bytes(64), "it has the format 1.x of bags; convert it by: rosbag fix$"),
        (b"SQLite format 3\x00" + bytes(4096), "it is a database, but no bag of ROS 2"),
    ],
)
def test_what_is_no_bag_is_refused_with_the_reason_alone(tmp_path: Path, content: bytes, why: str) -> None:
    path = tmp_path / "drive.bag"
    path.write_bytes(content)
    with pytest.raises(InvalidInput, match=f"^cannot read the bag {path}: {why}") as error:
        read_recording(path)
    assert not any(word in str(error.value) for word in ("reindex", "PosixPath", ".."))


def test_a_cut_without_a_message_is_named(tmp_path: Path) -> None:
    path = tmp_path / "drive.bag"
    path.write_bytes(b"#ROSBAG V2.0\n" + bytes(4096))
    with pytest.raises(InvalidInput, match=f"has no scans .* its topics are: none; {path} is cut off"):
        read_recording(path)


def test_missing_files_and_empty_folders_are_named(tmp_path: Path) -> None:
    for name in ("nothing.bag", "nothing.mcap.zstd", "nowhere/nothing.db3"):
        with pytest.raises(InvalidInput, match=f"cannot read {tmp_path / name}: no such file or directory$"):
            read_recording(tmp_path / name)
    with pytest.raises(InvalidInput, match=r"has no bag: no file in it ends with \.mcap, \.db3 or \.bag$"):
        read_recording(tmp_path)


def test_text_is_no_bag(tmp_path: Path) -> None:
    (tmp_path / "drive.log.gz").write_bytes(gzip.compress(b"FLASER 2 1 1 0 0 0 0 0 0 1 host 1\n"))
    assert not is_bag_file(tmp_path / "drive.log.gz")
    assert not is_bag(tmp_path / "missing.log")
    assert len(read_recording(tmp_path / "drive.log.gz").looks) == 1


@cache
def small(kind: str) -> bytes:
    """Return a file with four scans."""
    with TemporaryDirectory() as folder:
        return single(Path(folder), kind, 4).read_bytes()


@pytest.mark.parametrize("kind", ["bag", "bag-lz4", "mcap-ros1", "db3"])
@settings(max_examples=EXAMPLES, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(changes=st.lists(st.tuples(st.floats(0, 1, exclude_max=True), st.binary(min_size=1, max_size=8)), max_size=5))
def test_files_changed_at_random_are_read_or_refused(
    tmp_path: Path, kind: str, changes: list[tuple[float, bytes]]
) -> None:
    data = bytearray(small(kind))
    for place, content in changes:
        at = int(place * len(data))
        data[at : at + len(content)] = content
    path = tmp_path / "drive.bag"
    path.write_bytes(data)
    with suppress(InvalidInput):
        read_recording(path)
