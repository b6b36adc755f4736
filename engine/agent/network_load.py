"""Network load of a host: bytes per second on its fastest interface, and the capacity of that interface."""

from collections.abc import Mapping
from typing import Protocol

import psutil

from ppaas.clock import Clock, monotonic

BITS = 8
MEGA = 1e6


class InterfaceState(Protocol):
    """State of a network interface, as psutil reports it."""

    @property
    def isup(self) -> bool:
        """True if the interface is up."""

    @property
    def duplex(self) -> int:
        """Duplex mode, as a ``NIC_DUPLEX_`` constant of psutil."""

    @property
    def speed(self) -> int:
        """Speed [Mbit/s]; 0 if unknown."""

    @property
    def flags(self) -> str:
        """Flags, as words separated by commas."""


def fastest(interfaces: Mapping[str, InterfaceState]) -> str | None:
    """Return the name of the fastest interface that is up and not a loopback; None if none is."""
    out = {name: state.speed for name, state in interfaces.items() if state.isup and "loopback" not in state.flags}
    return max(sorted(out), key=lambda name: out[name], default=None)


def capacity_of(state: InterfaceState) -> float:
    """Return the capacity of an interface, both directions together [bytes/s]; 0 if unknown."""
    ways = 1 if state.duplex == psutil.NIC_DUPLEX_HALF else 2
    return ways * state.speed * MEGA / BITS


class NetworkLoad:
    """Traffic of this host on its fastest interface.

    Parameters
    ----------
    clock : callable
        Returns monotonic time [s].

    Attributes
    ----------
    capacity : float
        Capacity, both directions together [bytes/s]; 0 if unknown.
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        interfaces = psutil.net_if_stats()
        self._name = fastest(interfaces)
        self.capacity = capacity_of(interfaces[self._name]) if self._name is not None else 0.0
        self._clock = clock
        self._counted, self._at = self._count(), clock()

    def rate(self) -> float:
        """Return the mean traffic since the last call, both directions together [bytes/s]."""
        count, now = self._count(), self._clock()
        more, seconds = count - self._counted, now - self._at
        self._counted, self._at = count, now
        return max(more, 0) / seconds if seconds > 0.0 else 0.0  # counters restart at 0 with an interface

    def _count(self) -> int:
        counters = psutil.net_io_counters(pernic=True).get(self._name or "")
        return counters.bytes_sent + counters.bytes_recv if counters is not None else 0
