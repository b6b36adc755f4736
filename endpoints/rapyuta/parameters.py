"""Parameters of ROS 1 in a container: free ones of the clone, and nodes' parameters, which are in the robot's file."""

from dataclasses import dataclass, field
from typing import Any

import msgspec
from pydantic import ValidationError
from starlette.concurrency import run_in_threadpool

from endpoints.rapyuta.clone import Container
from endpoints.rapyuta.known_nodes import SECTIONS
from endpoints.rest.robots.schemas import STORED_FIELDS, RobotFile
from ppaas.errors import InvalidParameter, NotFound, PPaaSError
from ppaas.messages import decode, rosapi
from ppaas.nodes.parameter_server.tree import path_of, read_value
from storage.ports import RobotStore
from storage.records import RobotRecord

MOVE_BASE = "move_base"
"""Node below whose name ROS 1 has the parameters of planners and costmaps, which have separate sections here."""

_encoder = msgspec.json.Encoder()


def section_of(container: Container, name: str) -> tuple[str, ...]:
    """Return the parts of a parameter's name as the robot's file has them: section, then name.

    Raises
    ------
    InvalidParameter
        The name is not one of a parameter.
    """
    node, *rest = path_of(container.bare_name(name)) or ("",)
    node = container.node_name(node)
    if node == MOVE_BASE and len(rest) > 1:
        node, rest = rest[0], [rest[-1]]
    return (SECTIONS.get(node, node), *rest)


@dataclass
class FileChange:
    """Changes of the parameters in a robot's file; a parameter without a value is removed."""

    values: dict[tuple[str, str], Any] = field(default_factory=dict)
    sections: set[str] = field(default_factory=set)
    removed: set[tuple[str, str]] = field(default_factory=set)

    def __bool__(self) -> bool:
        """Return whether there is a change."""
        return bool(self.values or self.sections or self.removed)

    def set(self, section: str, name: str, value: Any) -> None:
        """Set a parameter."""
        self.values[section, name] = value
        self.removed.discard((section, name))

    def remove(self, section: str, name: str) -> None:
        """Remove a parameter, which has its default then."""
        self.values.pop((section, name), None)
        self.removed.add((section, name))

    def applied(self, record: RobotRecord) -> RobotRecord:
        """Return a robot's record with the changes.

        Raises
        ------
        InvalidParameter
            The parameters are not valid in a robot's file, such as too large.
        """
        parameters = {
            name: dict(values) if isinstance(values, dict) else values for name, values in record.parameters.items()
        }
        for section in self.sections:
            parameters.setdefault(section, {})
        for (section, name), value in self.values.items():
            parameters.setdefault(section, {})[name] = value
        for section, name in self.removed:
            parameters.get(section, {}).pop(name, None)
        fields = {name: getattr(record, name) for name in STORED_FIELDS}
        try:
            RobotFile.model_validate(fields | {"initial_pose": list(record.initial_pose), "parameters": parameters})
        except ValidationError as error:
            raise InvalidParameter(
                f"the robot's file can not have these parameters: {error.errors()[0]['msg']}"
            ) from error
        return msgspec.structs.replace(record, parameters=parameters)


async def set_parameter(container: Container, name: str, value: Any, change: FileChange) -> None:
    """Set a free parameter at once; note one of a node in the change of the robot's file.

    Raises
    ------
    InvalidParameter
        The name or the value is invalid, or the node has no such parameter.
    """
    path = section_of(container, name)
    text = _encoder.encode(value).decode()
    read_value(text)
    request = _encoder.encode({"name": "/" + "/".join(path), "value": text})
    try:
        await container.clone.call("rosapi/set_param", request)
    except PPaaSError as error:
        if len(path) != 2 or not await _is_known(container, path):
            raise InvalidParameter(error.public) from error
        change.set(path[0], path[1], value)


async def delete_parameter(container: Container, name: str, record: RobotRecord, change: FileChange) -> None:
    """Delete a free parameter at once; note one that the robot's file sets in the change of the file.

    Raises
    ------
    NotFound
        There is no such parameter, or the file does not set it.
    """
    path = section_of(container, name)
    if len(path) == 2 and path[1] in (record.parameters.get(path[0]) or {}):
        change.remove(path[0], path[1])
        return
    shown = "/" + "/".join(path)
    try:
        await container.clone.call("rosapi/delete_param", _encoder.encode({"name": shown}))
    except PPaaSError as error:
        raise NotFound(
            "parameter", shown, [f"/{s}/{n}" for s, values in record.parameters.items() for n in values]
        ) from error


async def _is_known(container: Container, path: tuple[str, ...]) -> bool:
    request = _encoder.encode({"name": "/" + "/".join(path)})
    answer = await container.clone.call("rosapi/has_param", request)
    return decode(rosapi.HasParamResponse, answer).exists


async def change_file(store: RobotStore, container: Container, user: str, change: FileChange) -> None:
    """Change the robot's file and, if that is a change, open its clone again.

    Raises
    ------
    InvalidParameter
        A value is invalid; the file is as it was.
    PPaaSError
        The clone does not start with the change; the file is as it was, and so is the clone.
    """
    clone = container.clone
    before = await run_in_threadpool(store.robot, user, clone.robot)
    after = change.applied(before)
    if after == before:
        return
    await run_in_threadpool(store.put_robot, after, instead_of=before)
    clone.close()
    try:
        await clone.open()
    except PPaaSError:
        await run_in_threadpool(store.put_robot, before, instead_of=after)
        await clone.open()
        raise
