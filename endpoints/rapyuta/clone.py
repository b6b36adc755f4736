"""Clone of a robot as its containers use it, their nodes, and containers: endpoints with interfaces to the clone."""

import asyncio
import shlex
from collections.abc import Awaitable, Callable, Collection
from dataclasses import dataclass, field

from endpoints.place_client import PlaceClient
from endpoints.rapyuta.interfaces import CONTAINER_INTERFACES, ContainerInterface, RapyutaEndpoint
from endpoints.rosbridge import AuthenticatedClient, ConnectRequest, SessionRegistry
from engine.rights.access import Access
from ppaas.errors import InvalidInput, NotFound, PPaaSError, Unavailable
from ppaas.wire.rapyuta.interface_types import InterfaceForm, interface_type
from ppaas.wire.rapyuta.requests import AddInterface, AddNode
from ppaas.wire.rapyuta.tags import check_tag

# Nodes of ROS 1 that a robot may start in a container, and the nodes of a clone that stand for them.
#
# A clone has its nodes from the start, by the robot's file; nothing of another package is executed.

NODES: dict[tuple[str, str], str] = {
    ("amcl", "amcl"): "amcl",
    ("move_base", "move_base"): "move_base",
    ("map_server", "map_server"): "map_server",
    ("gmapping", "slam_gmapping"): "grid_slam",
    ("slam_gmapping", "slam_gmapping"): "grid_slam",
    ("slam_karto", "slam_karto"): "grid_slam",
    ("hector_mapping", "hector_mapping"): "grid_slam",
    ("depthimage_to_laserscan", "depthimage_to_laserscan"): "depthimage_to_laserscan",
    ("octomap_server", "octomap_server_node"): "octomap_server",
    ("leg_detector", "leg_detector"): "leg_detector",
    ("explore", "explore"): "explore",
    ("explore_lite", "explore"): "explore",
    ("robot_state_publisher", "robot_state_publisher"): "robot_state_publisher",
    ("robot_state_publisher", "state_publisher"): "robot_state_publisher",
    ("tf2_web_republisher", "tf2_web_republisher"): "tf2_web_republisher",
}
"""Nodes of clones by package and executable."""

ON_REQUEST = frozenset({"depthimage_to_laserscan", "octomap_server", "leg_detector"})
"""Nodes that a clone has if the robot's file has parameters for them, which may be empty."""

SECTIONS = {"slam_gmapping": "grid_slam", "gmapping": "grid_slam", "slam_karto": "grid_slam"}
"""Names of nodes in ROS 1 whose parameters belong to another node here."""

_ASSIGNMENT = ":="


def node_of(pkg: str, exe: str, has: Collection[str]) -> str:
    """Return the node that stands for an executable.

    Parameters
    ----------
    pkg, exe : str
        Package and executable.
    has : collection of str
        Nodes that the clone has.

    Raises
    ------
    NotFound
        Nothing stands for it, or the clone lacks the node; the text lists what the clone has.
    """
    node = NODES.get((pkg, exe))
    known = [f"{package} {name}" for (package, name), one in NODES.items() if one in has or one in ON_REQUEST]
    if node is None or (node not in has and node not in ON_REQUEST):
        raise NotFound("node", f"{pkg} {exe}"[:128], known)
    return node


@dataclass(frozen=True, slots=True)
class NodeArguments:
    """Arguments of a node: private parameters as text, new names of topics by their old ones, and its own name."""

    parameters: dict[str, str] = field(default_factory=dict)
    remapped: dict[str, str] = field(default_factory=dict)
    name: str = ""
    namespace: str = ""


def parse_arguments(node: AddNode) -> NodeArguments:
    """Return the arguments of a node as ``rosrun`` reads them; files and flags have no meaning here and are left out.

    Raises
    ------
    InvalidInput
        A quotation in them does not end.
    """
    try:
        words = shlex.split(node.args)
    except ValueError as error:
        raise InvalidInput(f"the args of node {node.nodeTag!r} can not be read: {error}") from error
    pairs = [(left, right) for left, sep, right in (word.partition(_ASSIGNMENT) for word in words) if sep and left]
    special = {left: right for left, right in pairs if left.startswith("__")}
    parameters = {left[1:]: right for left, right in pairs if left.startswith("_") and not left.startswith("__")}
    remapped = {left.strip("/"): right.strip("/") for left, right in pairs if not left.startswith("_")}
    name = (node.name or special.get("__name", "")).strip("/")
    return NodeArguments(parameters, remapped, name, (node.namespace or special.get("__ns", "")).strip("/"))


MAX_NODES = 200
"""Largest number of nodes that are started in one container."""


@dataclass(frozen=True, slots=True)
class CloneOwner:
    """Robot that opens a clone.

    Parameters
    ----------
    user, robot : str
    token : callable
        Returns the id of the token that it is logged in by.
    answers : callable
        Returns, within a time [s], whether the robot is connected and answers.
    report : callable
        Called with errors that concern no request.
    lost : callable
        Called with the reason when the clone was closed by the cloud.
    """

    user: str
    robot: str
    token: Callable[[], str]
    answers: Callable[[float], Awaitable[bool]]
    report: Callable[[PPaaSError], None]
    lost: Callable[[PPaaSError], None]


class SharedClone:
    """Clone of a robot, which all its containers share.

    Parameters
    ----------
    sessions : SessionRegistry
        Attaches to the robot's place.
    owner : CloneOwner
        The robot.
    """

    def __init__(self, sessions: SessionRegistry, owner: CloneOwner) -> None:
        self._sessions = sessions
        self._owner = owner
        self._client: PlaceClient | None = None
        self._watching: asyncio.Task[None] | None = None

    @property
    def robot(self) -> str:
        """Robot whose clone it is."""
        return self._owner.robot

    @property
    def is_open(self) -> bool:
        """Whether a client is attached to the place."""
        return self._client is not None

    @property
    def client(self) -> PlaceClient:
        """Current client of the place; raises ``Unavailable`` while there is none."""
        if self._client is None:
            raise Unavailable("the clone of the robot is not running now")
        return self._client

    @property
    def nodes(self) -> frozenset[str]:
        """Names of the nodes that the clone has."""
        return frozenset(node.name for node in self.client.place.nodes.values())

    async def open(self) -> None:
        """Attach to the place of the robot once its container is ready; raises as ``SessionRegistry.attach``."""
        owner = self._owner
        request = ConnectRequest(owner.robot, status=True)
        access = Access.of_owner(owner.robot)
        attachment = await self._sessions.attach(
            AuthenticatedClient(owner.user, owner.token(), owner.answers), request, access
        )
        self._client = PlaceClient(attachment, owner.report)
        self._watching = asyncio.create_task(self._watch(self._client))

    async def _watch(self, client: PlaceClient) -> None:
        """Wait until the place is closed, or another client displaces this one."""
        attachment = client.attachment
        await asyncio.wait((attachment.session.over, attachment.displaced), return_when=asyncio.FIRST_COMPLETED)
        ended = attachment.session.over if attachment.session.over.done() else attachment.displaced
        self._watching = None
        self.close()
        self._owner.lost(ended.result())

    def close(self) -> None:
        """Detach from the place, which stays open for a while."""
        client, self._client = self._client, None
        if self._watching is not None:
            self._watching.cancel()
            self._watching = None
        if client is not None:
            client.detach()
            self._sessions.detach(client.attachment, for_good=True)

    def fail(self, reason: PPaaSError) -> None:
        """Close the clone because it does not start again, and notify its owner."""
        self.close()
        self._owner.lost(reason)

    def renew_token(self, token: str) -> None:
        """Replace the client's token by another one of the same user."""
        if self._client is not None:
            self._client.attachment.token = token

    def note_round_trip(self, seconds: float) -> None:
        """Record the round trip of a ping to the robot [s]."""
        if self._client is not None:
            self._client.place.note_round_trip(seconds)

    async def call(self, service: str, payload: bytes) -> bytes:
        """Call a service of the clone and return the response as JSON; raises the error of the call."""
        return await self.client.ask(service, payload)


@dataclass
class _Names:
    """Names in a container's graph that differ from the clone's names."""

    namespaces: set[str] = field(default_factory=set)
    remapped: dict[str, str] = field(default_factory=dict)
    nodes: dict[str, str] = field(default_factory=dict)


class RapyutaContainer(RapyutaEndpoint):
    """Container: tags of nodes, and interfaces to a clone.

    Parameters
    ----------
    tag : str
    clone : SharedClone

    Attributes
    ----------
    nodes : dict of str to str
        Nodes of the clone by the tags that they were started with.
    """

    def __init__(self, tag: str, clone: SharedClone) -> None:
        super().__init__(tag)
        self.clone = clone
        self.nodes: dict[str, str] = {}
        self._names = _Names()

    def note_node(self, tag: str, node: str, arguments: NodeArguments) -> None:
        """Note a node that was started, with its names."""
        self.nodes[tag] = node
        if arguments.name:
            self._names.nodes[arguments.name] = node
        if arguments.namespace:
            self._names.namespaces.add(arguments.namespace)
        self._names.remapped |= {new: old for old, new in arguments.remapped.items()}

    def graph_name(self, addr: str) -> str:
        """Return the topic or service of the clone that an address of the container's graph names."""
        name = self.bare_name(addr)
        return self._names.remapped.get(name, name)

    def node_name(self, name: str) -> str:
        """Return the node of the clone that has a name in the container's graph; other names are unchanged."""
        return self._names.nodes.get(name, name)

    def bare_name(self, addr: str) -> str:
        """Return a name without slashes around it, and without a namespace that a node was started in."""
        name = addr.strip("/")
        for namespace in self._names.namespaces:
            if name.startswith(f"{namespace}/"):
                return name.removeprefix(f"{namespace}/")
        return name

    def add_interface(self, wanted: AddInterface) -> None:
        """Add an interface.

        Raises
        ------
        InvalidInput
            It has no address, or its type is not one of interfaces in containers.
        PPaaSError
            The tag is taken or invalid, or the clone has the topic or service with another type.
        """
        kind = interface_type(wanted.interfaceType)
        if kind.form is not InterfaceForm.INTERFACE:
            raise InvalidInput(
                f"{kind} is a type of interfaces on robots, and {self.tag!r} is a container: use {kind.role}Interface"
            )
        tag = check_tag("interfaceTag", wanted.interfaceTag)
        self.check_free(tag)
        if not wanted.addr.strip("/"):
            raise InvalidInput(f"interface {tag!r} needs the name of a topic or service in 'addr'")
        name = self.graph_name(wanted.addr)
        interface = CONTAINER_INTERFACES[kind.role](self.tag, tag, kind, wanted.className, name=name, graph=self.clone)
        interface.open()
        self.interfaces[tag] = interface

    def own_interfaces(self) -> list[ContainerInterface]:
        """Return the interfaces."""
        return [interface for interface in self.interfaces.values() if isinstance(interface, ContainerInterface)]
