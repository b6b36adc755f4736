"""Executor of a robot's requests: containers, nodes, parameters, interfaces, connections and messages."""

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

from starlette.concurrency import run_in_threadpool

from endpoints.rapyuta.clone import MAX_NODES, Clone, Container, Owner
from endpoints.rapyuta.endpoints import Endpoint, EndpointTable
from endpoints.rapyuta.known_nodes import ON_REQUEST, node_of, parse_arguments
from endpoints.rapyuta.parameters import FileChange, change_file, delete_parameter, set_parameter
from endpoints.rapyuta.robot import Robot
from endpoints.rosbridge.session_registry import SessionRegistry
from endpoints.services.services import Services
from ppaas.errors import (
    Conflict,
    InvalidInput,
    NotAuthenticated,
    NotFound,
    NotPermitted,
    PPaaSError,
    QuotaExceeded,
    Unavailable,
    rebuild,
)
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

MAX_CONTAINERS = 16
"""Largest number of containers that one robot creates; they share its clone."""

FULL = "You seem to have run out of capacity"
"""Beginning of the error if there is no container for a robot, as in rce."""

T = TypeVar("T")


class Executor:
    """Executes the requests of one robot, one after the other.

    Parameters
    ----------
    robot : Robot
        The robot.
    endpoints : EndpointTable
        Endpoints of its user.
    services : Services
        Services with the accounts and the store.
    sessions : SessionRegistry
        Attaches to places.
    """

    def __init__(self, robot: Robot, endpoints: EndpointTable, services: Services, sessions: SessionRegistry) -> None:
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
        """Do what can be done, and report the rest."""
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
        container = robot.containers[tag] = Container(tag, robot.clone)
        try:
            self._endpoints.add(container)
        except PPaaSError:  # another robot took the tag while the clone was opened
            self.destroy(container)
            raise

    async def _opened(self) -> Clone:
        robot = self._robot
        owner = Owner(
            robot.identity.user,
            robot.tag,
            lambda: robot.identity.token,
            robot.answers,
            robot.report,
            self._lost,
        )
        clone = Clone(self._sessions, owner)
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

    def destroy(self, container: Container) -> None:
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

    def _container(self, tag: str) -> Container:
        found = self._endpoints.endpoint(tag)
        if not isinstance(found, Container):
            raise InvalidInput(f"{tag!r} is a robot, not a container")
        return found

    def _own_container(self, tag: str) -> Container:
        container = self._container(tag)
        if container.tag not in self._robot.containers:
            raise NotPermitted(f"container {tag!r} was created by another robot, which alone may destroy it")
        return container

    # -- configuration -------------------------------------------------------------------------------------------------

    async def _configure(self, request: Configure) -> None:
        changes: dict[Container, FileChange] = {}
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
        """Return the result of a coroutine; report its error and return None."""
        try:
            return await work
        except NotAuthenticated:
            raise
        except PPaaSError as error:
            self._robot.report(error)
            return None

    async def _found(self, tag: str) -> Container:
        return self._container(tag)

    def _endpoint(self, tag: str) -> Endpoint:
        found = self._endpoints.endpoint(tag)
        if isinstance(found, Robot) and found is not self._robot:
            raise NotPermitted(f"{tag!r} is another robot, which adds and removes its interfaces itself")
        return found

    def _add_interface(self, wanted: AddInterface) -> None:
        endpoint = self._endpoint(wanted.endpointTag)
        assert isinstance(endpoint, Container | Robot)
        endpoint.add_interface(wanted)

    async def _add_node(self, wanted: AddNode, changes: dict[Container, FileChange]) -> None:
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

    async def _delete_parameter(self, container: Container, name: str, changes: dict[Container, FileChange]) -> None:
        record = await run_in_threadpool(self._services.store.robot, self._robot.identity.user, container.clone.robot)
        await delete_parameter(container, name, record, changes.setdefault(container, FileChange()))

    async def _change_file(self, container: Container, change: FileChange) -> None:
        """Change the file of the container's robot; its clone is started again, with all interfaces."""
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

    def _reopen(self, clone: Clone) -> None:
        """Move the interfaces of all containers to a clone that was reopened."""
        containers = [one for one in self._endpoints.all() if isinstance(one, Container) and one.clone is clone]
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
