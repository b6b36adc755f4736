"""Maps of the benches: generated ones by name, map files, and costmap images."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.maps.formats.netpbm import open_pgm
from ppaas.maps.generate import office, warehouse
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo, GridMap
from robots.client.map_files import read_map_file, yaml_of

MADE = {"office": lambda: office(seed=1), "warehouse": lambda: warehouse(seed=1)}
"""Generators of maps, by name."""

LETHAL = 254
"""Smallest value of a costmap image at which a cell is blocked."""
RESOLUTION = 0.05
"""Edge of a cell of a costmap image [m]."""


def read_map(name: str) -> GridMap:
    """Return a generated map by its name, or the map of a file.

    A file is a YAML file of map_server or its image. A PGM without a YAML file beside it is read as a costmap image,
    such as the one of Willow Garage with which ROS tests navfn, with cells of 0.05 m. Lethal cells (254 and 255) next
    to other cells become walls; the lethal cells behind them become unknown, as in a map made with a laser.

    Raises
    ------
    InvalidMap
        The map cannot be read.
    """
    if name in MADE:
        return MADE[name]()
    path = Path(name)
    if path.suffix.lower() != ".pgm" or yaml_of(path).exists():
        return read_map_file(path)
    try:
        image = open_pgm(path.read_bytes())
    except OSError as error:
        raise InvalidMap(f"cannot read the map: {error}") from error
    lethal = image.rows(0, image.shape[0])[::-1] >= LETHAL
    cells = np.where(lethal, np.where(_beside(~lethal), OCCUPIED, UNKNOWN), FREE).astype(np.int8)
    return GridMap(cells, GridInfo(RESOLUTION, cells.shape[1], cells.shape[0]))


def _beside(cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the marked cells and all their neighbours."""
    wide = np.pad(cells, 1)
    wide = wide[:-2] | wide[1:-1] | wide[2:]
    return wide[:, :-2] | wide[:, 1:-1] | wide[:, 2:]
