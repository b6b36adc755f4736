"""Chargers, shelves and batteries in a simulated world: at the docks that are drawn on its map."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ppaas.docking.dock import docks_of
from ppaas.docking.parameters import DockingParameters, DockType
from ppaas.parameters import read_parameters
from ppaas.zones.zone import ZoneSet
from robots.sim.docks.battery import BatteryModel, SimulatedBattery
from robots.sim.docks.charger import Charger
from robots.sim.docks.shelf import Shelf, SimulatedLift, shelf_under
from robots.sim.robot import SimulatedRobot, TurtlebotModel
from robots.sim.world import World

DOCKING_SERVER = "docking_server"
"""Name of the parameters that have the types of docks."""


def fit_chargers(world: World, zones: ZoneSet) -> tuple[Charger, ...]:
    """Put a charger into a world at each dock that charges; it belongs before the first people."""
    chargers = tuple(Charger(dock.pose, TurtlebotModel().radius) for dock in docks_of(zones) if dock.charges)
    for charger in chargers:
        world.add_furniture(charger.body())
    return chargers


def fit_shelves(world: World, zones: ZoneSet, types: Mapping[str, DockType]) -> tuple[Shelf, ...]:
    """Put a shelf into a world at each dock whose type has a load; they belong before the first people."""
    loads = [(dock.pose, types[dock.type].load) for dock in docks_of(zones) if dock.type in types]
    return tuple(shelf_under(world, pose, load) for pose, load in loads if load)


@dataclass(frozen=True, slots=True)
class DocksOfWorld:
    """Chargers and shelves at the docks of a world."""

    world: World
    chargers: tuple[Charger, ...]
    shelves: tuple[Shelf, ...]

    def parts_of(self, robot: SimulatedRobot, *, seed: int = 0, charge: float = 0.5) -> "DockingParts":
        """Return what a robot has for these docks: a battery, and a lift if there are shelves."""
        battery = RobotBattery(robot, self.chargers, seed=seed, charge=charge)
        return DockingParts(self.world.dt, battery, SimulatedLift(robot, self.shelves) if self.shelves else None)


def fit_docks(world: World, zones: ZoneSet, parameters: Mapping[str, Any]) -> DocksOfWorld:
    """Put a charger or a shelf at each dock of a world, by the types of docks in the parameters of a robot file.

    Raises
    ------
    InvalidParameter
        The parameters of ``docking_server`` are not valid.
    """
    types = read_parameters(DockingParameters, DOCKING_SERVER, parameters.get(DOCKING_SERVER, {})).dock_types
    return DocksOfWorld(world, fit_chargers(world, zones), fit_shelves(world, zones, types))


@dataclass(frozen=True, slots=True)
class DockingParts:
    """Parts of a robot that docks; ``step`` is the time between two calls of `after_step` [s]."""

    step: float
    battery: "RobotBattery"
    lift: SimulatedLift | None = None

    def after_step(self) -> None:
        """Simulate them for a step of the world."""
        self.battery.after_step(self.step)
        if self.lift is not None:
            self.lift.after_step(self.step)


class RobotBattery(SimulatedBattery):
    """Battery in a robot of a world.

    Parameters
    ----------
    robot : SimulatedRobot
    chargers : sequence of Charger
    seed : int
        Seed of the noise.
    model : BatteryModel, optional
    charge : float
        Charge at the start, as a part of the whole.
    """

    def __init__(
        self, robot: SimulatedRobot, chargers: Sequence[Charger], *, seed: int = 0, model: BatteryModel | None = None,
        charge: float = 0.5,
    ) -> None:  # fmt: skip
        super().__init__(chargers, np.random.default_rng((seed, 11)), model, charge)
        self._robot = robot

    def after_step(self, seconds: float) -> None:
        """Charge or discharge it for a step of the world [s]."""
        self.step(self._robot.base.pose, self._robot.base.wheels.linear, seconds)
