"""What a balancer is asked."""

from collections.abc import Iterable
from typing import Protocol

from engine.machine import Machine
from engine.model import ContainerSpec


class Balancer(Protocol):
    """Chooses a machine; it changes nothing."""

    name: str

    def choose(self, spec: ContainerSpec, machines: Iterable[Machine]) -> Machine | None:
        """Return the machine for a container, or None if no machine has room.

        ``machines`` come in the order in which they registered.
        """
        ...
