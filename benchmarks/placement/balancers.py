"""Comparison of balancers: each places the same robots on the same simulated machines.

The bench compares the traffic between machines, since robots of one map receive each other's poses, the rejected
containers, and the balance of the load. The balancers are those of the cloud.
"""

import math
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.placement.arrivals import Event, events, generated, recorded
from engine.master.balancer import Balancer
from engine.master.balancers.registry import BALANCERS
from engine.master.machine import Machine
from engine.specs.containers import ContainerSpec
from ppaas.clock import monotonic

if TYPE_CHECKING:
    from rich.progress import Progress

TOLD_PER_SECOND = 10.0
TOLD_BYTES = 200
"""Frequency [Hz] and size [bytes] of the messages from a robot to the others of its map."""

LAYER_BYTES = 48e6
"""Memory of the layers of a map of 2000 by 2000 cells, on each machine with a container of that map [bytes]."""

SAMPLES = 200
"""Number of samples of the machines between the first event and the last."""


@dataclass(frozen=True, slots=True)
class PlacementOptions:
    """Settings of the comparison; ``arrivals`` is a file of recorded arrivals, which replaces generated ones."""

    robots: int
    machines: int
    cores: int
    maps: int
    seed: int
    balancers: tuple[str, ...]
    arrivals: Path | None = None


class Spread:
    """Distribution of maps over machines, updated with each container that is placed or removed."""

    def __init__(self) -> None:
        self._members: defaultdict[str, defaultdict[str, int]] = defaultdict(lambda: defaultdict(int))
        self._robots: defaultdict[str, int] = defaultdict(int)
        self.copies = 0
        """Number of pairs of a map and a machine with its layers."""
        self.messages = 0
        """Number of pairs of a robot and another machine that receives its messages."""

    def count(self, machine: str, spec: ContainerSpec, by: int) -> None:
        """Add (``by`` 1) or remove (``by`` -1) a container of a machine."""
        group = spec.group
        members = self._members[group]
        self.messages -= self._robots[group] * max(len(members) - 1, 0)
        self.copies -= len(members)
        members[machine] += by
        if not members[machine]:
            del members[machine]
        self._robots[group] += by
        self.copies += len(members)
        self.messages += self._robots[group] * max(len(members) - 1, 0)


class PlacementSimulation:
    """Simulated machines on which a balancer places containers.

    Parameters
    ----------
    balancer : Balancer
        Balancer under test.
    machines : int
        Number of machines.
    cores : int
        CPUs of each machine.
    """

    def __init__(self, balancer: Balancer, machines: int, cores: int) -> None:
        self._balancer = balancer
        self._machines = [Machine(f"m{number}", cores, 1 << 35, 0) for number in range(machines)]
        for machine in self._machines:
            balancer.joined(machine)
        self._where: dict[int, tuple[Machine, ContainerSpec]] = {}
        self._spread = Spread()
        self._samples: list[tuple[float, float, float, float]] = []
        self.placed = self.rejected = 0
        self.seconds = 0.0

    def take(self, event: Event) -> None:
        """Place or remove the container of a robot."""
        if event.comes:
            self._place(event.number, event.robot.spec(event.number))
        elif event.number in self._where:
            machine, spec = self._where.pop(event.number)
            began = monotonic()
            machine.remove(spec.id)
            self._balancer.removed(machine, spec)
            self.seconds += monotonic() - began
            self._spread.count(machine.id, spec, -1)

    def _place(self, number: int, spec: ContainerSpec) -> None:
        began = monotonic()
        machine = self._balancer.choose(spec)
        if machine is not None:
            machine.place(spec)
            self._balancer.placed(machine, spec)
        self.seconds += monotonic() - began
        if machine is None:
            self.rejected += 1
            return
        self.placed += 1
        self._where[number] = machine, spec
        self._spread.count(machine.id, spec, 1)

    def look(self) -> None:
        """Take a sample of traffic, layers, machines in use and unevenness."""
        used = np.array([machine.given / machine.capacity for machine in self._machines])
        in_use = used[used > 0.0]
        uneven = float(in_use.std() / in_use.mean()) if in_use.size else 0.0
        traffic = self._spread.messages * TOLD_PER_SECOND * TOLD_BYTES / 1e6
        self._samples.append((traffic, self._spread.copies * LAYER_BYTES / 1e9, float(in_use.size), uneven))

    def told(self) -> dict[str, Any]:
        """Return the results: means over the samples, and the rate of placements."""
        traffic, copies, in_use, uneven = np.array(self._samples).T
        decisions = self.placed + self.rejected
        return {
            "placed": self.placed,
            "rejected": self.rejected,
            "cross_machine_mb_per_second": float(traffic.mean()),
            "layers_gb": float(copies.mean()),
            "machines_in_use": float(in_use.mean()),
            "unevenness": float(uneven.mean()),
            "placements_per_second": decisions / self.seconds if self.seconds else math.inf,
        }


def measure(options: PlacementOptions, progress: "Progress") -> dict[str, Any]:
    """Place the same robots with each balancer.

    Raises
    ------
    NotFound
        A balancer is not installed.
    InvalidInput
        The file of recorded arrivals is invalid.
    """
    balancers = {name: BALANCERS.create(name, {}) for name in options.balancers}
    total = sum(1 for _ in _arrivals(options)())
    return {
        "machines": options.machines,
        "cores": options.cores,
        "robots": total,
        "balancers": {
            name: _simulate(
                PlacementSimulation(balancer, options.machines, options.cores), options, total, name, progress
            )
            for name, balancer in balancers.items()
        },
    }


def _arrivals(options: PlacementOptions) -> Callable[[], Iterator[Any]]:
    if options.arrivals is not None:
        return lambda: recorded(options.arrivals)  # type: ignore[arg-type]  # it is not None
    return lambda: generated(options.robots, options.maps, options.seed)


def _simulate(
    simulation: PlacementSimulation, options: PlacementOptions, total: int, name: str, progress: "Progress"
) -> dict[str, Any]:
    task, arrived = progress.add_task(name, total=total), 0
    every = max(1, total // SAMPLES)
    for event in events(_arrivals(options)()):
        simulation.take(event)
        arrived += event.comes
        if event.comes and arrived % every == 0:
            simulation.look()
            progress.update(task, completed=arrived)
    progress.remove_task(task)
    return simulation.told()
