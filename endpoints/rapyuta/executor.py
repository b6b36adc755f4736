"""Executor of a robot's requests: containers, nodes, parameters, interfaces, connections and messages."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any, TypeVar

import msgspec
from pydantic import ValidationError
from starlette.concurrency import run_in_threadpool

from endpoints.rapyuta.clone import (
    MAX_NODES,
    ON_REQUEST,
    SECTIONS,
    CloneOwner,
    RapyutaContainer,
    SharedClone,
    node_of,
    parse_arguments,
)
from endpoints.rapyuta.interfaces import EndpointTable, RapyutaEndpoint
from endpoints.rapyuta.robot import RapyutaRobot
from endpoints.resources.services import Services
from endpoints.rest.robots.schemas import STORED_FIELDS, RobotFile
from endpoints.rosbridge import SessionRegistry
from ppaas.errors import (
    Conflict,
    InvalidInput,
    InvalidParameter,
    NotAuthenticated,
    NotFound,
    NotPermitted,
    PPaaSError,
    QuotaExceeded,
    Unavailable,
    rebuild,
)
from ppaas.messages import decode, rosapi
from ppaas.nodes.parameter_server.tree import path_of, read_value
from ppaas.wire.rapyuta.requests import (
    AddInterface,
    AddNode,
    Configure,
    Connect,
    CreateContainer,
    DataMessage,
    DestroyContainer,
    RemoveNode,
    Request,
    read_request,
)
from ppaas.wire.rapyuta.tags import check_tag
from storage.ports import RobotStore
from storage.records import RobotRecord

# Parameters of ROS 1 in a container: free ones of the clone, and nodes' parameters, which are in the robot's file.

MOVE_BASE = "move_base"
"""Node below whose name ROS 1 has the parameters of planners and costmaps, which have separate sections here."""

_encoder = msgspec.json.Encoder()


def section_of(container: RapyutaContainer, name: str) -> tuple[str, ...]:
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


async def set_parameter(container: RapyutaContainer, name: str, value: Any, change: FileChange) -> None:
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


async def delete_parameter(container: RapyutaContainer, name: str, record: RobotRecord, change: FileChange) -> None:
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


async def _is_known(container: RapyutaContainer, path: tuple[str, ...]) -> bool:
    request = _encoder.encode({"name": "/" + "/".join(path)})
    answer = await container.clone.call("rosapi/has_param", request)
    return decode(rosapi.HasParamResponse, answer).exists


async def change_file(store: RobotStore, container: RapyutaContainer, user: str, change: FileChange) -> None:
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


MAX_CONTAINERS = 16
"""Largest number of containers that one robot creates; they share its clone."""

FULL = "You seem to have run out of capacity"
"""Beginning of the error if there is no container for a robot, as in rce."""

T = TypeVar("T")


class Executor:
    """Executes the requests of one robot, one after the other.

    Parameters
    ----------
    robot : RapyutaRobot
        The robot.
    endpoints : EndpointTable
        Endpoints of its user.
    services : Services
        Services with the accounts and the store.
    sessions : SessionRegistry
        Attaches to places.
    """

    def __init__(
        self, robot: RapyutaRobot, endpoints: EndpointTable, services: Services, sessions: SessionRegistry
    ) -> None:
        self._robot = robot
        self._endpoints = endpoints
        self._services = services
        self._sessions = sessions

    async def execute(self, message: dict[str, Any]) -> None:
        """Execute a message; what can not be done is reported to the robot."""
        try:
            await self._execute(read_request(message))
        except NotAuthenticated as error:
            self._robot.report(error)
            self._robot.end(error)
        except PPaaSError as error:
            self._robot.report(error)

    async def _execute(self, request: Request) -> None:
        match request:
            case DataMessage():
                self._robot.take(request)
            case CreateContainer():
                await self._create(request)
            case DestroyContainer():
                self.destroy(self._own_container(request.containerTag))
            case Configure():
                await self._configure(request)
            case Connect():
                self._each(request.connect, self._endpoints.connect)
                self._each(request.disconnect, self._endpoints.disconnect)

    def _each(self, items: Iterable[T], work: Callable[[T], None]) -> None:
        for item in items:
            try:
                work(item)
            except PPaaSError as error:
                self._robot.report(error)

    # -- containers ----------------------------------------------------------------------------------------------------

    async def _create(self, request: CreateContainer) -> None:
        robot, tag = self._robot, check_tag("containerTag", request.containerTag)
        await self._services.accounts.user_of(robot.identity.token)
        self._endpoints.check_free(tag)
        if len(robot.containers) >= MAX_CONTAINERS:
            raise QuotaExceeded(f"{FULL}: a robot may create {MAX_CONTAINERS} containers, which share its clone")
        if robot.clone is None:
            robot.clone = await self._opened()
        container = robot.containers[tag] = RapyutaContainer(tag, robot.clone)
        try:
            self._endpoints.add(container)
        except PPaaSError:  # another robot took the tag while the clone was opened
            self.destroy(container)
            raise

    async def _opened(self) -> SharedClone:
        robot = self._robot
        owner = CloneOwner(
            robot.identity.user,
            robot.tag,
            lambda: robot.identity.token,
            robot.answers,
            robot.report,
            self._lost,
        )
        clone = SharedClone(self._sessions, owner)
        try:
            await clone.open()
        except NotFound as error:
            raise rebuild(NotFound.slug, f"{error}: register the robot with 'ppaas robot put {robot.tag}'") from error
        except (QuotaExceeded, Unavailable) as error:
            raise rebuild(error.slug, f"{FULL}: {error.public}") from error
        return clone

    def _lost(self, reason: PPaaSError) -> None:
        """Handle that the cloud closed the clone: the containers are no more."""
        self.destroy_all()
        self._robot.report(rebuild(reason.slug, f"the containers of {self._robot.tag!r} were closed: {reason.public}"))
        if isinstance(reason, NotAuthenticated | NotPermitted):
            self._robot.end(reason)

    def destroy(self, container: RapyutaContainer) -> None:
        """Remove a container with its interfaces; without containers, the clone may end."""
        robot = self._robot
        self._endpoints.remove(container)
        robot.containers.pop(container.tag, None)
        if not robot.containers and robot.clone is not None:
            clone, robot.clone = robot.clone, None
            clone.close()

    def destroy_all(self) -> None:
        """Remove all containers of the robot."""
        for container in tuple(self._robot.containers.values()):
            self.destroy(container)

    def _container(self, tag: str) -> RapyutaContainer:
        found = self._endpoints.endpoint(tag)
        if not isinstance(found, RapyutaContainer):
            raise InvalidInput(f"{tag!r} is a robot, not a container")
        return found

    def _own_container(self, tag: str) -> RapyutaContainer:
        container = self._container(tag)
        if container.tag not in self._robot.containers:
            raise NotPermitted(f"container {tag!r} was created by another robot, which alone may destroy it")
        return container

    # -- configuration -------------------------------------------------------------------------------------------------

    async def _configure(self, request: Configure) -> None:
        changes: dict[RapyutaContainer, FileChange] = {}
        for node in request.addNodes:
            await self._try(self._add_node(node, changes))
        self._each(request.removeNodes, self._remove_node)
        for parameter in request.setParam:
            container = await self._try(self._found(parameter.containerTag))
            if container is not None:
                change = changes.setdefault(container, FileChange())
                await self._try(set_parameter(container, parameter.name, parameter.value, change))
        for deleted in request.deleteParam:
            container = await self._try(self._found(deleted.containerTag))
            if container is not None:
                await self._try(self._delete_parameter(container, deleted.name, changes))
        for container, change in changes.items():
            if change:
                await self._try(self._change_file(container, change))
        self._each(request.addInterfaces, self._add_interface)
        self._each(
            request.removeInterfaces, lambda one: self._endpoint(one.endpointTag).remove_interface(one.interfaceTag)
        )

    async def _try(self, work: Any) -> Any:
        try:
            return await work
        except NotAuthenticated:
            raise
        except PPaaSError as error:
            self._robot.report(error)
            return None

    async def _found(self, tag: str) -> RapyutaContainer:
        return self._container(tag)

    def _endpoint(self, tag: str) -> RapyutaEndpoint:
        found = self._endpoints.endpoint(tag)
        if isinstance(found, RapyutaRobot) and found is not self._robot:
            raise NotPermitted(f"{tag!r} is another robot, which adds and removes its interfaces itself")
        return found

    def _add_interface(self, wanted: AddInterface) -> None:
        endpoint = self._endpoint(wanted.endpointTag)
        assert isinstance(endpoint, RapyutaContainer | RapyutaRobot)
        endpoint.add_interface(wanted)

    async def _add_node(self, wanted: AddNode, changes: dict[RapyutaContainer, FileChange]) -> None:
        container = self._container(wanted.containerTag)
        tag = check_tag("nodeTag", wanted.nodeTag)
        if tag in container.nodes:
            raise Conflict(f"Can not use the same node tag '{tag}' in the same container twice.")
        if len(container.nodes) >= MAX_NODES:
            raise QuotaExceeded(f"a container may have at most {MAX_NODES} nodes")
        has = container.clone.nodes
        node, arguments = node_of(wanted.pkg, wanted.exe, has), parse_arguments(wanted)
        container.note_node(tag, node, arguments)
        change = changes.setdefault(container, FileChange())
        if node in ON_REQUEST and node not in has:
            change.sections.add(node)
        for name, text in arguments.parameters.items():
            await set_parameter(container, f"/{node}/{name}", _plain(text), change)

    def _remove_node(self, wanted: RemoveNode) -> None:
        container = self._container(wanted.containerTag)
        if wanted.nodeTag not in container.nodes:
            raise NotFound(f"node of container {container.tag!r}", wanted.nodeTag, list(container.nodes))
        del container.nodes[wanted.nodeTag]

    async def _delete_parameter(
        self, container: RapyutaContainer, name: str, changes: dict[RapyutaContainer, FileChange]
    ) -> None:
        record = await run_in_threadpool(self._services.store.robot, self._robot.identity.user, container.clone.robot)
        await delete_parameter(container, name, record, changes.setdefault(container, FileChange()))

    async def _change_file(self, container: RapyutaContainer, change: FileChange) -> None:
        clone = container.clone
        before = clone.client
        try:
            await change_file(self._services.store, container, self._robot.identity.user, change)
        except PPaaSError as error:
            if not clone.is_open:
                clone.fail(error)
            raise
        finally:
            if clone.is_open and clone.client is not before:
                self._reopen(clone)

    def _reopen(self, clone: SharedClone) -> None:
        containers = [one for one in self._endpoints.all() if isinstance(one, RapyutaContainer) and one.clone is clone]
        for container in containers:
            self._each(container.own_interfaces(), lambda interface: interface.open())


def _plain(text: str) -> Any:
    """Return the value of a private parameter in the arguments of a node: YAML's numbers and booleans, else text."""
    lowered = text.lower()
    if lowered in ("true", "false"):
        return lowered == "true"
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
