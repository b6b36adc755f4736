"""Batches of recorded messages, as a clone hands them to the recorder of its machine."""

from typing import Any

import msgspec

from ppaas.errors import MalformedMessage


class BatchedMessage(msgspec.Struct, array_like=True, frozen=True, gc=False):
    """A recorded message.

    Parameters
    ----------
    topic, type : str
        Topic, and type of the message as spelled in ROS 1.
    up : bool
        Whether it came from outside: from the robot, an operator or another robot, and not from the clone.
    latched : bool
        Whether later subscribers of the topic get its last message.
    kept : bool
        Whether it is repeated at the begin of each file: the last message of a latched topic, or a goal in progress.
    log_time, publish_time : int
        Time of its arrival, and its stamp or the same time [ns since the epoch].
    payload : bytes
        The message as JSON; empty if it is no longer repeated.
    """

    topic: str
    type: str
    up: bool
    latched: bool
    kept: bool
    log_time: int
    publish_time: int
    payload: bytes


class About(msgspec.Struct, frozen=True):
    """Robot, map and parameters of a recording, for a replay.

    Parameters
    ----------
    robot : str
        Id of the robot.
    software : str
        Version of the cloud.
    map, map_version : str
        Map of the clone; the version is empty if the robot makes a new map.
    file : dict
        The robot file.
    parameters : dict
        Parameters in use by node, defaults included.
    """

    robot: str
    software: str
    map: str = ""
    map_version: str = ""
    file: dict[str, Any] = {}
    parameters: dict[str, Any] = {}


class Batch(msgspec.Struct, frozen=True):
    """Messages of half a second, with what is to be done with them.

    Parameters
    ----------
    about : About
    ring_seconds : float
        Length of the ring that the messages are for [s].
    ring_bytes : int
        Largest size of the ring [bytes].
    ring_topics : tuple of str
        Globs of its topics; none if there is no ring.
    recording : str
        Id of the recording that the messages are for; empty for none.
    recording_topics : tuple of str
        Globs of its topics.
    entries : list of BatchedMessage
    """

    about: About
    ring_seconds: float = 0.0
    ring_bytes: int = 0
    ring_topics: tuple[str, ...] = ()
    recording: str = ""
    recording_topics: tuple[str, ...] = ()
    entries: list[BatchedMessage] = []


_encoder = msgspec.msgpack.Encoder()
_decoder = msgspec.msgpack.Decoder(Batch)


def batch_bytes(batch: Batch) -> bytes:
    """Return a batch as bytes."""
    return _encoder.encode(batch)


def batch_of(data: bytes) -> Batch:
    """Return a batch from its bytes.

    Raises
    ------
    MalformedMessage
        They are not a batch.
    """
    try:
        return _decoder.decode(data)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise MalformedMessage(f"not a batch of recorded messages: {error}") from error
