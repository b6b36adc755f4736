"""Node ``people_coordinator``: takes the reports of the robots of a group, and publishes the people on their map."""

from collections.abc import Callable
from typing import ClassVar

from msgspec.structs import replace

from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import NotFound
from ppaas.messages.base.message import Empty, Message
from ppaas.messages.people_coordination import (
    ConfigurePeople,
    ConfigurePeopleRequest,
    GetPeople,
    GetPeopleCounts,
    GetPeopleCountsRequest,
    GetPeopleCountsResponse,
    PeopleReport,
    PeopleState,
)
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Node, Payload, Reply, Service, Topic
from ppaas.nodes.message_checks import expect
from ppaas.people.coordinator.coordinator import PeopleCoordinator
from ppaas.people.names import PEOPLE_COORDINATOR
from ppaas.people.settings import settings_of
from ppaas.people.tracks.assignment import solver

PERIOD = 0.2
"""Time between two states of the people [s]."""

FIRST = 0.01
"""Time from the start to the first state [s]; a checkpoint is restored in it."""

UNSAVED = 50
"""Numbers of people that are left out after a checkpoint: as many may have been given since it was stored."""

GET_PEOPLE = Service("people_coordinator/get_people", GetPeople)
GET_PEOPLE_COUNTS = Service("people_coordinator/get_people_counts", GetPeopleCounts)
CONFIGURE_PEOPLE = Service("people_coordinator/configure_people", ConfigurePeople)


class PeopleCoordinatorNode(Node):
    """Subscribes to the reports of all robots of a group, and publishes `PeopleState` five times a second.

    The group is the robots of one user on one map. The node has a separate container, beside the containers of the
    robots' clones, and no robot. Identities, counts and orders are in its checkpoint.

    Parameters
    ----------
    context : Context
        The node's context.
    coordinator : PeopleCoordinator
        Coordinator of the group, with its settings.
    """

    name: ClassVar[str] = PEOPLE_COORDINATOR
    subscribes: ClassVar[tuple[Topic, ...]] = (topics.PEOPLE_REPORT,)
    publishes: ClassVar[tuple[Topic, ...]] = (topics.PEOPLE_STATE,)
    services: ClassVar[tuple[Service, ...]] = (GET_PEOPLE, GET_PEOPLE_COUNTS, CONFIGURE_PEOPLE)

    def __init__(self, context: Context, coordinator: PeopleCoordinator) -> None:
        super().__init__(context)
        self._coordinator = coordinator
        self._state: PeopleState | None = None
        self._calls: dict[str, Callable[[Message], Message]] = {
            GET_PEOPLE.name: lambda _: self._state or self._next_state(),
            GET_PEOPLE_COUNTS.name: self._counts,
            CONFIGURE_PEOPLE.name: self._configure,
        }

    def start(self) -> None:
        """Begin to publish: the first state at once, since robots may wait for it after a crash."""
        self.context.every(PERIOD, self._step)
        self._first = self.context.every(FIRST, self._begin)

    def use_layers(self, layers: MapLayers) -> None:
        """Go on with another version of the map."""
        self._coordinator.use_costmap(layers.costmap)

    def on_message(self, topic: str, message: Payload) -> None:
        """Take the report of a robot; `InvalidInput` if it is not valid, which changes nothing."""
        self._coordinator.report(expect(message, PeopleReport), self.context.now())

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        """Answer with the people or the counts, or use other settings.

        Raises
        ------
        InvalidInput
            The settings are not valid.
        NotFound
            Their rule is not installed; the settings are unchanged.
        """
        if service not in self._calls:
            raise NotFound("service", service, list(self._calls))
        reply(self._calls[service](request))

    def checkpoint(self) -> bytes:
        """Return the identities, counts and orders."""
        return self._coordinator.checkpoint()

    def restore(self, state: bytes) -> None:
        """Continue with the identities, counts and orders of a checkpoint; no number of a person is used twice."""
        self._coordinator.restore(state)
        self._coordinator.table.next_id += UNSAVED

    def _begin(self) -> None:
        self._first.stop()
        self._step()
        # Imported beside the first cycles, so that the first state need not wait for scipy.
        self.context.start(lambda _: solver(), lambda _: None)

    def _step(self) -> None:
        self._state = self._next_state()
        self.context.publish(topics.PEOPLE_STATE.name, self._state)

    def _next_state(self) -> PeopleState:
        began = self.context.elapsed()
        state = self._coordinator.step(self.context.now())
        return replace(state, seconds=self.context.elapsed() - began)

    def _counts(self, request: Message) -> Message:
        since = expect(request, GetPeopleCountsRequest).since
        return GetPeopleCountsResponse(self._coordinator.counts(since))

    def _configure(self, request: Message) -> Message:
        self._coordinator.configure(settings_of(expect(request, ConfigurePeopleRequest).settings))
        return Empty()
