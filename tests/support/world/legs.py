"""Room with people whose legs a laser sees."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.obstacle_layer import LaserReading
from ppaas.geometry import Pose2D
from ppaas.messages.sensor_msgs import LaserScan
from robots.sim.laser import Discs, Laser, LaserModel
from tests.support.world.rooms import room

GRID = room(12.0, 10.0)
LAYERS = build_layers(GRID, robot_radius=0.18)
MODEL = LaserModel()
LEG_RADIUS, CHAIR_LEG = 0.06, 0.02
NOTHING = np.empty((0, 2))


def stand(x: float, y: float, facing: float = 0.0, swing: float = 0.0) -> NDArray[np.float64]:
    """Return the (2, 2) centres of the legs of a person; ``swing`` is how far the left one is ahead [m]."""
    cos, sin = math.cos(facing), math.sin(facing)
    return np.array([(x + s * cos - w * sin, y + s * sin + w * cos) for s, w in ((swing, 0.1), (-swing, -0.1))])


def walk(start: tuple[float, float], heading: float, seconds: float, speed: float = 1.2) -> NDArray[np.float64]:
    """Return the centres of the legs of a person who walks."""
    x, y = start[0] + speed * seconds * math.cos(heading), start[1] + speed * seconds * math.sin(heading)
    return stand(x, y, heading, 0.3 * math.sin(6.0 * seconds))


def chair(x: float, y: float) -> NDArray[np.float64]:
    """Return the (4, 2) centres of the legs of a chair."""
    return np.array([(x + i, y + k) for i in (-0.2, 0.2) for k in (-0.2, 0.2)])


def ranges_of(laser: Pose2D, legs: NDArray[np.float64], *others: Discs, seed: int = 1) -> NDArray[np.float64]:
    """Return the ranges that a laser measures, with noise."""
    measured = Laser(GRID.data >= 65, GRID.info, MODEL, np.random.default_rng(seed))
    return measured.measure(laser, (legs, LEG_RADIUS), *others)


def reading_of(laser: Pose2D, legs: NDArray[np.float64], *others: Discs, seed: int = 1) -> LaserReading:
    """Return a scan in the frame of the room."""
    return LaserReading(laser, MODEL.angles, ranges_of(laser, legs, *others, seed=seed))


def scan_of(laser: Pose2D, stamp: float, legs: NDArray[np.float64] = NOTHING, seed: int = 1) -> LaserScan:
    """Return a scan as a message, of a laser in the centre of its robot."""
    made = Laser(GRID.data >= 65, GRID.info, MODEL, np.random.default_rng(seed))
    return made.scan(ranges_of(laser, legs, seed=seed), stamp, "")
