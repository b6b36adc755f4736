"""Limits on the size of an index, and estimates of its parts."""

import numpy as np

from ppaas.errors import InvalidPlanner
from ppaas.planners.hub_labels.building.graph import ContractedGraph, CornerGraph, CornerMap
from ppaas.planners.hub_labels.building.kernels.contraction import RUNS
from ppaas.planners.hub_labels.kernels.terrain import COLUMNS, ROWS

MOST_BYTES, CELLS_OF_MOST_BYTES = 39.5e6, 1 << 20
"""Largest index [bytes], and the map size up to which that holds [cells]. For larger maps the limit grows in
proportion."""

BYTES_AN_ENTRY, BYTES_A_RUN, BYTES_A_CORNER = 14, 2, 40
"""Size of a label entry, a run of a path, and a fringe corner without its edges and gates [bytes]."""

BYTES_AN_EDGE = 29
"""Size of a fringe edge with its gates [bytes]. A corner has up to 2.1 gates per edge."""

SAFETY_FACTOR = 0.94
"""Fraction of the label memory that is used. Labels and gates may exceed the estimate, and labelling again takes
seconds."""

BYTES_A_PATH = 6
"""Mean size of the path of an edge [bytes]: three runs or more."""

GROWTH = 1.25
"""Least factor by which contraction multiplies the edges of a dense map."""

MOST_EDGE_VISITS = 4e9
"""Limit on edge visits of the contraction, for maps of up to `CELLS_OF_MOST_BYTES`: up to a minute on one core."""

USUAL_ENTRIES_A_CORNER = 200
"""Entries per corner that labels may have, below which a map is dense: a large core would need too many."""

LEAST_ENTRIES = 0.5
"""Least number of label entries per corner. With fewer, there are so few gates that much of the fringe is searched from
each corner, which takes minutes, and in each query, which then takes milliseconds."""


def most_bytes(corner_map: CornerMap) -> float:
    """Return the largest size of the index of a map [bytes]."""
    return MOST_BYTES * max(1.0, int(corner_map.terrain[ROWS]) * int(corner_map.terrain[COLUMNS]) / CELLS_OF_MOST_BYTES)


def most_edge_visits(corner_map: CornerMap) -> int:
    """Return the limit on edge visits of the contraction; a map that exceeds it is refused."""
    return int(MOST_EDGE_VISITS * most_bytes(corner_map) / MOST_BYTES)


def is_dense(corner_map: CornerMap, graph: CornerGraph) -> bool:
    """Return whether corners see few others, or are too many to have long labels."""
    entries = (most_bytes(corner_map) - corner_map.terrain.nbytes) / BYTES_AN_ENTRY
    return graph.is_cluttered or entries < USUAL_ENTRIES_A_CORNER * len(corner_map.positions)


def most_edges(corner_map: CornerMap, graph: CornerGraph) -> int:
    """Return the largest number of edges of the contracted graph.

    Raises
    ------
    InvalidPlanner
        The graph will have more.
    """
    bytes_left = most_bytes(corner_map) - corner_map.terrain.nbytes - BYTES_A_CORNER * len(corner_map.positions)
    most = int(max(0.0, bytes_left)) // (BYTES_AN_EDGE + BYTES_A_PATH)
    if is_dense(corner_map, graph) and GROWTH * len(graph.to) / 2 > most:
        raise too_dense(corner_map)
    return most


def most_label_entries(corner_map: CornerMap, contracted: ContractedGraph) -> int:
    """Return the number of label entries that keep the index within its size limit."""
    listed, upwards = contracted.listed()
    runs = int(contracted.edges[listed, RUNS].sum(dtype=np.int64))
    fringe = BYTES_A_CORNER * len(corner_map.positions) + BYTES_AN_EDGE * int(np.count_nonzero(upwards))
    others = corner_map.terrain.nbytes + fringe + BYTES_A_RUN * runs
    return int(SAFETY_FACTOR * max(0.0, most_bytes(corner_map) - others)) // BYTES_AN_ENTRY


def too_dense(corner_map: CornerMap) -> InvalidPlanner:
    """Return the error for a map whose index would be too large."""
    return InvalidPlanner(
        f"the map has {len(corner_map.positions)} corners of obstacles, too many for an index of hub labels of "
        f"{most_bytes(corner_map) / 1e6:.0f} MB; choose another planner, such as jps or dijkstra"
    )
