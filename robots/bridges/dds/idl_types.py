"""Types of messages as Cyclone DDS has them, by which it matches topics and checks bytes; `RosTypes` codes messages."""

from dataclasses import dataclass
from types import new_class
from typing import Any

from ppaas.wire.ros import RosTypes


class IdlTypes:
    """Classes of IDL for the messages of a release.

    Parameters
    ----------
    types : RosTypes
        Types of the release.
    """

    def __init__(self, types: RosTypes) -> None:
        from cyclonedds.idl import IdlStruct  # noqa: PLC0415 - of the extra ros2
        from cyclonedds.idl import types as idl  # noqa: PLC0415

        self._types, self._struct, self._idl = types, IdlStruct, idl
        self._classes: dict[str, Any] = {}

    def of(self, name: str) -> Any:
        """Return the class of a message, given its full name such as ``nav_msgs/msg/Path``."""
        if name not in self._classes:
            package, folder, short = name.split("/")
            annotations = {field.name: self._field(field) for field in self._types.fields(name)}
            body = {"__annotations__": annotations, "__module__": __name__}
            typename = f"{package}.{folder}.dds_.{short}_"
            created = new_class(f"{short}_", (self._struct,), {"typename": typename}, lambda space: space.update(body))
            self._classes[name] = dataclass(created)
        return self._classes[name]

    def _field(self, field: Any) -> Any:
        idl = self._idl
        if field.type == "string":
            single = idl.bounded_str[field.text_bound] if field.text_bound else str
        elif field.type == "bool":
            single = bool
        elif field.type in ("byte", "char"):
            single = idl.uint8
        else:
            single = self.of(field.type) if "/" in field.type else getattr(idl, field.type)
        if field.length is None:
            return single
        if field.length:
            return idl.array[single, field.length]
        return idl.sequence[single, field.bound] if field.bound else idl.sequence[single]
