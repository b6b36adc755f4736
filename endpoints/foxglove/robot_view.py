"""Robots as a viewer sees them: which ones it reaches, their bodies, their topics with open feeds, and their graph."""

import asyncio
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import msgspec

from endpoints.place_client import PlaceClient
from endpoints.rosbridge import Attachment
from endpoints.sharing.shared_robots import own_robots, reach, robots_shared_with
from engine.control.master_calls.control_plane import ContainerCalls
from engine.links.place_link import PlaceLink
from engine.sessions.rosapi import view_of
from ppaas.clone.robot_body import robot_body
from ppaas.errors import InvalidUrdf, MessageTooLarge, NotFound, NotPermitted, PPaaSError
from ppaas.maps.new_map import new_map_id
from ppaas.messages import service_type
from ppaas.nodes.topics import ROBOT_DESCRIPTION, policy_of
from ppaas.robot_model.describe import describe
from ppaas.robot_model.description import RobotDescription
from ppaas.wire.foxglove.answers import ConnectionGraph, Schema
from ppaas.wire.foxglove.conversion.base import Conversion, SharedFrames
from ppaas.wire.foxglove.conversion.conversions import PICTURES, conversion_of
from ppaas.wire.foxglove.conversion.scenes import BODY, SCENE, body
from storage.ports import RobotStore
from storage.records import RobotRecord, User

HEIGHT = 0.4
"""Height of a robot of unknown height [m]."""


def body_scene(store: RobotStore, record: RobotRecord, frame: str, name: str) -> bytes:
    """Return the scene of a robot's body in a frame; blocks.

    Raises
    ------
    NotFound, InvalidParameter
        As ``robot_body``.
    """
    found = robot_body(record.model, _urdf(store, record), record.parameters)
    return body(frame, name, found.footprint, found.robot_radius, found.height or HEIGHT)


def _urdf(store: RobotStore, record: RobotRecord) -> RobotDescription | None:
    """Return the description in the URDF of a robot; None without a URDF, or with one that cannot be read."""
    try:
        return describe(store.urdf(record.user, record.id))
    except (NotFound, InvalidUrdf, MessageTooLarge):
        return None


LARGE = 128 << 10
"""Size above which a message is converted in a thread [bytes of JSON]: maps, images, clouds of points."""


class Feed:
    """Converts the messages of one channel.

    While a large message is converted, the newest one waits, and those between are dropped.

    Parameters
    ----------
    conversion : Conversion
    frames : SharedFrames
    send : callable
        Called with each converted message.
    fail : callable
        Called with the error of a message that cannot be converted.
    """

    def __init__(
        self,
        conversion: Conversion,
        frames: SharedFrames,
        send: Callable[[bytes], None],
        fail: Callable[[PPaaSError], None],
    ) -> None:
        self._convert = conversion.convert
        self._frames = frames
        self._send = send
        self._fail = fail
        self._waiting: bytes | None = None
        self._task: asyncio.Task[None] | None = None

    def take(self, payload: bytes) -> None:
        """Take a message of the topic, as JSON."""
        if self._task is not None or len(payload) > LARGE:
            self._waiting = payload
            if self._task is None:
                self._task = asyncio.create_task(self._convert_waiting())
            return
        try:
            self._send(self._convert(payload, self._frames))
        except PPaaSError as error:
            self._fail(error)

    async def _convert_waiting(self) -> None:
        try:
            while self._waiting is not None:
                payload, self._waiting = self._waiting, None
                try:
                    self._send(await asyncio.to_thread(self._convert, payload, self._frames))
                except PPaaSError as error:
                    self._fail(error)
        finally:
            self._task = None

    def close(self) -> None:
        """Convert no further message."""
        self._waiting = None
        if self._task is not None:
            self._task.cancel()


# Robots that a viewer sees: those of the user and those that are shared with the user, or the ones it names.

MAX_ROBOTS = 200
"""Largest number of robots that one viewer sees; further ones are not shown unless it names them."""


@dataclass(frozen=True, slots=True)
class ReachableRobot:
    """Robot that has a running clone.

    Parameters
    ----------
    record : RobotRecord
    name : str
        Its id, below that of its owner if it is another user's.
    frames : SharedFrames
    """

    record: RobotRecord
    name: str
    frames: SharedFrames

    @property
    def key(self) -> tuple[str, str]:
        """Owner and id."""
        return self.record.user, self.record.id


def reached(store: RobotStore, caller: User, named: Sequence[str]) -> list[RobotRecord]:
    """Return the robots that a viewer is to see, with or without a clone; blocks.

    Parameters
    ----------
    store : RobotStore
    caller : User
    named : sequence of str
        Addresses that the viewer names; empty for all.
    """
    if not named:
        mine = own_robots(store, caller, limit=MAX_ROBOTS)
        others = robots_shared_with(store, caller, limit=MAX_ROBOTS - len(mine))
        return [*mine, *(one.record for one in others)]
    found = []
    for address in named:
        try:
            found.append(reach(store, caller, address).record)
        except (NotFound, NotPermitted):
            continue  # it may be registered, or shared, while the viewer waits
    return found


async def running(containers: ContainerCalls, caller: User, records: Sequence[RobotRecord]) -> list[ReachableRobot]:
    """Return those of some robots that have a running clone, with the frame of the map they are on."""
    maps = {
        (one.user, one.robot): one.map.id
        for owner in {record.user for record in records}
        for one in await containers.views(owner)
        if one.robot is not None and one.state == "ready"
    }
    found = []
    for record in records:
        map_id = maps.get((record.user, record.id))
        if map_id is not None:
            name = record.id if record.user == caller.id else f"{record.user}/{record.id}"
            shared = "" if new_map_id(map_id) is not None else map_id
            found.append(ReachableRobot(record, name, SharedFrames(name, shared)))
    return found


_encoder = msgspec.json.Encoder()


class Shown(NamedTuple):
    """Content of a channel.

    ``topic`` is the name without the robot's name; ``source`` the topic of the clone that it is made of, empty for
    the body of the robot, and ``kind`` the type of that topic as spelled in ROS 1.
    """

    topic: str
    source: str = ""
    kind: str = ""

    @property
    def schema(self) -> Schema:
        """Schema of the channel."""
        return self.conversion.schema if self.source else SCENE

    @property
    def conversion(self) -> Conversion:
        """Conversion of the messages of the source."""
        return conversion_of(self.kind) if self.topic == self.source else PICTURES[self.source].conversion

    @property
    def depth(self) -> int:
        """Number of messages that wait for a slow viewer."""
        return policy_of(self.source).depth


class RobotView:
    """Robot with a running clone, and this viewer's client of it.

    Parameters
    ----------
    robot : ReachableRobot
    attachment : Attachment
        Attachment to the session at its place.
    report : callable
        Called with errors.

    Attributes
    ----------
    channels : dict
        Ids of the channels that show something of it.
    services : dict
        Numbers of its services, by name.
    body : Future, optional
        Scene of its body, once it was asked for.
    """

    def __init__(self, robot: ReachableRobot, attachment: Attachment, report: Callable[[PPaaSError], None]) -> None:
        self.robot = robot
        self.attachment = attachment
        self.client = PlaceClient(attachment, report)
        self.channels: dict[Shown, int] = {}
        self.services: dict[str, int] = {}
        self.body: asyncio.Future[bytes] | None = None
        self._report = report
        self._feeds: dict[Shown, Feed] = {}
        self._known: tuple[object, ...] = ()

    @property
    def name(self) -> str:
        """Name by which the viewer sees it, before its topics and frames."""
        return self.robot.name

    @property
    def frames(self) -> SharedFrames:
        """Names of its frames for the viewer."""
        return self.robot.frames

    @property
    def place(self) -> PlaceLink:
        """Place of the robot."""
        return self.client.place

    @property
    def over(self) -> asyncio.Future[PPaaSError]:
        """Done once the session at the place has ended; its result is the reason."""
        return self.attachment.session.over

    def end(self) -> None:
        """Detach from the place."""
        for feed in self._feeds.values():
            feed.close()
        self._feeds.clear()
        self.client.detach()

    # -- topics and services -------------------------------------------------------------------------------------------

    def has_changed(self) -> bool:
        """Return whether topics, services or rights differ from those at the last call."""
        now = (self.place.topic_types(), tuple(self.place.services.values()), self.attachment.session.access)
        before, self._known = self._known, now
        return before != now

    def shown(self) -> set[Shown]:
        """Return what the viewer may see of the robot now."""
        access = self.attachment.session.access
        # The outline is made of the URDF and the parameters of the robot's file.
        found = {Shown(BODY)} if access.may_read(ROBOT_DESCRIPTION.name) else set()
        for topic, kind in self.place.topic_types().items():
            if access.may_read(topic):
                found.add(Shown(topic, topic, kind))
                picture = PICTURES.get(topic)
                if picture is not None and picture.kind == kind:
                    found.add(Shown(picture.topic, topic, kind))
        return found

    def callable_services(self) -> dict[str, str]:
        """Return the services that the viewer may call, with their types as spelled in ROS 1."""
        access = self.attachment.session.access
        found = {}
        for service in self.place.services.values():
            try:
                access.check_call(service.name)
                service_type(service.type)
            except PPaaSError:
                continue  # it may not be called, or its type is unknown
            found[service.name] = service.type
        return found

    # -- feeds ---------------------------------------------------------------------------------------------------------

    def hear(self, shown: Shown, send: Callable[[bytes], None]) -> None:
        """Feed a channel from now on; called again, the latched message is sent again.

        Raises
        ------
        PPaaSError
            The viewer may not subscribe to the topic, or it has another type meanwhile.
        """
        feed = self._feeds.get(shown)
        if feed is None:
            feed = self._feeds[shown] = Feed(shown.conversion, self.frames, send, self._report)
        try:
            self.client.subscribe(shown.source, shown.kind, feed.take)
        except PPaaSError:
            self._feeds.pop(shown).close()
            raise

    def ignore(self, shown: Shown) -> None:
        """Stop feeding a channel."""
        feed = self._feeds.pop(shown, None)
        if feed is not None:
            feed.close()
            self.client.unsubscribe(shown.source, feed.take)

    # -- services ------------------------------------------------------------------------------------------------------

    async def ask(self, service: str, request: object) -> bytes:
        """Call a service and return the response as JSON; raises the error of the call."""
        return await self.client.ask(service, _encoder.encode(request))


EMPTY = ConnectionGraph({}, {}, {})


def graph_of(views: Iterable[RobotView]) -> ConnectionGraph:
    """Return the graph of some robots."""
    published, subscribed, services = (defaultdict[str, list[str]](list) for _ in range(3))
    for view in views:
        for name, node in view_of(view.place).nodes.items():
            node_id = f"/{view.name}/{name}"
            for found, names in ((published, node.publishes), (subscribed, node.subscribes), (services, node.services)):
                for one in sorted(names):
                    found[f"/{view.name}/{one}"].append(node_id)
    return ConnectionGraph(dict(published), dict(subscribed), dict(services))
