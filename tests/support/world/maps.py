"""Random maps and poses, and the content of map files."""

from pathlib import Path

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.maps.formats.map_files import load_map
from ppaas.maps.grid import GridInfo, GridMap

YAML = (
    b"image: a.pgm\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
)


def sides(most: int) -> st.SearchStrategy[tuple[int, int]]:
    """Draw heights and widths."""
    return st.tuples(st.integers(1, most), st.integers(1, most))


def occupied_arrays(most: int = 12) -> st.SearchStrategy[NDArray[np.uint8]]:
    """Draw small arrays of 0 and 1, sparse and dense, empty and full."""
    elements = st.sampled_from([[0], [1], [0, 1], [0, 0, 0, 0, 0, 1]]).flatmap(st.sampled_from)
    return hnp.arrays(np.uint8, sides(most), elements=elements)


def poses(most: float = 10.0) -> st.SearchStrategy[Pose2D]:
    """Draw poses, many of them on the edges of cells, or with headings along an axis or a diagonal."""
    place = st.one_of(st.integers(-int(most), int(most)).map(float), st.floats(-most, most))
    heading = st.one_of(st.integers(-8, 8).map(lambda i: i * np.pi / 4), st.floats(-7.0, 7.0))
    return st.builds(Pose2D, place, place, heading)


def grid_maps(values: list[int], most: int = 12) -> st.SearchStrategy[GridMap]:
    """Draw small maps with cells of the given values, of any resolution and origin."""

    def grid(data: NDArray[np.int8], resolution: float, origin: Pose2D) -> GridMap:
        return GridMap(data, GridInfo(resolution, data.shape[1], data.shape[0], origin))

    cells = hnp.arrays(np.int8, sides(most), elements=st.sampled_from(values))
    return st.builds(grid, cells, st.floats(1e-3, 10.0), poses())


def grid_of(occupied: NDArray[np.uint8], resolution: float = 1.0, origin: Pose2D = Pose2D(0.0, 0.0)) -> GridMap:
    """Return a map of occupied (not 0) and free cells."""
    info = GridInfo(resolution, occupied.shape[1], occupied.shape[0], origin)
    return GridMap(np.where(occupied, 100, 0).astype(np.int8), info)


def real_map(data: Path, name: str) -> GridMap:
    """Read one of the real ROS maps."""
    record = data / "ros" / f"{name}.yaml"
    return load_map(record.read_bytes(), record.with_suffix(".pgm").read_bytes())
