"""Fleet of the energy bench: robots with batteries, chargers, and places of tasks in a hall."""

import argparse
from dataclasses import dataclass

import numpy as np

from ppaas.energy.battery import Battery
from ppaas.energy.sites import Sites
from ppaas.tasks.orders import RobotNow
from ppaas.tasks.records import Place

HALL = 120.0, 80.0
"""Size of the hall [m]."""

STATIONS = 16
"""Number of places where tasks pick and drop."""

PER_METRE, PER_SECOND = 6e-5, 1e-5
"""Charge that a metre and a second cost: 7 h of driving."""

HANDLING = 30.0
"""Time that a robot is loaded, and unloaded [s]."""


@dataclass(frozen=True, slots=True)
class ChargingFleet:
    """Robots with their batteries, chargers, and places of tasks."""

    robots: dict[str, RobotNow]
    sites: Sites
    places: list[Place]
    gain: float

    @classmethod
    def of(cls, arguments: argparse.Namespace, rng: np.random.Generator) -> "ChargingFleet":
        """Return a fleet of a size, at random places with random charges."""
        gain = 1.0 / (60.0 * arguments.charge_minutes)
        robots = {
            f"r{number:03d}": RobotNow(_place(rng), battery=Battery(float(charge), PER_METRE, PER_SECOND, gain))
            for number, charge in enumerate(rng.uniform(0.3, 1.0, arguments.robots))
        }
        step = HALL[0] / arguments.chargers
        chargers: dict[str, Place] = {f"c{n}": ((n + 0.5) * step, 0.0, 0.0) for n in range(arguments.chargers)}
        return cls(robots, Sites(chargers), [_place(rng) for _ in range(STATIONS)], gain)


def _place(rng: np.random.Generator) -> Place:
    return float(rng.uniform(0.0, HALL[0])), float(rng.uniform(0.0, HALL[1])), 0.0
