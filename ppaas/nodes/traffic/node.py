"""Node ``traffic``: grants the robots of a map how far they may drive."""

import math
from collections.abc import Callable
from typing import ClassVar

import numpy as np

from ppaas.costmap.map_layers import MapLayers
from ppaas.costmap.moving_obstacles import MovingObstacle
from ppaas.errors import InvalidInput, NotFound
from ppaas.messages.base.message import Empty, Message
from ppaas.messages.fleet.traffic import GetTraffic, PutBack, RobotOfTraffic, TakeOut, TrafficReport, TrafficState
from ppaas.messages.people_coordination import SEEN, PeopleState
from ppaas.messages.ppaas_msgs import RobotStates
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Node, Payload, Reply, Service, Topic
from ppaas.nodes.message_checks import expect
from ppaas.nodes.other_robots import others_of
from ppaas.traffic.coordinator import TrafficCoordinator, checkpoint_of, restore, state_of
from ppaas.traffic.members import PERSON, ROBOT
from ppaas.traffic.settings import TrafficParameters
from ppaas.traffic.sizes import MakeRoadmap
from ppaas.traffic.taking_part import TRAFFIC
from ppaas.zones.zone import ZonesInForce

PERIOD = 0.1
"""Time between two steps of the coordinator [s]."""

STATE_PERIOD = 1.0
"""Time between two messages about the traffic [s]."""

RADIUS = 0.25
"""Radius of other robots that do not report theirs [m]."""

PERSON_RADIUS = 0.4
"""Radius of a person, with a margin for the next steps [m]."""

GET_TRAFFIC = Service("traffic/get_traffic", GetTraffic)
TAKE_OUT = Service("traffic/take_out", TakeOut)
PUT_BACK = Service("traffic/put_back", PutBack)
LET_GO = Service("traffic/let_go", TakeOut)


class TrafficNode(Node):
    """Takes the reports of all robots of a user on a map that take part, and publishes their grants.

    The node has a separate container, beside the containers of the robots' clones. One that follows another, because
    its container was lost, asks all robots what they hold before it grants anything.

    Parameters
    ----------
    context : Context
        The node's context.
    make_roadmap : callable
        Returns a function that makes the roadmaps of a map, from its layers.
    layers : MapLayers
        The map, and its zones.
    parameters : TrafficParameters
    """

    name: ClassVar[str] = TRAFFIC
    subscribes: ClassVar[tuple[Topic, ...]] = (topics.TRAFFIC_REPORT, topics.ROBOTS, topics.PEOPLE_STATE)
    publishes: ClassVar[tuple[Topic, ...]] = (topics.TRAFFIC_GRANTS, topics.TRAFFIC_STATE)
    services: ClassVar[tuple[Service, ...]] = (GET_TRAFFIC, TAKE_OUT, PUT_BACK, LET_GO)

    def __init__(
        self,
        context: Context,
        make_roadmap: Callable[[MapLayers], MakeRoadmap],
        layers: MapLayers,
        parameters: TrafficParameters,
    ) -> None:
        super().__init__(context)
        self._make_roadmap = make_roadmap
        self._parameters = parameters
        self._seconds = 0.0
        self._coordinator = TrafficCoordinator(make_roadmap(layers), parameters, now=context.elapsed())
        self._layers, self._zones = layers, ZonesInForce(layers.zones)

    def start(self) -> None:
        """Begin to grant."""
        self.context.every(PERIOD, self._step)
        self.context.every(STATE_PERIOD, self._publish_state)

    def use_layers(self, layers: MapLayers) -> None:
        """Go on with another version of the map: all robots stop, and are granted cells of the new one.

        If only its zones are others, and no lanes are, robots drive on.
        """
        before, self._layers, self._zones = self._layers, layers, ZonesInForce(layers.zones)
        same = before.grid.info == layers.grid.info and np.array_equal(before.grid.data, layers.grid.data)
        if not same or before.zones.lanes != layers.zones.lanes:
            self._coordinator.occupancy.use_map(self._make_roadmap(layers))

    def on_message(self, topic: str, message: Payload) -> None:
        """Take the report of a robot, the positions of all, or people; `InvalidInput` if it is not valid."""
        if isinstance(message, RobotStates):
            self._coordinator.occupancy.see_others(ROBOT, others_of(message, RADIUS), self.context.elapsed())
            return
        if isinstance(message, PeopleState):
            self._coordinator.occupancy.see_others(PERSON, people_in(message), self.context.elapsed())
            return
        self._coordinator.report(expect(message, TrafficReport), self.context.elapsed())

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        """Answer with the traffic, or take a robot out, put it back, or forget it since it has left the map.

        Raises
        ------
        NotFound
            There is no such robot in the traffic.
        """
        if service == GET_TRAFFIC.name:
            reply(self._state())
            return
        occupancy = self._coordinator.occupancy
        changes = {
            TAKE_OUT.name: occupancy.take_out, PUT_BACK.name: occupancy.put_back, LET_GO.name: occupancy.let_go,
        }  # fmt: skip
        if service not in changes:
            raise NotFound("service", service, [each.name for each in self.services])
        changes[service](expect(request, RobotOfTraffic).robot)
        reply(Empty())

    def checkpoint(self) -> bytes:
        """Return the epoch, and what the robots hold."""
        return checkpoint_of(self._coordinator)

    def restore(self, state: bytes) -> None:
        """Continue after a checkpoint; what its robots held is held until they say otherwise."""
        restore(self._coordinator, state, self.context.elapsed())

    def _step(self) -> None:
        began = self.context.elapsed()
        self._coordinator.occupancy.use_zones(self._zones.at(self.context.now()))
        for grants in self._coordinator.step(began):
            self.context.publish(topics.TRAFFIC_GRANTS.name, grants)
        self._seconds += self.context.elapsed() - began

    def _state(self) -> TrafficState:
        return state_of(self._coordinator, self.context.now(), self.context.elapsed(), self._seconds)

    def _publish_state(self) -> None:
        self.context.publish(topics.TRAFFIC_STATE.name, self._state())


def people_in(message: PeopleState) -> list[MovingObstacle]:
    """Return the people whom a robot sees now, with a margin around each.

    Raises
    ------
    InvalidInput
        A position is not finite.
    """
    places = [(person.position.x, person.position.y) for person in message.people if person.state == SEEN]
    if not all(map(math.isfinite, (number for place in places for number in place))):
        raise InvalidInput("the position of a person is not finite")
    return [MovingObstacle(x, y, 0.0, 0.0, PERSON_RADIUS) for x, y in places]
