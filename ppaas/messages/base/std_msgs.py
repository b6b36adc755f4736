"""``std_msgs``, and the time types of ROS."""

import math
from typing import Annotated

from msgspec import Meta, field

from ppaas.messages.base.message import Empty, Message, UInt32

__all__ = ["Bool", "Duration", "Empty", "Float64", "FrameId", "Header", "String", "Time"]

FrameId = Annotated[str, Meta(pattern=r"^[^\x00-\x1f\x7f-\x9f\u2028\u2029]*\Z", max_length=255)]
"""Name of a frame. tf2 takes any text; here it has no control characters, which logs and terminals would execute."""


class Time(Message):
    """Stamp: seconds and nanoseconds since the epoch."""

    secs: int = 0
    nsecs: int = 0

    @classmethod
    def of(cls, seconds: float) -> "Time":
        """Return the stamp of a time in seconds since the epoch."""
        whole = math.floor(seconds)
        return cls(whole, int((seconds - whole) * 1e9))

    def seconds(self) -> float:
        """Return the time in seconds since the epoch."""
        return self.secs + self.nsecs * 1e-9


class Duration(Message):
    """Duration: seconds and nanoseconds."""

    secs: int = 0
    nsecs: int = 0

    @classmethod
    def of(cls, seconds: float) -> "Duration":
        """Return a duration in seconds as a message."""
        whole = math.floor(seconds)
        return cls(whole, int((seconds - whole) * 1e9))

    def seconds(self) -> float:
        """Return the duration in seconds."""
        return self.secs + self.nsecs * 1e-9


class Header(Message):
    """``std_msgs/Header``."""

    seq: UInt32 = 0
    stamp: Time = field(default_factory=Time)
    frame_id: FrameId = ""


class String(Message):
    """``std_msgs/String``."""

    data: str


class Bool(Message):
    """``std_msgs/Bool``."""

    data: bool


class Float64(Message):
    """``std_msgs/Float64``."""

    data: float
