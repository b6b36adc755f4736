"""Frames between an agent and the recorder of its machine."""

import msgspec


class RecordedBatch(msgspec.Struct, tag="recorded"):
    """A batch of messages of a robot, as `ppaas.recording.batches` packs it."""

    user: str
    robot: str
    batch: bytes


class Left(msgspec.Struct, tag="left"):
    """The container of a robot has ended: its files are finished."""

    user: str
    robot: str


ToRecorder = RecordedBatch | Left


class Told(msgspec.Struct, tag="told"):
    """Answer of the recorder to the clone of a robot.

    Parameters
    ----------
    user, robot : str
    problem : str
        Why it does not record; empty if it does.
    forgotten : bool
        Whether it has none of the last messages of latched topics.
    """

    user: str
    robot: str
    problem: str = ""
    forgotten: bool = False
