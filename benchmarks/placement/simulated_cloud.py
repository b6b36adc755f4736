"""A cloud without I/O: the real master, machines and endpoints that are names, and robots that come, go and roam.

A robot that roams comes to another endpoint: its place is requested again there, and the round trip to its machine is
measured anew. Each started container is reported as launched and ready at once.
"""

from collections import OrderedDict
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import islice

import numpy as np

from benchmarks.placement.arrivals import Event, RobotArrival
from benchmarks.placement.timed_master import TimedMaster
from engine.master.balancers.registry import BALANCERS, DEFAULT
from engine.master.events import (
    ContainerLaunched,
    ContainerReady,
    MachineJoined,
    PlaceReleased,
    PlaceRequested,
    RobotTimed,
)
from engine.master.master import Master
from engine.master.orders import Order, Start
from engine.master.places import PlaceRequest
from engine.master.quotas import Quota, Quotas
from ppaas.errors import Unavailable

CORES, MEMORY = 12, 1 << 36
"""CPUs and memory [bytes] of a machine: with three quarters of the robots connected, most machines have room."""

ROUND_TRIP = 0.002
"""Mean round trip between a robot and its machine [s]."""


def new_master() -> TimedMaster:
    """Return a master with the default balancer, whose users may have any number of containers."""
    quotas = Quotas(Quota(1 << 30, float(1 << 30)))
    return TimedMaster(Master(BALANCERS.create(DEFAULT, {}), quotas, id_suffix="-bench"))


def request_for(arrival: RobotArrival) -> PlaceRequest:
    """Return the request of a robot; the robots of a map have one owner."""
    spec = arrival.spec(0)
    return PlaceRequest(f"user-{arrival.map}", spec.map, spec.cores, spec.robot)


@dataclass(frozen=True, slots=True)
class Sizes:
    """Numbers of machines, endpoints and robots, of whom at most three quarters are connected at once."""

    machines: int
    endpoints: int
    robots: int


class SimulatedCloud:
    """A master with its machines, its endpoints and their robots.

    Parameters
    ----------
    sizes : Sizes
    seed : int
        Random seed of the endpoints and of the robots that roam.
    """

    def __init__(self, sizes: Sizes, seed: int = 1) -> None:
        self.timed = new_master()
        self._random = np.random.default_rng(seed)
        self._endpoints: list[OrderedDict[str, PlaceRequest]] = [OrderedDict() for _ in range(sizes.endpoints)]
        self._endpoint_of: dict[str, int] = {}
        self.rejected = 0
        for number in range(sizes.machines):
            self.join(f"m{number:05}")

    def join(self, machine: str) -> None:
        """Let a machine join that runs no containers."""
        self.timed.handle("join", MachineJoined(machine, CORES, MEMORY, 1))

    def take(self, event: Event) -> None:
        """Let a robot come, and one of those that are connected roam; or let a robot go."""
        request = request_for(event.robot)
        if event.comes:
            self._come(request)
            self._roam()
        elif request.key in self._endpoint_of:
            self.go(request.key)

    def go(self, key: str, kind: str = "release") -> None:
        """Let the robot of a place go."""
        del self._endpoints[self._endpoint_of.pop(key)][key]
        self.timed.handle(kind, PlaceReleased(key))

    def connected(self, count: int) -> list[str]:
        """Return the places of some connected robots."""
        return list(islice(self._endpoint_of, count))

    def _come(self, request: PlaceRequest) -> None:
        try:
            orders = self.timed.handle("place", PlaceRequested(request))
        except Unavailable:
            self.rejected += 1
            return
        self.start(orders)
        self._attach(request)

    def _attach(self, request: PlaceRequest) -> None:
        endpoint = int(self._random.integers(len(self._endpoints)))
        self._endpoints[endpoint][request.key] = request
        self._endpoint_of[request.key] = endpoint

    def start(self, orders: Iterable[Order]) -> None:
        """Report the containers that are to be started as launched and ready."""
        for order in orders:
            if isinstance(order, Start):
                self.timed.handle("launched", ContainerLaunched(order.machine, order.spec.id, 1))
                self.start(self.timed.handle("ready", ContainerReady(order.spec.id, 1)))

    def _roam(self) -> None:
        """Let the robot roam that has been longest at one of the endpoints."""
        robots = self._endpoints[int(self._random.integers(len(self._endpoints)))]
        if robots:
            key, request = robots.popitem(last=False)
            self.timed.handle("roam", PlaceRequested(request))
            self.timed.handle("round trip", RobotTimed(key, float(self._random.exponential(ROUND_TRIP))))
            self._attach(request)

    def lose_endpoint(self) -> None:
        """Let all robots of an endpoint come to others."""
        robots, self._endpoints[0] = self._endpoints[0], OrderedDict()
        events = [PlaceRequested(request) for request in robots.values()]
        self.timed.timed("endpoint lost", lambda: [self.timed.master.handle(event) for event in events])
        for request in robots.values():
            self._attach(request)
