"""Small maps at random, with distances to their obstacles."""

import math
from typing import NamedTuple

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo


class Floor(NamedTuple):
    """Distances of the cells of a map to the nearest obstacle [m], and the geometry of the map."""

    to_lethal: NDArray[np.float32]
    info: GridInfo


def floor_of(lethal: NDArray[np.bool_], resolution: float = 0.1, origin: Pose2D = Pose2D(0.0, 0.0, 0.0)) -> Floor:
    """Return the distances of a map from their definition; 1,000 m without an obstacle."""
    places = np.stack(np.indices(lethal.shape), axis=-1)
    distance = np.full(lethal.shape, 1000.0)
    for place in np.argwhere(lethal):
        distance = np.minimum(distance, resolution * np.hypot(*np.moveaxis(places - place, -1, 0)))
    return Floor(distance.astype(np.float32), GridInfo(resolution, lethal.shape[1], lethal.shape[0], origin))


@st.composite
def floors(draw: st.DrawFn, *, turned: bool = False) -> Floor:
    """Return maps of up to 24 by 24 cells with some obstacles, anywhere, and turned if wanted."""
    height, width = draw(st.integers(1, 24)), draw(st.integers(1, 24))
    lethal = np.zeros((height, width), np.bool_)
    walls = draw(st.lists(st.tuples(st.integers(0, height - 1), st.integers(0, width - 1)), max_size=8))
    for row, column in walls:
        lethal[row, column] = True
    x, y = draw(st.tuples(st.floats(-20, 20), st.floats(-20, 20)))
    theta = draw(st.floats(-math.pi, math.pi)) if turned else 0.0
    return floor_of(lethal, draw(st.sampled_from([0.05, 0.1, 0.25])), Pose2D(x, y, theta))
