"""Limits of the lanes of a map: what of a large graph is taken."""

from collections.abc import Sequence

import numpy as np

from ppaas.imports.graphs.chains import LaneChain, Link
from ppaas.imports.graphs.model.gathered import GatheredNotes


def within_limits(chains: list[LaneChain], most: int, straight: float, notes: GatheredNotes) -> list[LaneChain]:
    """Return chains with few enough positions.

    If there are too many, places on straight parts are left out first, and then the chains that are farthest from the
    middle of the largest part that is connected.

    Parameters
    ----------
    chains : list of LaneChain
    most : int
        Largest number of positions.
    straight : float
        Distance from a straight part within which positions are left out [m].
    notes : GatheredNotes
        Takes what was left out.
    """
    if sum(chain.size for chain in chains) <= most:
        return chains
    simple = [_simplified(chain, straight) for chain in chains]
    before, after = (sum(chain.size for chain in some) for some in (chains, simple))
    notes.translated("positions", f"{before - after} on straight parts were left out: a map may have {most} on lanes")
    kept, size = [], 0
    for number in _from_the_middle(simple):
        chain = simple[number]
        if size + chain.size > most:
            notes.refused(
                f"lane at {_place(chain)}",
                f"a map may have {most} positions on lanes, and the graph has {after}; import a part of it, by a "
                "level, a layer or a vehicle type, or divide the map",
            )
            continue
        size += chain.size
        kept.append(number)
    return [simple[number] for number in sorted(kept)]


def _simplified(chain: LaneChain, straight: float) -> LaneChain:
    """Return a chain of one link whose corners are farther from its straight parts; its limits are kept by others."""
    import shapely  # noqa: PLC0415 - only imports of graphs need it

    if chain.size == 2:
        return chain
    links: list[Link] = []
    for link in chain.links:
        if links and _limits(links[-1]) == _limits(link):
            links[-1].points.extend(link.points[1:])
            links[-1].end = link.end
        else:
            links.append(
                Link(link.start, link.end, [*link.points], link.one_way, link.name, link.max_speed, link.percent,
                     link.groups)
            )  # fmt: skip
    for link in (link for link in links if len(link.points) > 2):
        simple = shapely.simplify(shapely.LineString(link.points), straight)
        link.points = [(float(x), float(y)) for x, y in simple.coords]
    return LaneChain([links[0].start, *(link.end for link in links)], links, chain.one_way)


def _limits(link: Link) -> tuple[float | None, float | None, tuple[str, ...]]:
    return link.max_speed, link.percent, link.groups


def _from_the_middle(chains: Sequence[LaneChain]) -> list[int]:
    """Return the numbers of chains: those of the largest connected part first, outwards from its first place."""
    from scipy.sparse import coo_array  # noqa: PLC0415 - only imports of large graphs need it
    from scipy.sparse.csgraph import breadth_first_order, connected_components  # noqa: PLC0415

    ends = np.array([(chain.places[0], chain.places[-1]) for chain in chains])
    count = int(ends.max()) + 1
    matrix = coo_array((np.ones(len(ends), np.int8), (ends[:, 0], ends[:, 1])), (count, count)).tocsr()
    _, part = connected_components(matrix, directed=False)
    sizes = np.bincount(part[ends[:, 0]], minlength=int(part.max()) + 1)
    first = int(ends[part[ends[:, 0]] == sizes.argmax(), 0][0])
    reached = breadth_first_order(matrix, first, directed=False, return_predecessors=False)
    rank = np.full(count, count)
    rank[reached] = np.arange(len(reached))
    order: list[int] = np.lexsort((np.arange(len(ends)), rank[ends].min(axis=1), -sizes[part[ends[:, 0]]])).tolist()
    return order


def _place(chain: LaneChain) -> str:
    x, y = chain.links[0].points[0]
    return f"({x:.2f}, {y:.2f})"
