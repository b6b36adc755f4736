"""Messages of bags as objects, by the definitions in the bag, as robots of any age and release recorded them."""

import struct
from collections import Counter
from typing import Any

from ppaas.distribution import install_hint
from ppaas.errors import InvalidInput
from ppaas.recording.reader import RecordedChannel, RecordedMessage


def full_type(name: str) -> str:
    """Return the name of a type, of ROS 1, ROS 2 or its DDS, as ``package/msg/Name``."""
    if "::" in name:
        name = name.replace("::dds_::", "::").removesuffix("_").replace("::", "/")
    package, _, rest = name.partition("/")
    return name if "/" in rest else f"{package}/msg/{rest}"


class BagObjects:
    """Decoder of the messages of one bag.

    Attributes
    ----------
    damaged : Counter of str
        Number of messages that are none of their type, by topic.

    Raises
    ------
    InvalidInput
        The extra ``bags`` is not installed.
    """

    def __init__(self) -> None:
        try:
            from rosbags import typesys  # noqa: PLC0415 - of the extra bags
            from rosbags.serde import SerdeError  # noqa: PLC0415
        except ModuleNotFoundError as error:
            raise InvalidInput(f"reading bags of ROS needs the extra bags: {install_hint('bags')}") from error
        self._typesys = typesys
        self._errors = (SerdeError, struct.error, ValueError, LookupError, OverflowError, AssertionError)
        self._stores: dict[tuple[str, str, bytes], Any] = {}
        self.damaged: Counter[str] = Counter()

    def read(self, message: RecordedMessage) -> Any | None:
        """Return a message of ROS 1 or ROS 2 as an object of its fields; None if it is damaged, which is counted."""
        channel, kind = message.channel, full_type(message.channel.type)
        store = self._store(channel, kind)
        try:
            read = store.deserialize_ros1 if channel.encoding == "ros1" else store.deserialize_cdr
            return read(message.data, kind)
        except self._errors:
            self.damaged[channel.topic] += 1
            return None

    def _store(self, channel: RecordedChannel, kind: str) -> Any:
        """Return the types of a channel: of its definition, or of the release if it has none that can be read."""
        key = (channel.encoding, kind, channel.definition)
        if key not in self._stores:
            stores = self._typesys.Stores
            release = self._typesys.get_typestore(stores.ROS1_NOETIC if channel.encoding == "ros1" else stores.LATEST)
            described = self._described(channel, kind)
            complete = described is not None and _has_fields_of(described.fielddefs, release.fielddefs)
            self._stores[key] = described if complete else release
        return self._stores[key]

    def _described(self, channel: RecordedChannel, kind: str) -> Any | None:
        if not channel.definition:
            return None
        text = channel.definition.decode("utf-8", "replace")
        store = self._typesys.get_typestore(self._typesys.Stores.EMPTY)
        try:
            store.register(self._parsed(text, kind, idl=channel.schema_encoding == "ros2idl"))
        except (self._typesys.TypesysError, *self._errors):
            return None
        return store if kind in store.types else None

    def _parsed(self, text: str, kind: str, *, idl: bool) -> Any:
        if not idl:
            return self._typesys.get_types_from_msg(text, kind)
        types: dict[str, Any] = {}
        # Each of several parts begins with the line "IDL: package/msg/Name".
        for part in filter(str.strip, text.split("=" * 80 + "\n")):
            types |= self._typesys.get_types_from_idl(part.split("\n", 1)[-1] if part.startswith("IDL:") else part)
        return types


def _has_fields_of(described: dict[str, Any], release: dict[str, Any]) -> bool:
    """Return whether described types have all fields that the release knows; others come from a damaged definition."""
    names = {kind: {name for name, _ in fields} for kind, (_, fields) in described.items()}
    return all({name for name, _ in release[kind][1]} <= found for kind, found in names.items() if kind in release)
