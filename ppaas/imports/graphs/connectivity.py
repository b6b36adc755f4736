"""Connectivity of a graph: islands, and nodes that one-way edges lead into, but not out of."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.imports.graphs.model.route_graph import RouteGraph, points_of
from ppaas.imports.report import ImportReport

MOST_CROSSING = 20_000
"""Largest number of edges of which crossings are looked for."""

NAMED = 5
"""Number of nodes that a sentence names; the others are counted."""


class Connections(NamedTuple):
    """Nodes of a graph by how they are connected, each as a list of keys in the order of the graph.

    Parameters
    ----------
    lonely : list of str
        Nodes without an edge.
    islands : list of list of str
        Parts that no edge connects with the largest part, the larger first.
    no_way_out, no_way_in : list of str
        Nodes of the largest part from which no way leads to its core, and to which no way leads from there. The core
        is the largest set of nodes each of which is reached from each other.
    """

    lonely: list[str]
    islands: list[list[str]]
    no_way_out: list[str]
    no_way_in: list[str]


def connections_of(graph: RouteGraph) -> Connections:
    """Return how the nodes of a graph are connected."""
    from scipy.sparse import coo_array  # noqa: PLC0415 - only imports of graphs need it
    from scipy.sparse.csgraph import breadth_first_order, connected_components  # noqa: PLC0415

    keys = list(graph.nodes)
    if not graph.edges:
        return Connections(keys, [], [], [])
    number = {key: at for at, key in enumerate(keys)}
    starts = np.array([number[edge.start] for edge in graph.edges])
    ends = np.array([number[edge.end] for edge in graph.edges])
    matrix = coo_array((np.ones(len(starts), np.int8), (starts, ends)), (len(keys), len(keys))).tocsr()
    _, weak = connected_components(matrix, connection="weak")
    _, strong = connected_components(matrix, connection="strong")
    used = np.zeros(len(keys), np.bool_)
    used[starts] = used[ends] = True
    largest = np.bincount(weak[used]).argmax()
    core = np.bincount(strong[weak == largest]).argmax()
    root = int(np.nonzero(strong == core)[0][0])
    inside = weak == largest
    to_core = np.zeros(len(keys), np.bool_)
    to_core[breadth_first_order(matrix.T.tocsr(), root, return_predecessors=False)] = True
    from_core = np.zeros(len(keys), np.bool_)
    from_core[breadth_first_order(matrix, root, return_predecessors=False)] = True
    others = [weak == part for part in np.unique(weak[used]) if part != largest]
    return Connections(
        _keys(keys, ~used),
        sorted((_keys(keys, mask) for mask in others), key=len, reverse=True),
        _keys(keys, inside & ~to_core),
        _keys(keys, inside & ~from_core & to_core),
    )


def _keys(keys: Sequence[str], mask: NDArray[np.bool_]) -> list[str]:
    return [keys[at] for at in np.nonzero(mask)[0].tolist()]


def report_connections(graph: RouteGraph, report: ImportReport) -> None:
    """Add to a report which nodes robots cannot leave or reach; none of them is left out of the graph."""
    found = connections_of(graph)
    if found.lonely:
        report.without_effect(_nodes(graph, found.lonely), "no edge leads here; only lanes are driven along")
    for island in found.islands[:NAMED]:
        report.taken(
            _nodes(graph, island),
            f"island: no edge connects {_these(len(island))} with the largest part; robots do not get from one to the "
            "other",
        )
    if len(found.islands) > NAMED:
        report.taken(f"{len(found.islands) - NAMED} more islands", "as the islands above")
    if found.no_way_out:
        report.taken(
            _nodes(graph, found.no_way_out), "one-way trap: robots get here and not back; add an edge that leads back"
        )
    if found.no_way_in:
        report.taken(
            _nodes(graph, found.no_way_in), "robots leave here and do not get back; add an edge that leads here"
        )


def _these(count: int) -> str:
    return "this node" if count == 1 else f"these {count} nodes"


def _nodes(graph: RouteGraph, keys: Sequence[str]) -> str:
    names = ", ".join(graph.nodes[key].name for key in keys[:NAMED])
    more = f" and {len(keys) - NAMED} more" if len(keys) > NAMED else ""
    return f"{'node' if len(keys) == 1 else 'nodes'} {names}{more}"


def report_crossings(graph: RouteGraph, report: ImportReport) -> None:
    """Add to a report which edges cross where the graph has no node: lanes are connected there."""
    import shapely  # noqa: PLC0415 - only imports of graphs need it

    pairs = {(min(edge.start, edge.end), max(edge.start, edge.end)): edge for edge in graph.edges if not edge.between}
    edges = list(pairs.values())
    if not 1 < len(edges) <= MOST_CROSSING:
        return
    lines = shapely.linestrings(np.array([points_of(graph, edge) for edge in edges]))
    one, other = shapely.STRtree(lines).query(lines, predicate="crosses")
    crossing = [(edges[a], edges[b]) for a, b in zip(one.tolist(), other.tolist(), strict=True) if a < b]
    if crossing:
        names = ", ".join(f"{a.part or a.name} and {b.part or b.name}" for a, b in crossing[:NAMED])
        more = f" and {len(crossing) - NAMED} more" if len(crossing) > NAMED else ""
        report.taken(f"{names}{more}", "they cross without a node: robots may turn from one into the other there")
