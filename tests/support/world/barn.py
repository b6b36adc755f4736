"""A small world like those of BARN: walls on three sides, and a pillar between them."""

import json
from pathlib import Path

import numpy as np

from benchmarks.navigation.barn.worlds import BarnWorld

WALL_X = (-4.425, -0.075)


def cylinders(*more: tuple[float, float]) -> list[tuple[float, float]]:
    """Return the centres of the walls' cylinders, and further ones."""
    along = np.arange(0.075, 9.6, 0.15).tolist()
    across = np.arange(WALL_X[0], WALL_X[1], 0.15).tolist()
    return [*((x, y) for x in WALL_X for y in along), *((x, 0.075) for x in across), *more]


def world(number: int = 7, *more: tuple[float, float]) -> BarnWorld:
    """Return a world with a pillar straight ahead, and more cylinders."""
    return BarnWorld(number, 0.075, cylinders((-2.0, 6.0), (-2.15, 6.0), *more), 10.2)


def shut() -> BarnWorld:
    """Return a world with a wall across it."""
    return world(8, *((x, 7.0) for x in np.arange(WALL_X[0], WALL_X[1], 0.15).tolist()))


def write(path: Path, *worlds: BarnWorld) -> Path:
    """Write a file of worlds."""
    records = [
        {"world": w.world, "radius": w.radius, "cylinders": w.cylinders, "path_length": w.path_length} for w in worlds
    ]
    path.write_text(json.dumps(records), encoding="utf-8")
    return path
