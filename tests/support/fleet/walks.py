"""Walks of robots without conflicts, at random."""

from collections.abc import Sequence

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

from ppaas.fleet.roadmap import Roadmap
from tests.reference.fleet.searches import has_ring


@st.composite
def walks(draw: st.DrawFn, roadmap: Roadmap, starts: Sequence[int], steps: int) -> NDArray[np.int32]:
    """Return paths without conflicts from some cells, (n, steps) int32."""
    rows = [tuple(starts)]
    for _ in range(steps - 1):
        ways = [[cell, *(int(near) for near in roadmap.neighbours[cell] if near >= 0)] for cell in rows[-1]]
        after = tuple(draw(st.sampled_from(own)) for own in ways)
        free = len(set(after)) == len(after) and not has_ring(rows[-1], after)
        rows.append(after if free else rows[-1])
    return np.array(rows, np.int32).T.reshape(len(starts), steps)
