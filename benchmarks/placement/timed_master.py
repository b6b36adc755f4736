"""The master of a cloud without I/O, with the CPU time of its decisions by the kind of event."""

import contextlib
import gc
import time
from collections.abc import Callable, Iterator
from typing import TypeVar

import msgspec

from engine.master.events import Event
from engine.master.master import Master
from engine.master.orders import Order

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

    def handle(self, kind: str, event: Event) -> list[Order]:
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
    """Yield the CPU time of the garbage collections within the block, which is part of that of the events."""
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
