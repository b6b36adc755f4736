"""Joint map: one mapping made of several robots' mappings, and remade while they go on mapping."""

from collections.abc import Sequence
from typing import NamedTuple

from ppaas.errors import InvalidInput, MapsNotMerged
from ppaas.mapping.closures.agreement import CLOSING, GRADUATED, add_closure, divide
from ppaas.mapping.closures.closing import ClosureSearch
from ppaas.mapping.closures.closure import Closure, Links
from ppaas.mapping.graph.solver import GraphSolver
from ppaas.mapping.merging.common_laser import are_same
from ppaas.mapping.merging.merge import DEFAULTS, merge
from ppaas.mapping.merging.parameters import MergeParameters
from ppaas.mapping.merging.united import united
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.mapping.serialization.submap_division import divided_submaps


class Joint(NamedTuple):
    """Joint map.

    Parameters
    ----------
    mapping : Mapping
        In the frame of the first mapping; its first key frame has not moved.
    places : int
        Number of places by which two maps were merged; 0 if all mappings had key frames in common.
    """

    mapping: Mapping
    places: int = 0


def join_maps(groups: Sequence[Sequence[Mapping]], parameters: MergeParameters = DEFAULTS) -> Joint:
    """Return one mapping of all.

    Parameters
    ----------
    groups : sequence of sequence of Mapping
        One or two groups. Mappings of a group have key frames in common, as the robots of a joint map. Two groups need
        not; then they are merged by places that both have seen, which pass the gates of a merge.
    parameters : MergeParameters

    Raises
    ------
    MapsNotMerged
        The maps do not overlap enough, or fit in several ways.
    InvalidInput
        The lasers differ, or a mapping has no key frame.
    """
    _check_lasers([mapping for group in groups for mapping in group])
    joint = Joint(_joined(groups[0], parameters))
    for group in groups[1:]:
        joint = _with_group(joint, _joined(group, parameters), parameters)
    return joint


def _check_lasers(mappings: list[Mapping]) -> None:
    if not all(len(mapping.frames) for mapping in mappings):
        raise InvalidInput("a robot without a map cannot share one: drive it, with scans and odometry")
    first = mappings[0].frames.geometry
    for other in (mapping.frames.geometry for mapping in mappings[1:]):
        if not are_same(first, other):
            raise InvalidInput(
                f"the lasers differ ({first.beams} and {other.beams} beams, steps of {first.angle_increment:.5f} and "
                f"{other.angle_increment:.5f} rad): publish the maps and merge them with 'ppaas map merge'"
            )


def _joined(group: Sequence[Mapping], parameters: MergeParameters) -> Mapping:
    """Return one mapping made of a group's mappings."""
    joined = group[0]
    for mapping in group[1:]:
        both = united(joined, mapping)
        if both is None:
            raise MapsNotMerged("the maps have no scan in common any more: one of the robots began another map")
        joined = both.mapping
    return joined if len(group) == 1 else _settled(joined, len(group[0].frames), parameters)


def _with_group(joint: Joint, other: Mapping, parameters: MergeParameters) -> Joint:
    """Return a joint map with another one, by common key frames if there are any."""
    both = united(joint.mapping, other)
    if both is not None:
        return Joint(_settled(both.mapping, len(joint.mapping.frames), parameters))
    merged = merge(joint.mapping, other, parameters)
    return Joint(merged.mapping, merged.matches)


def _settled(mapping: Mapping, since: int, parameters: MergeParameters) -> Mapping:
    """Close the loops of the key frames from an index on, and solve the graph; the mapping is changed."""
    graph = mapping.graph
    divided, _ = divided_submaps(graph, parameters.closures.submap_travel)
    divided.finish()
    submaps = divided.finished
    search, links, far = ClosureSearch(parameters.closures), Links(submaps, graph.edges), False
    waiting: list[Closure] = []
    for of, submap in enumerate(submaps):
        if submap.end > since:
            found = search.search(mapping.frames, graph, submaps, of, links)
            trusted, waiting = divide(graph, found.closures, waiting)
            far |= any(closure.wide for closure in trusted)
            for closure in trusted:
                add_closure(graph, closure)
    mapping.move(GraphSolver().solve(graph, GRADUATED if far else CLOSING).poses)
    return mapping
