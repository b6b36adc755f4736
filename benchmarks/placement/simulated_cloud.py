"""A cloud without I/O: the real master, timed by kind of event, and machines, endpoints and robots that are names.

A robot that roams comes to another endpoint: its place is requested again there, and the round trip to its machine is
measured anew. Each started container is reported as launched and ready at once.
"""

import contextlib
import gc
import time
from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from typing import TypeVar

import msgspec
import numpy as np

from benchmarks.placement.arrivals import Event, RobotArrival
from engine.master.balancers.registry import BALANCERS, DEFAULT
from engine.master.events import (
    ContainerLaunched,
    ContainerReady,
    MachineJoined,
    PlaceReleased,
    PlaceRequested,
    RobotTimed,
)
from engine.master.events import Event as MasterEvent
from engine.master.master import Master
from engine.master.orders import Order, Start
from engine.master.places import PlaceRequest
from engine.master.quotas import Quota, Quotas
from ppaas.errors import Unavailable

T = TypeVar("T")


class Cost(msgspec.Struct):
    """CPU time of one kind of work.

    Parameters
    ----------
    count : int
        Number of times that it was done.
    seconds, longest : float
        CPU time of all of them, and of the longest [s].
    """

    count: int = 0
    seconds: float = 0.0
    longest: float = 0.0

    def add(self, seconds: float) -> None:
        """Add the CPU time of one [s]."""
        self.count += 1
        self.seconds += seconds
        self.longest = max(self.longest, seconds)

    @property
    def mean(self) -> float:
        """CPU time of one, on average [s]; 0 if it was never done."""
        return self.seconds / self.count if self.count else 0.0


class TimedMaster:
    """Hands events to a master, and times it.

    Parameters
    ----------
    master : Master
        The master under test.

    Attributes
    ----------
    costs : dict of str to Cost
        CPU time by kind of event. It includes garbage collections that begin meanwhile, as in a cloud.
    """

    def __init__(self, master: Master) -> None:
        self.master = master
        self.costs: dict[str, Cost] = {}

    def handle(self, kind: str, event: MasterEvent) -> list[Order]:
        """Hand over an event; raises as ``Master.handle``."""
        return self.timed(kind, lambda: self.master.handle(event))

    def timed(self, kind: str, work: Callable[[], T]) -> T:
        """Do some work and time it as an event of a kind."""
        cost = self.costs.setdefault(kind, Cost())
        began = time.thread_time()
        try:
            return work()
        finally:
            cost.add(time.thread_time() - began)


@contextlib.contextmanager
def timed_collections() -> Iterator[Cost]:
    """Yield the CPU time of garbage collections in the block; the time of the events includes it."""
    cost, began = Cost(), 0.0

    def note(phase: str, _: dict[str, int]) -> None:
        nonlocal began
        if phase == "start":
            began = time.thread_time()
        else:
            cost.add(time.thread_time() - began)

    gc.callbacks.append(note)
    try:
        yield cost
    finally:
        gc.callbacks.remove(note)


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
