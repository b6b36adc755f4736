"""Worlds of the BARN benchmark: cylinders and the length of a reference path."""

from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, NotFound
from ppaas.geometry import Pose2D

START = Pose2D(-2.0, 3.0, 1.57)
"""Start pose of every run in the frame of the world [m, rad]."""
GOAL = Pose2D(-2.0, 13.0)
"""Goal of every run in the frame of the world [m]."""
GOAL_TOLERANCE = 1.0
"""Distance from the goal at which a run has succeeded [m]."""
TIME_LIMIT = 100.0
"""Time limit of a run [s]."""
FULL_SPEED = 2.0
"""Speed at which the time of the reference path is computed [m/s]."""


class BarnWorld(msgspec.Struct, frozen=True):
    """A world.

    Parameters
    ----------
    world : int
        Its number among the 300 of the benchmark (Perille et al., "Benchmarking Metric Ground Navigation", 2020).
    radius : float
        Radius of each cylinder [m].
    cylinders : list of (x, y)
        Centres of the cylinders [m].
    path_length : float
        Length of the reference path [m].
    """

    world: int
    radius: float
    cylinders: list[tuple[float, float]]
    path_length: float

    @property
    def centres(self) -> NDArray[np.float64]:
        """(n, 2) centres of the cylinders [m]."""
        return np.array(self.cylinders, dtype=np.float64).reshape(-1, 2)

    @property
    def best_time(self) -> float:
        """Time of the reference path at full speed [s]."""
        return self.path_length / FULL_SPEED


def read_worlds(path: Path, numbers: tuple[int, ...] = (), radius: float | None = None) -> list[BarnWorld]:
    """Read a file of worlds.

    Parameters
    ----------
    path : Path
        JSON: a list of objects of ``world``, ``radius``, ``cylinders`` and ``path_length``.
    numbers : tuple of int
        Numbers of the worlds to return; empty for all.
    radius : float, optional
        Radius of the cylinders instead of the file's [m].

    Raises
    ------
    InvalidInput
        The file cannot be read, or its content is invalid.
    NotFound
        The file has no world of one of the numbers.
    """
    try:
        worlds = from_json(path.read_bytes(), list[BarnWorld])
    except (OSError, msgspec.MsgspecError) as error:
        raise InvalidInput(f"{path} is not a file of BARN worlds: {error}") from error
    known = {each.world: each for each in worlds}
    for number in numbers:
        if number not in known:
            raise NotFound("world", str(number), [str(each) for each in known])
    chosen = [known[number] for number in numbers] or worlds
    chosen = [_checked(msgspec.structs.replace(each, radius=radius or each.radius)) for each in chosen]
    if not chosen:
        raise InvalidInput(f"{path} has no worlds")
    return chosen


def _checked(world: BarnWorld) -> BarnWorld:
    finite = np.isfinite(world.centres).all() and np.isfinite((world.radius, world.path_length)).all()
    if not (finite and world.radius > 0.0 and world.path_length > 0.0):
        raise InvalidInput(f"world {world.world}: cylinders must be finite, and radius and path_length above 0")
    return world
