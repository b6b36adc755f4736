"""A custom balancer: chooses the machine that runs the fewest containers."""

from typing import ClassVar

from engine.master.balancer import Balancer
from engine.master.machine import Machine
from engine.specs.containers import ContainerSpec


class Fewest(Balancer):
    """Chooses among the machines that have room; of equal ones, that which registered first."""

    name: ClassVar[str] = "fewest"
    purpose: ClassVar[str] = "The machine with the fewest containers."

    def choose(self, spec: ContainerSpec) -> Machine | None:
        suitable = (machine for machine in self.machines.values() if machine.has_room(spec))
        return min(suitable, key=lambda machine: len(machine.containers), default=None)
