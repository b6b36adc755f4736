"""Mirrors on the walls of a simulated world: they show people to depth cameras where nobody is."""

import math

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.maps.raycast import cast_rays
from robots.sim.bodies.furniture import mirror
from robots.sim.shortest_paths import ShortestPaths
from robots.sim.world import World

WIDTH = 1.2
"""Width of a mirror [m]."""
NEAREST, FARTHEST = 0.6, 4.0
"""Distance to a wall at which a place for a mirror is looked for [m]."""
TRIES = 50
"""Number of places examined for each mirror."""
GAP = 0.03
"""Distance of a mirror from its wall [m]."""


def hang_mirrors(world: World, ways: ShortestPaths, number: int) -> int:
    """Hang mirrors on straight walls that face places where people walk; return how many found a wall.

    Parameters
    ----------
    world : World
    ways : ShortestPaths
        Source of random places.
    number : int
        Number of mirrors.
    """
    hung = 0
    for _ in range(number * TRIES):
        if hung == number:
            break
        place = _on_wall(world, ways.anywhere())
        if place is not None:
            world.add_furniture(mirror(place, WIDTH, 0.2, 2.0))
            hung += 1
    return hung


def _on_wall(world: World, here: Pose2D) -> Pose2D | None:
    """Return the pose of a mirror on the wall that one of the axes of the map meets from here; None without one."""
    info = world.grid.info
    heading = info.origin.theta + 0.5 * math.pi * round(here.theta / (0.5 * math.pi))
    eye = Pose2D(here.x, here.y, heading)
    sides = [eye @ Pose2D(0.0, offset) for offset in np.linspace(-0.5 * WIDTH, 0.5 * WIDTH, 7).tolist()]
    ranges = np.array([cast_rays(world.occupied, info, side, np.zeros(1), FARTHEST)[0] for side in sides])
    if not (np.isfinite(ranges).all() and ranges.min() >= NEAREST and np.ptp(ranges) < 0.5 * info.resolution):
        return None
    # The front of a mirror faces the room.
    return eye @ Pose2D(float(ranges.min()) - GAP, 0.0, math.pi)
