"""How large an index may be, and what has room in it."""

import numpy as np

from ppaas.errors import InvalidPlanner
from ppaas.planners.hub_labels.building.graph import ContractedGraph, CornerGraph, CornerMap
from ppaas.planners.hub_labels.building.kernels.contraction import RUNS
from ppaas.planners.hub_labels.kernels.terrain import COLUMNS, ROWS

MOST_BYTES, CELLS_OF_MOST_BYTES = 39.5e6, 1 << 20
"""How large an index may be, and up to how many cells that holds; that of a larger map may be larger in proportion."""

BYTES_AN_ENTRY, BYTES_A_RUN, BYTES_A_CORNER = 14, 2, 40
"""What is taken by an entry of a label, a run of a way, and a corner of the fringe without its edges and gates."""

BYTES_AN_EDGE = 29
"""What is taken by an edge of the fringe and the gates that come with it: a corner has up to 2.1 gates an edge."""

SAFETY_FACTOR = 0.94
"""What of the room for labels is given out: they, and gates, may take more than is foretold, and to label anew takes
seconds."""

BYTES_A_WAY = 6
"""What a way takes in the mean: three runs, or more."""

GROWTH = 1.25
"""How many times as many edges as before a crowded map has at least when it is contracted."""

MOST_SCANS = 4e9
"""Looks at edges that the contraction of a map of up to `CELLS_OF_MOST_BYTES` may take: up to a minute of one core."""

USUAL_ENTRIES_A_CORNER = 200
"""Entries a corner that labels may have, below which a map is crowded: a core that is large takes too many."""

LEAST_ENTRIES = 0.5
"""Entries a corner that labels must have room for. With fewer there are so few gates to stop at that much of the fringe
is searched from each corner, which takes up to minutes, and by each query, which takes milliseconds then."""


def most_bytes(ground: CornerMap) -> float:
    """Return how large an index may be."""
    return MOST_BYTES * max(1.0, int(ground.terrain[ROWS]) * int(ground.terrain[COLUMNS]) / CELLS_OF_MOST_BYTES)


def most_scans(ground: CornerMap) -> int:
    """Return at how many edges the contraction of a map may look: it is refused rather than that it takes minutes."""
    return int(MOST_SCANS * most_bytes(ground) / MOST_BYTES)


def is_crowded(ground: CornerMap, graph: CornerGraph) -> bool:
    """Tell whether corners see few others, or are too many to have long labels."""
    entries = (most_bytes(ground) - ground.terrain.nbytes) / BYTES_AN_ENTRY
    return graph.is_cluttered or entries < USUAL_ENTRIES_A_CORNER * len(ground.places)


def most_edges(ground: CornerMap, graph: CornerGraph) -> int:
    """Return how many edges a contracted graph may have.

    Raises
    ------
    InvalidPlanner
        It will have more.
    """
    room = most_bytes(ground) - ground.terrain.nbytes - BYTES_A_CORNER * len(ground.places)
    most = int(max(0.0, room)) // (BYTES_AN_EDGE + BYTES_A_WAY)
    if is_crowded(ground, graph) and GROWTH * len(graph.to) / 2 > most:
        raise too_crowded(ground)
    return most


def most_label_entries(ground: CornerMap, contracted: ContractedGraph) -> int:
    """Return how many entries labels may have, for an index that is not too large."""
    listed, upwards = contracted.listed()
    runs = int(contracted.edges[listed, RUNS].sum(dtype=np.int64))
    fringe = BYTES_A_CORNER * len(ground.places) + BYTES_AN_EDGE * int(np.count_nonzero(upwards))
    others = ground.terrain.nbytes + fringe + BYTES_A_RUN * runs
    return int(SAFETY_FACTOR * max(0.0, most_bytes(ground) - others)) // BYTES_AN_ENTRY


def too_crowded(ground: CornerMap) -> InvalidPlanner:
    """Return the error for a map whose index would be too large."""
    return InvalidPlanner(
        f"the map has {len(ground.places)} corners of obstacles, too many for an index of hub labels of "
        f"{most_bytes(ground) / 1e6:.0f} MB; choose another planner, such as jps or dijkstra"
    )
