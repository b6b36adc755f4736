"""Viewer: one client of Foxglove, the robots it sees, and the frames that wait for it."""

import asyncio
import secrets
from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import partial

from starlette.concurrency import run_in_threadpool

from endpoints.foxglove.bodies import body_scene
from endpoints.foxglove.reach import ReachableRobot, reached, running
from endpoints.foxglove.robot_view import RobotView, Shown
from endpoints.http.websocket_protocol import Probe
from endpoints.rosbridge.admission import admitted
from endpoints.rosbridge.attachment import Caller
from endpoints.rosbridge.connect_request import ConnectRequest
from endpoints.rosbridge.session_registry import SessionRegistry
from endpoints.services.services import Services
from engine.processes.background import Background
from engine.sessions.outbox import FrameOutbox
from ppaas.clock import epoch, monotonic
from ppaas.errors import NotAuthenticated, NotFound, PPaaSError, Unavailable
from ppaas.wire.foxglove import answers
from ppaas.wire.foxglove.answers import Level
from ppaas.wire.foxglove.requests import Subscription
from ppaas.wire.foxglove.session import FoxgloveSession
from storage.records import User

TIME_PERIOD = 0.1
"""Interval of the cloud's time, which is sent along with messages [s]."""

TIME, STATUS = "time", "status"
"""Names in the outbox under which times and statuses wait; topics begin with a slash."""

MAX_STATUSES = 50
"""Largest number of statuses that wait; beyond it, the oldest is dropped."""


@dataclass(frozen=True, slots=True)
class Login:
    """Login of a viewer: its user, the id of the token, and the addresses of robots that it names; empty for all."""

    user: str
    token: str
    named: tuple[str, ...] = ()


class Viewer:
    """One client of Foxglove.

    Parameters
    ----------
    services : Services
    sessions : SessionRegistry
        Attaches to the places of robots.
    login : Login
    probe : callable
        Probes its connection.

    Attributes
    ----------
    session_id : str
        Id of this connection, by which Foxglove sees that it is another one.
    outbox : FrameOutbox
        Frames for it.
    over : Future
        Done once it must disconnect; its result is the reason.
    session : FoxgloveSession
        Its channels and subscriptions; a channel shows something of a robot.
    views : dict
        Robots that it sees, by owner and id.
    """

    def __init__(self, services: Services, sessions: SessionRegistry, login: Login, probe: Probe) -> None:
        self.login = login
        self.session_id = secrets.token_hex(8)
        self.outbox = FrameOutbox()
        self.over: asyncio.Future[PPaaSError] = asyncio.get_running_loop().create_future()
        self.session: FoxgloveSession[tuple[RobotView, Shown]] = FoxgloveSession()
        self.views: dict[tuple[str, str], RobotView] = {}
        self._services = services
        self._sessions = sessions
        self._probe = probe
        self._background = Background()
        self._timed = float("-inf")
        self._read = asyncio.Event()
        self._troubles: dict[str, str] = {}

    def close(self) -> None:
        """Detach from all robots."""
        for view in tuple(self.views.values()):
            self._drop(view)

    def end(self, reason: PPaaSError) -> None:
        """Make the viewer disconnect."""
        if not self.over.done():
            self.over.set_result(reason)

    # -- frames --------------------------------------------------------------------------------------------------------

    def answer(self, frame: bytes) -> None:
        """Send a frame that must arrive; a viewer that does not read disconnects instead."""
        try:
            self.outbox.put_answer(frame)
        except PPaaSError as error:
            self.end(error)

    def flush(self) -> None:
        """Send what waits, because the connection accepts frames again."""
        self.outbox.flush()
        if not len(self.outbox):
            self._read.set()

    def report(self, error: PPaaSError) -> None:
        """Show the user an error."""
        self.outbox.put(STATUS, answers.status(Level.ERROR, f"{error.slug}: {error.public}"), MAX_STATUSES)

    def show(self, channel: int, view: RobotView, shown: Shown, data: bytes) -> None:
        """Send a message of a channel, and from time to time the cloud's time."""
        now = epoch()
        stamp, name = int(now * 1e9), f"/{view.name}/{shown.topic}"
        frames = list(self.session.messages(channel, stamp, data))
        for frame in frames:
            self.outbox.put(name, frame, shown.depth * len(frames))
        if monotonic() - self._timed >= TIME_PERIOD:
            self._timed = monotonic()
            self.outbox.put(TIME, answers.time_data(stamp), 1)

    # -- channels ------------------------------------------------------------------------------------------------------

    def subscribe(self, wanted: Subscription) -> None:
        """Subscribe to a channel; raises if it may not be, or there is none."""
        view, shown = self.session.subscribe(wanted)
        send = partial(self.show, wanted.channel_id, view, shown)
        try:
            if shown.source:
                view.hear(shown, send)
            else:
                self._background.run(self._send_body(view, send))
        except PPaaSError:
            self.session.unsubscribe(wanted.id)
            raise

    async def _send_body(self, view: RobotView, send: Callable[[bytes], None]) -> None:
        if view.body is None:
            frame, store = view.frames.shared(view.place.base_frame), self._services.store
            view.body = asyncio.ensure_future(asyncio.to_thread(body_scene, store, view.robot.record, frame, view.name))
        try:
            send(await asyncio.shield(view.body))
        except PPaaSError as error:
            self.report(error)

    def unsubscribe(self, subscription: int) -> None:
        """End a subscription; ``NotFound`` if there is none."""
        heard = self.session.unsubscribe(subscription)
        if heard is not None:
            view, shown = heard
            view.ignore(shown)

    # -- robots --------------------------------------------------------------------------------------------------------

    def find(self, name: str) -> tuple[RobotView, str]:
        """Return the robot that a name begins with, and the rest of the name, without slashes around it.

        Raises
        ------
        NotFound
            It is none of a robot that the viewer sees.
        """
        bare = name.strip("/")
        views = {view.name: view for view in self.views.values()}
        for parts in (1, 2):
            split = bare.split("/", parts)
            if len(split) == parts + 1 and (view := views.get("/".join(split[:-1]))) is not None:
                return view, split[-1]
        raise NotFound("robot at the beginning of", name[:64], [f"/{known}/{bare[:64]}" for known in sorted(views)[:5]])

    def find_topic(self, name: str) -> tuple[RobotView, str]:
        """Return robot and topic as `find`; a topic of the clone that names no robot belongs to the only robot."""
        try:
            return self.find(name)
        except NotFound:
            views, topic = list(self.views.values()), name.strip("/")
            if len(views) == 1 and topic in views[0].place.topics:
                return views[0], topic
            raise

    async def refresh(self) -> list[RobotView]:
        """Attach to robots whose clones run now, and leave those that are gone; open and close channels.

        Returns
        -------
        list of RobotView
            Robots whose topics, services or rights have changed.
        """
        try:
            user = await self._services.accounts.user_of(self.login.token)
        except NotAuthenticated as error:
            self.end(error)
            return []
        except Unavailable:
            return []
        records = await run_in_threadpool(reached, self._services.store, user, self.login.named)
        found = {one.key: one for one in await running(self._services.cloud.containers, user, records)}
        for key, view in tuple(self.views.items()):
            if key not in found or found[key].frames != view.frames:
                self._drop(view)
        await asyncio.gather(*(self._attach(user, one) for key, one in found.items() if key not in self.views))
        changed = [view for view in self.views.values() if view.has_changed()]
        for view in changed:
            self._update_channels(view)
            await self._until_read()
        return changed

    async def _attach(self, user: User, robot: ReachableRobot) -> None:
        owner, name = robot.key
        request = ConnectRequest(name, "operator", hold=False, status=True, owner=owner)
        try:
            request, access = await admitted(self._services, user, request)
            attachment = await self._sessions.attach(Caller(user.id, self.login.token, self._probe), request, access)
        except Unavailable:
            return  # its container has ended meanwhile
        except PPaaSError as error:
            self._trouble(robot.name, error)
            return
        view = RobotView(robot, attachment, self.report)
        self.views[robot.key] = view
        view.over.add_done_callback(lambda _: self._drop(view))
        if self._troubles.pop(robot.name, None) is not None:
            self.answer(answers.remove_status([robot.name]))

    def _trouble(self, robot: str, error: PPaaSError) -> None:
        """Show once why a robot is not shown."""
        text = f"robot {robot}: {error.slug}: {error.public}"
        if self._troubles.get(robot) != text:
            self._troubles[robot] = text
            self.answer(answers.status(Level.WARNING, text, robot))

    def _drop(self, view: RobotView) -> None:
        if self.views.get(view.robot.key) is not view:
            return
        del self.views[view.robot.key]
        self._close(view, list(view.channels))
        view.end()
        self._sessions.detach(view.attachment, for_good=True)
        if view.services:
            self.answer(answers.unadvertise_services(list(view.services.values())))

    def _close(self, view: RobotView, gone: Collection[Shown]) -> None:
        """Close channels of a robot."""
        if not gone:
            return
        closed = []
        for shown in gone:
            view.ignore(shown)
            closed.append(view.channels.pop(shown))
            self.session.close(closed[-1])
        self.answer(answers.unadvertise(closed))

    def _update_channels(self, view: RobotView) -> None:
        if view not in self.views.values():
            return  # it has ended while the channels of another one were read
        now = view.shown()
        self._close(view, [shown for shown in view.channels if shown not in now])
        new = []
        for shown in sorted(now - view.channels.keys()):
            channel = self.session.open(f"/{view.name}/{shown.topic}", shown.schema, (view, shown))
            view.channels[shown] = channel.id
            new.append(channel)
        if new:
            self.answer(answers.advertise(new))

    async def _until_read(self) -> None:
        """Wait until the viewer has read all frames that wait: the channels of many robots are megabytes."""
        if len(self.outbox):
            self._read.clear()
            await self._read.wait()
