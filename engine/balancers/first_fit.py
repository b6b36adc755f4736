"""Rapyuta's balancer: the first registered machine with enough free size (``rce-core``, ``MachineManager``)."""

from collections.abc import Iterable

from engine.machine import Machine
from engine.model import ContainerSpec


class FirstFit:
    """Take the first machine with room."""

    name = "first_fit"

    def choose(self, spec: ContainerSpec, machines: Iterable[Machine]) -> Machine | None:
        """Return the first machine that has room for the container."""
        return next((machine for machine in machines if machine.has_room(spec)), None)
