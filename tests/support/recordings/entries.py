"""Recorded messages for tests, and files of them."""

from io import BytesIO

from ppaas.messages import encode, type_name
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Header, String, Time
from ppaas.messages.geometry_msgs import Twist, Vector3
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.recording.batches import About, BatchedMessage
from ppaas.recording.reader import McapReader
from ppaas.recording.reader import RecordedMessage as McapMessage
from ppaas.recording.writer import McapFile, encoded

SECOND = 10**9
START = 1_800_000_000 * SECOND
"""Time of the first message [ns since the epoch]."""

ABOUT = About("tb1", "9.9", "office", "v1", {"map": "office", "model": "turtlebot2"}, {"amcl": {"max_particles": 500}})


def scan(number: int = 0) -> LaserScan:
    """Return a scan with four beams, one of them without a reading."""
    header = Header(stamp=Time(1_800_000_000 + number), frame_id="base_link")
    return LaserScan(
        header, angle_min=0.0, angle_max=0.375, angle_increment=0.125, range_min=0.125, range_max=9.0,
        ranges=[1.0, 2.5, None, 0.25],
    )  # fmt: skip


def twist(speed: float = 0.5) -> Twist:
    """Return a velocity."""
    return Twist(linear=Vector3(x=speed))


def entry(
    topic: str, message: Message, number: int = 0, *, up: bool = True, latched: bool = False, kept: bool = False
) -> BatchedMessage:
    """Return a message that arrived a number of seconds after `START`."""
    at = START + number * SECOND
    return BatchedMessage(topic, type_name(message), up, latched, kept or latched, at, at, encode(message))


def text(topic: str, content: str, number: int = 0, *, latched: bool = True) -> BatchedMessage:
    """Return a text on a topic."""
    return entry(topic, String(content), number, latched=latched, up=False)


def mcap(*entries: BatchedMessage, finish: bool = True) -> bytes:
    """Return a file with messages; without its end if it is not finished."""
    stream = BytesIO()
    file = McapFile(stream, ABOUT)
    for one in entries:
        file.add(encoded(one))
    file.flush()
    if finish:
        file.finish()
    return stream.getvalue()


def read(data: bytes) -> tuple[McapReader, list[McapMessage]]:
    """Return the reader of a file, at its end, and the messages."""
    reader = McapReader(BytesIO(data))
    return reader, list(reader.messages())
