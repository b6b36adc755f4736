"""``diagnostic_msgs``: how the parts of a robot are."""

from enum import IntEnum
from typing import Annotated, ClassVar

from msgspec import Meta, field

from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Header

Byte = Annotated[int, Meta(extra={"ros": "byte"})]


class DiagnosticLevel(IntEnum):
    """Levels of ``diagnostic_msgs/DiagnosticStatus``."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


class KeyValue(Message):
    """``diagnostic_msgs/KeyValue``."""

    key: str
    value: str


class DiagnosticStatus(Message):
    """``diagnostic_msgs/DiagnosticStatus``: ``name`` is the part, ``message`` how it is in words."""

    constants: ClassVar[type[IntEnum] | None] = DiagnosticLevel

    level: Byte
    name: str
    message: str = ""
    hardware_id: str = ""
    values: list[KeyValue] = field(default_factory=list)


class DiagnosticArray(Message):
    """``diagnostic_msgs/DiagnosticArray``."""

    header: Header = field(default_factory=Header)
    status: list[DiagnosticStatus] = field(default_factory=list)
