"""Robot as one viewer sees it: its topics, and the feeds of those that the viewer has opened."""

import asyncio
from collections.abc import Callable
from typing import NamedTuple

import msgspec

from endpoints.clients.place_client import PlaceClient
from endpoints.foxglove.feed import Feed
from endpoints.foxglove.reach import ReachableRobot
from endpoints.rosbridge.attachment import Attachment
from engine.service.links.place_link import PlaceLink
from ppaas.errors import PPaaSError
from ppaas.messages import service_type
from ppaas.nodes.topics import ROBOT_DESCRIPTION, policy_of
from ppaas.wire.foxglove.answers import Schema
from ppaas.wire.foxglove.conversion.base import Conversion, SharedFrames
from ppaas.wire.foxglove.conversion.conversions import PICTURES, conversion_of
from ppaas.wire.foxglove.conversion.scenes import BODY, SCENE

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
