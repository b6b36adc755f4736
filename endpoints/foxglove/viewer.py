"""Viewer: one client of Foxglove, the robots it sees, the frames that wait for it, and its requests.

`Viewer` holds what the cloud sends; `ViewerRequests` does what the client asks for: subscriptions, messages,
parameters, services and the graph.
"""

import asyncio
import secrets
from collections.abc import Callable, Collection, Coroutine, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import msgspec
from starlette.concurrency import run_in_threadpool

from endpoints.foxglove.robot_view import (
    EMPTY,
    ReachableRobot,
    RobotView,
    Shown,
    body_scene,
    graph_of,
    reached,
    running,
)
from endpoints.http.websocket_protocol import Probe
from endpoints.resources.services import Services
from endpoints.rosbridge import AuthenticatedClient, ConnectRequest, SessionRegistry, admitted
from engine.processes.background import Background, repeat
from engine.sessions.outbox import FrameOutbox
from ppaas.clock import epoch, monotonic
from ppaas.errors import NotAuthenticated, NotFound, PPaaSError, QuotaExceeded, Unavailable
from ppaas.listener_faults import internal_error
from ppaas.messages import decode, rosapi, service_type
from ppaas.wire.foxglove import answers, requests
from ppaas.wire.foxglove.answers import ConnectionGraph, Level
from ppaas.wire.foxglove.conversion.incoming import check_encoding, read_called, read_published
from ppaas.wire.foxglove.conversion.schemas import json_of
from ppaas.wire.foxglove.requests import ChannelSubscription, Parameter
from ppaas.wire.foxglove.session import FoxgloveSession
from ppaas.wire.names import ros1_type
from storage.records import User

TIME_PERIOD = 0.1
"""Interval of the cloud's time, which is sent along with messages [s]."""

TIME, STATUS = "time", "status"
"""Names in the outbox under which times and statuses wait; topics begin with a slash."""

MAX_STATUSES = 50
"""Largest number of statuses that wait; beyond it, the oldest is dropped."""


@dataclass(frozen=True, slots=True)
class ViewerLogin:
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
    login : ViewerLogin
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

    def __init__(self, services: Services, sessions: SessionRegistry, login: ViewerLogin, probe: Probe) -> None:
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

    def subscribe(self, wanted: ChannelSubscription) -> None:
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
            attachment = await self._sessions.attach(
                AuthenticatedClient(user.id, self.login.token, self._probe), request, access
            )
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


# Parameters of robots by the names that viewers use: ``/ROBOT/node/parameter``.

MAX_VALUE = 256 << 10
"""Largest text that is sent as a parameter [bytes]."""

MAX_WATCHED = 1000
"""Largest number of parameters that one viewer watches by name."""

Values = Mapping[str, Parameter]
"""Parameters by name."""


async def read_parameters(view: RobotView) -> dict[str, Parameter]:
    """Return all parameters of a robot; raises the error of the call."""
    answer = await view.ask("rosapi/get_param", {"name": "/"})
    tree = msgspec.json.decode(decode(rosapi.GetParamResponse, answer).value)
    return {one.name: one for one in _leaves(f"/{view.name}", tree)}


def _leaves(name: str, value: Any) -> Iterator[Parameter]:
    """Yield the parameters in a tree; a list of other things than numbers is a value itself."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _leaves(f"{name}/{key}", inner)
    elif not (isinstance(value, str) and len(value) > MAX_VALUE):
        yield Parameter(name, value, _type_of(value))


def _type_of(value: Any) -> str | None:
    if isinstance(value, float):
        return "float64"
    if isinstance(value, list) and value and all(isinstance(one, float) for one in value):
        return "float64_array"
    return None


async def write_parameter(view: RobotView, name: str, parameter: Parameter) -> None:
    """Set a parameter of a robot, or remove it if it has no value; raises the error of the call.

    Parameters
    ----------
    view : RobotView
    name : str
        Name without the robot's name.
    parameter : Parameter
    """
    if parameter.value is msgspec.UNSET:
        await view.ask("rosapi/delete_param", {"name": f"/{name}"})
        return
    value = msgspec.json.encode(_as_float(parameter)).decode()
    await view.ask("rosapi/set_param", {"name": f"/{name}", "value": value})


def _as_float(parameter: Parameter) -> Any:
    """Return a value; a number of 64 bits that JSON writes without a point is a float again."""
    value = parameter.value
    if parameter.type == "float64" and isinstance(value, int):
        return float(value)
    if parameter.type == "float64_array" and isinstance(value, list):
        return [float(one) if isinstance(one, int) else one for one in value]
    return value


class WatchedParameters:
    """Parameters whose changes a viewer wants to be sent."""

    def __init__(self) -> None:
        self._names: set[str] = set()
        self._all = False
        self._sent: dict[str, Parameter] = {}

    def __bool__(self) -> bool:
        return self._all or bool(self._names)

    @property
    def names(self) -> frozenset[str]:
        """Names of the watched ones; empty for all."""
        return frozenset() if self._all else frozenset(self._names)

    def add(self, names: list[str]) -> None:
        """Watch parameters; without names, all.

        Raises
        ------
        QuotaExceeded
            They are too many.
        """
        if len(self._names | set(names)) > MAX_WATCHED:
            raise QuotaExceeded(f"at most {MAX_WATCHED} parameters can be watched by name: watch all, without names")
        self._names.update(names)
        self._all = self._all or not names

    def remove(self, names: list[str]) -> None:
        """Stop watching parameters; without names, all of them."""
        self._names.difference_update(names)
        if not names:
            self._names, self._all = set(), False
        self._sent = {name: one for name, one in self._sent.items() if self.includes(name)}

    def includes(self, name: str) -> bool:
        """Return whether a parameter is watched."""
        return self._all or name in self._names

    def changed(self, values: Values) -> list[Parameter]:
        """Return the watched ones that differ from those sent before; one that is gone has no value."""
        now = {name: one for name, one in values.items() if self.includes(name)}
        found = [one for name, one in now.items() if self._sent.get(name) != one]
        gone = [Parameter(name) for name in self._sent if name not in now]
        self._sent = now
        return found + gone


async def read_all(views: list[RobotView]) -> tuple[dict[str, Parameter], list[PPaaSError]]:
    """Return the parameters of some robots, and the errors of those whose parameters cannot be read."""
    found: dict[str, Parameter] = {}
    errors = []
    for view in views:
        try:
            found |= await read_parameters(view)
        except PPaaSError as error:
            errors.append(error)
    return found, errors


# Requests of a viewer, and what it asked for that changes with time.

PERIOD = 2.0
"""Interval at which robots, channels, services, watched parameters and the graph are looked at again [s]."""

MAX_WORK = 16
"""Largest number of calls and requests for parameters of one viewer that are not answered yet."""


@dataclass
class _Publication:
    """Topic of a robot that the viewer has advertised there."""

    view: RobotView
    topic: str
    advertisement: str


class ViewerRequests:
    """Executes the requests of one viewer.

    Parameters
    ----------
    viewer : Viewer
    """

    def __init__(self, viewer: Viewer) -> None:
        self._viewer = viewer
        self._publications: dict[int, _Publication] = {}
        self._services: dict[int, tuple[RobotView, str]] = {}
        self._numbers = 0
        self._watched = WatchedParameters()
        self._graph: ConnectionGraph | None = None
        self._work = Background()
        self._working = 0
        self._handlers: dict[type, Callable[[Any], None]] = {
            requests.SubscribeChannels: self._subscribe,
            requests.UnsubscribeChannels: self._unsubscribe,
            requests.AdvertiseChannels: self._advertise,
            requests.UnadvertiseChannels: self._unadvertise,
            requests.MessageData: self._publish,
            requests.GetParameters: self._get_parameters,
            requests.SetParameters: self._set_parameters,
            requests.SubscribeParameterUpdates: self._watch_parameters,
            requests.UnsubscribeParameterUpdates: lambda request: self._watched.remove(request.parameter_names),
            requests.FoxgloveServiceCall: self._call,
            requests.RefusedCall: lambda call: self._fail_call(call, call.error),
            requests.SubscribeConnectionGraph: self._watch_graph,
            requests.UnsubscribeConnectionGraph: self._ignore_graph,
            requests.FetchAsset: self._fetch_asset,
        }

    def take(self, frame: str | bytes) -> None:
        """Execute the request in a frame; show its errors to the user."""
        try:
            request = requests.read_request(frame)
            if request is not None:
                self._handlers[type(request)](request)
        except PPaaSError as error:
            self._viewer.report(error)

    async def run(self) -> None:
        """Refresh periodically until cancelled."""
        try:
            await repeat(self.refresh, PERIOD)
        finally:
            await self._work.cancel()

    async def refresh(self) -> None:
        """Bring robots, channels, services, the graph and watched parameters up to date once."""
        self._update_services(await self._viewer.refresh())
        self._send_graph()
        await self._send_changed_parameters()

    def _each(self, work: Callable[[Any], None], items: list[Any]) -> None:
        for item in items:
            try:
                work(item)
            except PPaaSError as error:
                self._viewer.report(error)

    def _start(self, work: Coroutine[Any, Any, None]) -> None:
        if self._working >= MAX_WORK:
            work.close()
            raise QuotaExceeded(f"at most {MAX_WORK} requests may wait for an answer: wait for one")
        self._working += 1

        async def counted() -> None:
            try:
                await work
            except PPaaSError as error:
                self._viewer.report(error)
            finally:
                self._working -= 1

        self._work.run(counted())

    # -- topics --------------------------------------------------------------------------------------------------------

    def _subscribe(self, request: requests.SubscribeChannels) -> None:
        self._each(self._viewer.subscribe, request.subscriptions)

    def _unsubscribe(self, request: requests.UnsubscribeChannels) -> None:
        self._each(self._viewer.unsubscribe, request.subscription_ids)

    def _advertise(self, request: requests.AdvertiseChannels) -> None:
        self._each(self._advertise_one, request.channels)

    def _advertise_one(self, channel: requests.ClientChannel) -> None:
        """Open a channel of the viewer; its robot may connect later, so that its rights are checked again then."""
        check_encoding(channel.encoding)
        ros1_type(channel.schema_name)
        self._viewer.session.advertise(channel)
        self._publication(channel)

    def _publication(self, channel: requests.ClientChannel) -> _Publication:
        """Return where a channel is advertised; advertise it, if its robot has connected since."""
        view, topic = self._viewer.find_topic(channel.topic)
        known = self._publications.get(channel.id)
        if known is None or known.view is not view:
            advertisement = view.client.advertise(topic, ros1_type(channel.schema_name))
            known = self._publications[channel.id] = _Publication(view, topic, advertisement)
        return known

    def _unadvertise(self, request: requests.UnadvertiseChannels) -> None:
        self._each(self._unadvertise_one, request.channel_ids)

    def _unadvertise_one(self, channel: int) -> None:
        self._viewer.session.unadvertise(channel)
        known = self._publications.pop(channel, None)
        if known is not None and known.view in self._viewer.views.values():
            known.view.client.unadvertise(known.topic, known.advertisement)

    def _publish(self, message: requests.MessageData) -> None:
        channel = self._viewer.session.published(message.channel_id)
        to = self._publication(channel)
        payload = read_published(channel.encoding, ros1_type(channel.schema_name), message.data, to.view.frames)
        to.view.client.publish(to.topic, payload)

    # -- parameters ----------------------------------------------------------------------------------------------------

    def _get_parameters(self, request: requests.GetParameters) -> None:
        self._start(self._answer_parameters(request.parameter_names, request.id))

    async def _answer_parameters(self, names: list[str], request_id: str | None) -> None:
        values = await self._values(names)
        found = list(values.values()) if not names else [values[name] for name in names if name in values]
        self._viewer.answer(answers.parameter_values(found, request_id))

    async def _values(self, names: list[str]) -> dict[str, requests.Parameter]:
        """Return the parameters of the robots that names are of; without names, of all robots that can be read."""
        values, errors = await read_all(self._views_of(names))
        if names:
            for error in errors:
                self._viewer.report(error)
        return values

    def _views_of(self, names: Collection[str]) -> list[RobotView]:
        views = self._viewer.views.values()
        return [view for view in views if not names or any(name.startswith(f"/{view.name}/") for name in names)]

    def _set_parameters(self, request: requests.SetParameters) -> None:
        self._start(self._write_parameters(request.parameters, request.id))

    async def _write_parameters(self, parameters: list[requests.Parameter], request_id: str | None) -> None:
        for parameter in parameters:
            try:
                view, name = self._viewer.find(parameter.name)
                await write_parameter(view, name, parameter)
            except PPaaSError as error:
                self._viewer.report(error)
        await self._answer_parameters([parameter.name for parameter in parameters], request_id)

    def _watch_parameters(self, request: requests.SubscribeParameterUpdates) -> None:
        self._watched.add(request.parameter_names)
        self._start(self._send_changed_parameters())

    async def _send_changed_parameters(self) -> None:
        if not self._watched:
            return
        values, _ = await read_all(self._views_of(self._watched.names))
        changed = self._watched.changed(values)
        if changed:
            self._viewer.answer(answers.parameter_values(changed))

    # -- services ------------------------------------------------------------------------------------------------------

    def _update_services(self, changed: list[RobotView]) -> None:
        """Announce the services of robots that the viewer may call, and withdraw the others."""
        self._services = {
            number: (view, name) for view in self._viewer.views.values() for name, number in view.services.items()
        }
        for view in changed:
            now = view.callable_services()
            gone = [name for name in view.services if name not in now]
            if gone:
                self._viewer.answer(answers.unadvertise_services([view.services.pop(name) for name in gone]))
            new = [self._service(view, name, kind) for name, kind in now.items() if name not in view.services]
            if new:
                self._viewer.answer(answers.advertise_services(new))

    def _service(self, view: RobotView, name: str, kind: str) -> answers.FoxgloveService:
        self._numbers += 1
        view.services[name] = self._numbers
        self._services[self._numbers] = view, name
        known = service_type(kind)
        request, response = json_of(known.request), json_of(known.response)
        return answers.FoxgloveService(self._numbers, f"/{view.name}/{name}", kind, request, response)

    def _call(self, call: requests.FoxgloveServiceCall) -> None:
        try:
            view, name = self._service_of(call.service_id)
            request = read_called(call.encoding, name, call.data)
            self._start(self._answer_call(call, view, name, request))
        except PPaaSError as error:
            self._fail_call(call, error)

    def _service_of(self, number: int) -> tuple[RobotView, str]:
        view, name = self._services.get(number, (None, ""))
        if view is None or view not in self._viewer.views.values():
            raise NotFound("service", str(number))
        return view, name

    async def _answer_call(
        self, call: requests.FoxgloveServiceCall, view: RobotView, name: str, request: bytes
    ) -> None:
        try:
            result = await view.client.ask(name, request)
        except Exception as error:
            self._fail_call(call, internal_error(error))
            if not isinstance(error, PPaaSError):
                raise
        else:
            self._viewer.answer(answers.service_response(call.service_id, call.call_id, "json", result))

    def _fail_call(self, call: requests.FoxgloveServiceCall | requests.RefusedCall, error: PPaaSError) -> None:
        text = f"{error.slug}: {error.public}"
        self._viewer.answer(answers.service_failed(call.service_id, call.call_id, text))

    # -- graph and files -----------------------------------------------------------------------------------------------

    def _watch_graph(self, _: requests.SubscribeConnectionGraph) -> None:
        self._graph = self._graph or EMPTY
        self._send_graph()

    def _ignore_graph(self, _: requests.UnsubscribeConnectionGraph) -> None:
        self._graph = None

    def _send_graph(self) -> None:
        if self._graph is None:
            return
        now = graph_of(self._viewer.views.values())
        changes = self._graph.changes_to(now)
        self._graph = now
        if changes is not None:
            self._viewer.answer(changes)

    def _fetch_asset(self, request: requests.FetchAsset) -> None:
        text = "this server has no files; the URDF of a robot is its parameter robot_description"
        self._viewer.answer(answers.asset_failed(request.request_id, text))
