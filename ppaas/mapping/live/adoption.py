"""Adoption: a robot that maps goes on with a joint map, of which its own map is a part."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import Conflict, InvalidInput, QuotaExceeded
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.live.map_canvas import MapCanvas, drawn
from ppaas.mapping.map_drawing import DrawingSettings
from ppaas.mapping.merging.common_laser import are_same
from ppaas.mapping.merging.united import united
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.mapping.serialization.mapping_file import unpack_mapping


@dataclass(frozen=True, slots=True)
class Adopted:
    """Joint map in the order in which its robot goes on: the chain of its own key frames is last.

    Parameters
    ----------
    mapping : Mapping
        All key frames of the joint map, and those that only this robot has.
    places : (k,) int64 array
        Index of each key frame of the robot's own map in it.
    edges : int
        Number of edges of the robot's own map.
    searched : int
        Index of the first key frame whose submap was not searched for closures.
    canvas : MapCanvas or None
        Map of these key frames; None if it would be too large.
    """

    mapping: Mapping
    places: NDArray[np.int64]
    edges: int
    searched: int
    canvas: MapCanvas | None


@dataclass(frozen=True, slots=True)
class AdoptionWork:
    """Work, for any thread, that makes a joint map the one of a robot. It changes nothing that is given.

    Parameters
    ----------
    file : bytes
        Joint map; see `ppaas.mapping.serialization.mapping_file`.
    own : Mapping
        Snapshot of the robot's own map.
    searched : int
        Index of its first key frame whose submap was not searched for closures.
    drawing : DrawingSettings
    most : int
        Largest number of key frames.
    """

    file: bytes
    own: Mapping
    searched: int
    drawing: DrawingSettings
    most: int

    def __call__(self, _cancelled: Callable[[], bool]) -> Adopted:
        """Return the joint map with all that the robot has mapped.

        Raises
        ------
        InvalidGraph
            The file is not a joint map.
        InvalidInput
            It is of another laser.
        Conflict
            It has no key frame of the robot's map.
        QuotaExceeded
            There would be more key frames than allowed.
        """
        joint = unpack_mapping(self.file)
        if not are_same(joint.frames.geometry, self.own.frames.geometry):
            raise InvalidInput("the joint map is of another laser, with other beams: publish the maps and merge them")
        both = united(joint, self.own)
        if both is None:
            raise Conflict("the joint map has no scan of this robot's map, which was cleared or replaced meanwhile")
        count = both.mapping.graph.node_count
        if count > self.most:
            raise QuotaExceeded(
                f"the joint map has {count} key frames, and at most {self.most} are allowed: raise max_key_frames"
            )
        chains = odometry_chains(both.mapping.graph)
        is_own = chains == chains[both.places[-1]]
        is_own[0] = False  # the first key frame fixes the frame
        order = np.lexsort((np.arange(count), chains, is_own))
        moved = np.empty(count, np.int64)
        moved[order] = np.arange(count)
        places, begin = moved[both.places], count - int(is_own.sum())
        searched = int(places[self.searched]) if self.searched < len(places) else count
        mapping = _ordered(both.mapping, order, moved, self.own)
        return Adopted(
            mapping, places, self.own.graph.edge_count, max(searched, begin), drawn(mapping.frames, self.drawing)
        )


def odometry_chains(graph: PoseGraph) -> NDArray[np.int64]:
    """Return for each node (n,) the first node of its chain: nodes that follow each other by odometry.

    Of several nodes that follow the same one, as after a robot was placed, the others begin separate chains.
    """
    edges = graph.edges
    chains, taken = np.arange(graph.node_count), np.zeros(graph.node_count, np.bool_)
    steps = np.flatnonzero((edges.kinds == EdgeKind.ODOMETRY) & (edges.first < edges.second))
    for step in steps[np.argsort(edges.second[steps], kind="stable")].tolist():
        before, node = int(edges.first[step]), int(edges.second[step])
        if not taken[before] and chains[node] == node:
            chains[node], taken[before] = chains[before], True
    return chains


def _ordered(mapping: Mapping, order: NDArray[np.int64], moved: NDArray[np.int64], own: Mapping) -> Mapping:
    """Return a mapping with its key frames in another order, of the laser of the robot."""
    of, edges = mapping.frames, mapping.graph.edges
    frames = KeyFrames(own.frames.geometry)
    scans = of.scan_points(order)
    frames.extend(of.poses[order], of.information[order], of.scans, scans)
    graph = PoseGraph.of(of.poses[order], edges._replace(first=moved[edges.first], second=moved[edges.second]))
    return Mapping(frames, graph, own.laser_frame)
