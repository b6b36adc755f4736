"""The maps that a robot is localized in."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.maps.formats.pgm import parse_pgm
from ppaas.maps.generate import office, warehouse
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo, GridMap
from robots.client.map_files import read_map_file
from robots.plans.offline import yaml_of

MADE = {"office": lambda: office(seed=1), "warehouse": lambda: warehouse(seed=1)}
"""Maps that need no file, by name."""

LETHAL = 254
RESOLUTION = 0.05


def read_map(name: str) -> GridMap:
    """Return a map: one that is made up, by its name, or that of a file.

    A file is a YAML file of map_server or its image. A PGM without a YAML file beside it is a costmap image, as ROS
    keeps one of Willow Garage to test navfn with: what is lethal (254 and 255) beside what is not is a wall, what is
    lethal behind that is unknown, as to a robot that made the map with its laser, and a cell has 0.05 m.

    Raises
    ------
    InvalidMap
        It cannot be read.
    """
    if name in MADE:
        return MADE[name]()
    path = Path(name)
    if path.suffix.lower() != ".pgm" or yaml_of(path).exists():
        return read_map_file(yaml_of(path))
    try:
        pixels = parse_pgm(path.read_bytes())
    except OSError as error:
        raise InvalidMap(f"cannot read the map: {error}") from error
    lethal = pixels[::-1] >= LETHAL
    cells = np.where(lethal, np.where(_beside(~lethal), OCCUPIED, UNKNOWN), FREE).astype(np.int8)
    return GridMap(cells, GridInfo(RESOLUTION, cells.shape[1], cells.shape[0]))


def _beside(cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the cells that are marked, and all around them."""
    wide = np.pad(cells, 1)
    wide = wide[:-2] | wide[1:-1] | wide[2:]
    return wide[:, :-2] | wide[:, 1:-1] | wide[:, 2:]
