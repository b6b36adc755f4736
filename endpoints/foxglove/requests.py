"""Requests of a viewer: subscriptions, messages that it publishes, parameters, services, the graph."""

from collections.abc import Callable, Collection, Coroutine
from dataclasses import dataclass
from typing import Any

from endpoints.foxglove.graph import EMPTY, graph_of
from endpoints.foxglove.parameters import WatchedParameters, read_all, write_parameter
from endpoints.foxglove.robot_view import RobotView
from endpoints.foxglove.viewer import Viewer
from engine.processes.background import Background, repeat
from ppaas.errors import NotFound, PPaaSError, QuotaExceeded
from ppaas.listener_faults import internal_error
from ppaas.messages import service_type
from ppaas.wire.foxglove import answers, requests
from ppaas.wire.foxglove.answers import Graph
from ppaas.wire.foxglove.conversion.incoming import check_encoding, read_called, read_published
from ppaas.wire.foxglove.conversion.schemas import json_of
from ppaas.wire.names import ros1_type

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
        self._graph: Graph | None = None
        self._work = Background()
        self._working = 0
        self._handlers: dict[type, Callable[[Any], None]] = {
            requests.Subscribe: self._subscribe,
            requests.Unsubscribe: self._unsubscribe,
            requests.Advertise: self._advertise,
            requests.Unadvertise: self._unadvertise,
            requests.MessageData: self._publish,
            requests.GetParameters: self._get_parameters,
            requests.SetParameters: self._set_parameters,
            requests.SubscribeParameterUpdates: self._watch_parameters,
            requests.UnsubscribeParameterUpdates: lambda request: self._watched.remove(request.parameter_names),
            requests.ServiceCall: self._call,
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
        """Do something with each item of a list; show the errors."""
        for item in items:
            try:
                work(item)
            except PPaaSError as error:
                self._viewer.report(error)

    def _start(self, work: Coroutine[Any, Any, None]) -> None:
        """Start work that waits for a clone."""
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

    def _subscribe(self, request: requests.Subscribe) -> None:
        self._each(self._viewer.subscribe, request.subscriptions)

    def _unsubscribe(self, request: requests.Unsubscribe) -> None:
        self._each(self._viewer.unsubscribe, request.subscription_ids)

    def _advertise(self, request: requests.Advertise) -> None:
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

    def _unadvertise(self, request: requests.Unadvertise) -> None:
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
        """Return the robots that names of parameters are of; without names, all robots."""
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

    def _service(self, view: RobotView, name: str, kind: str) -> answers.Service:
        self._numbers += 1
        view.services[name] = self._numbers
        self._services[self._numbers] = view, name
        known = service_type(kind)
        request, response = json_of(known.request), json_of(known.response)
        return answers.Service(self._numbers, f"/{view.name}/{name}", kind, request, response)

    def _call(self, call: requests.ServiceCall) -> None:
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

    async def _answer_call(self, call: requests.ServiceCall, view: RobotView, name: str, request: bytes) -> None:
        try:
            result = await view.client.ask(name, request)
        except Exception as error:
            self._fail_call(call, internal_error(error))
            if not isinstance(error, PPaaSError):
                raise
        else:
            self._viewer.answer(answers.service_response(call.service_id, call.call_id, "json", result))

    def _fail_call(self, call: requests.ServiceCall | requests.RefusedCall, error: PPaaSError) -> None:
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
