"""Machines and containers for tests of placement."""

from typing import Any

from engine.master.events import MachineJoined
from engine.master.machine import Machine
from engine.specs.containers import ContainerSpec, MapVersion, RobotConfig


def machine(name: str, cores: int = 2, **fields: Any) -> Machine:
    """Return a machine of one GiB."""
    return Machine(name, cores, 1 << 30, 1000, **fields)


def joined(name: str, cores: int = 2, *, memory: int = 1 << 30, **fields: Any) -> MachineJoined:
    """Return the event that a machine, of one GiB by default, joins."""
    return MachineJoined(name, cores, memory, 1000, **fields)


def spec(
    container: str, cores: float = 1.0, map_id: str = "office", robot: str | None = None, **fields: Any
) -> ContainerSpec:
    """Return a container of the user ann, for a robot if one is named."""
    config = None if robot is None else RobotConfig(robot, "turtlebot2", (0.0, 0.0, 0.0), "dijkstra", "dwa")
    return ContainerSpec(container, "ann", MapVersion(map_id, "v1"), cores, config, **fields)
