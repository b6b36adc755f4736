"""How much of its network a host uses: the counters of its fastest interface, and what that can carry."""

from collections.abc import Mapping
from typing import Protocol

import psutil

from ppaas.clock import Clock, monotonic

BITS = 8
MEGA = 1e6


class InterfaceState(Protocol):
    """What the system says of an interface."""

    @property
    def isup(self) -> bool:
        """Whether it is up."""

    @property
    def duplex(self) -> int:
        """Whether it sends and receives at a time, by a constant of psutil."""

    @property
    def speed(self) -> int:
        """In Mbit/s, 0 where the system does not know."""

    @property
    def flags(self) -> str:
        """What it is, by words with commas between them."""


def fastest(interfaces: Mapping[str, InterfaceState]) -> str | None:
    """Return the name of the fastest interface that is up and leads out of the host; None where there is none."""
    out = {name: state.speed for name, state in interfaces.items() if state.isup and "loopback" not in state.flags}
    return max(sorted(out), key=lambda name: out[name], default=None)


def capacity_of(state: InterfaceState) -> float:
    """Return what an interface can send and receive in a second [bytes]; 0 where that is not known."""
    ways = 1 if state.duplex == psutil.NIC_DUPLEX_HALF else 2
    return ways * state.speed * MEGA / BITS


class NetworkLoad:
    """What goes over the network of this host.

    Parameters
    ----------
    clock : callable
        Monotonic seconds.

    Attributes
    ----------
    capacity : float
        What it can send and receive in a second [bytes]; 0 where that is not known.
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        interfaces = psutil.net_if_stats()
        self._name = fastest(interfaces)
        self.capacity = capacity_of(interfaces[self._name]) if self._name is not None else 0.0
        self._clock = clock
        self._counted, self._at = self._count(), clock()

    def rate(self) -> float:
        """Return what was sent and received in a second since the last call [bytes]."""
        count, now = self._count(), self._clock()
        more, seconds = count - self._counted, now - self._at
        self._counted, self._at = count, now
        return max(more, 0) / seconds if seconds > 0.0 else 0.0  # counters begin anew with an interface

    def _count(self) -> int:
        counters = psutil.net_io_counters(pernic=True).get(self._name or "")
        return counters.bytes_sent + counters.bytes_recv if counters is not None else 0
