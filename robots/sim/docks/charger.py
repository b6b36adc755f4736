"""Simulated charger: a box with a flat or a V-shaped face, and two contacts on it."""

import itertools
import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from ppaas.geometry import Pose2D, wrap_angle
from robots.sim.bodies.furniture import Furniture
from robots.sim.depth.shapes import box, shapes_of

GRAIN = 0.01
"""Radius of the discs of which the surface of a dock consists [m]."""

HEIGHT = 0.3
"""Height of a dock [m]."""


class ChargerFault(Enum):
    """What is wrong with a charger."""

    NOTHING = "nothing"
    DEAD = "it gives no current"
    LIAR = "it is reported as charging, and gives no current"


@dataclass(frozen=True, slots=True)
class ChargerModel:
    """Parameters of a charger.

    Parameters
    ----------
    width, depth : float
        Of the box [m].
    angle : float
        Angle between the two parts of its face [rad]; π for a flat one.
    lateral, forward, turn : float
        Largest differences to the docked pose with which the contacts touch [m, m, rad].
    current : float
        Current into a battery that is not full [A].
    """

    width: float = 0.4
    depth: float = 0.2
    angle: float = math.pi
    lateral: float = 0.02
    forward: float = 0.012
    turn: float = 0.15
    current: float = 3.0


class Charger:
    """One charger.

    Parameters
    ----------
    docked : Pose2D
        Pose of a docked robot in the frame of the map.
    reach : float
        Distance from the origin of a docked robot to the middle of the face [m].
    model : ChargerModel, optional
    fault : ChargerFault
    """

    def __init__(
        self,
        docked: Pose2D,
        reach: float,
        model: ChargerModel | None = None,
        fault: ChargerFault = ChargerFault.NOTHING,
    ) -> None:
        self.docked, self.model, self.fault = docked, model or ChargerModel(), fault
        self.face = docked @ Pose2D(reach, 0.0)

    def touches(self, robot: Pose2D) -> bool:
        """Return whether the contacts of a robot at a pose in the frame of the map touch the charger's."""
        off, model = self.docked.inverse() @ robot, self.model
        near = abs(off.y) <= model.lateral and -model.forward <= off.x <= model.forward
        return near and abs(wrap_angle(off.theta)) <= model.turn

    def current(self, robot: Pose2D) -> float:
        """Return the current that it gives to a robot at a pose [A]."""
        works = self.fault is ChargerFault.NOTHING and self.touches(robot)
        return self.model.current if works else 0.0

    def reports_charging(self, robot: Pose2D) -> bool:
        """Return whether a robot at a pose reports that it is charged."""
        return self.touches(robot) and self.fault is not ChargerFault.DEAD

    def body(self) -> Furniture:
        """Return its body, as lasers see it and robots touch it: discs along its outline."""
        half, depth = 0.5 * self.model.width, self.model.depth
        lip = half / math.tan(0.5 * self.model.angle) if self.model.angle < math.pi else 0.0
        corners = [(depth, -half), (-lip, -half), (0.0, 0.0), (-lip, half), (depth, half)]
        discs = []
        for (x0, y0), (x1, y1) in itertools.pairwise(corners):
            count = max(math.ceil(math.dist((x0, y0), (x1, y1)) / GRAIN), 1)
            for x, y in zip(np.linspace(x0, x1, count).tolist(), np.linspace(y0, y1, count).tolist(), strict=True):
                place = self.face @ Pose2D(x + GRAIN, y)
                discs.append((place.x, place.y, GRAIN))
        middle = self.face @ Pose2D(0.5 * depth, 0.0)
        shapes = shapes_of([], [box((0.0, 0.0, 0.5 * HEIGHT), (0.5 * depth, half, 0.5 * HEIGHT))]).placed(middle)
        return Furniture("charger", middle, shapes, tuple(discs), (0.5 * depth, half))
