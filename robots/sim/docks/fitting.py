"""Chargers and batteries in a simulated world: at the docks that are drawn on its map."""

from collections.abc import Sequence

import numpy as np

from ppaas.docking.dock import docks_of
from ppaas.zones.zone import ZoneSet
from robots.sim.docks.battery import BatteryModel, SimulatedBattery
from robots.sim.docks.charger import Charger
from robots.sim.robot import SimulatedRobot, TurtlebotModel
from robots.sim.world import World


def fit_chargers(world: World, zones: ZoneSet) -> tuple[Charger, ...]:
    """Put a charger into a world at each dock that charges; it belongs before the first people."""
    chargers = tuple(Charger(dock.pose, TurtlebotModel().radius) for dock in docks_of(zones) if dock.charges)
    for charger in chargers:
        world.add_furniture(charger.body())
    return chargers


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
