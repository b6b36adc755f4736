"""Simulated worlds of the mapping bench."""

from benchmarks.mapping import laboratory
from benchmarks.mapping.corridors import corridor_route, corridors
from benchmarks.mapping.office import office, route
from benchmarks.mapping.simulated_drive import Segments, SimulatedDrive, simulate

OFFICE, LABORATORY, CORRIDORS, EQUAL_CORRIDORS = "office", "laboratory", "corridors", "equal corridors"
"""Names of the worlds. In the equal corridors no door is open."""


def walls_of(world: str, seed: int) -> Segments:
    """Return the walls (n, 4) of a world: x0, y0, x1, y1 [m]."""
    if world == LABORATORY:
        return laboratory.laboratory(seed).walls
    if world == EQUAL_CORRIDORS:
        return corridors(seed, 0.0)
    return corridors(seed) if world == CORRIDORS else office(seed)


def drive_of(world: str, seed: int, sweep: float = 0.0) -> SimulatedDrive:
    """Return a drive through a world.

    Parameters
    ----------
    world : str
    seed : int
        Seed of the world, and of all noise.
    sweep : float
        Time that the laser takes for a scan [s].
    """
    walls = walls_of(world, seed)
    if world == LABORATORY:
        return simulate(walls, laboratory.laboratory(seed).route, seed, sweep=sweep, speed=laboratory.SPEED)
    return simulate(walls, route() if world == OFFICE else corridor_route(), seed, sweep=sweep)
