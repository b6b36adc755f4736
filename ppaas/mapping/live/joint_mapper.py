"""Joint mapper: a live mapper that goes on with a joint map, of which its own map is a part."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import Conflict, InvalidInput, QuotaExceeded
from ppaas.geometry import Pose2D
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.live.map_canvas import MapCanvas, drawn
from ppaas.mapping.live.refining_mapper import RefiningMapper
from ppaas.mapping.live.refining_work import RefiningWork
from ppaas.mapping.map_drawing import DrawingSettings
from ppaas.mapping.merging.common_laser import are_same
from ppaas.mapping.merging.united import united
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.mapping.serialization.mapping_file import unpack_mapping
from ppaas.planar_poses import compose

# -- adoption of a joint map -------------------------------------------------------------------------------------------


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


# -- the mapper --------------------------------------------------------------------------------------------------------


class Adoption(NamedTuple):
    """What the adoption of a joint map has changed.

    Parameters
    ----------
    motion : Pose2D
        Motion of the robot's pose in the map frame.
    before, after : (k,) int64 array
        Indices of the scans of the robot's key frames, before and now.
    """

    motion: Pose2D
    before: NDArray[np.int64]
    after: NDArray[np.int64]


class JointMapper(RefiningMapper):
    """Live mapper that adopts joint maps.

    `adoption` returns the work that is to be run in any thread, and no other work begins until its result, or None, was
    passed to `adopt`. Key frames made meanwhile are moved along with the last one that the work knew.

    Parameters
    ----------
    *arguments, **options
        Of `LiveMapper`.
    """

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._adopting = False

    def next_work(self) -> Any:
        """Return the work that is due, as `LiveMapper.next_work` does; none during an adoption."""
        return None if self._adopting else super().next_work()

    def next_idle_work(self) -> RefiningWork | None:
        """Return the refinement that is due, as `RefiningMapper.next_idle_work` does; none during an adoption."""
        return None if self._adopting else super().next_idle_work()

    def adoption(self, file: bytes, laser_frame: str, most: int) -> AdoptionWork | None:
        """Return the work of an adoption; None while other work is running. There must be a key frame.

        Parameters
        ----------
        file : bytes
            Joint map.
        laser_frame : str
            Name of the frame of the laser.
        most : int
            Largest number of key frames.
        """
        self._adopting = True
        if self._running is not None:
            return None
        finished, searched = self._submaps.finished, self._searched
        following = finished[-1].end if finished else 0
        first = finished[searched].first if searched < len(finished) else following
        return AdoptionWork(file, self.mapping(laser_frame), first, self._drawing, most)

    def adopt(self, adopted: Adopted | None) -> Adoption | None:
        """Go on with a joint map; return None if there is none, or the robot was carried away meanwhile.

        Raises
        ------
        QuotaExceeded
            There are more key frames than allowed by now; nothing has changed.
        """
        self._adopting = False
        if adopted is None or not self.parts.is_whole:
            return None
        own, pose, odometry = self.key_frames, self.pose, self.odometry
        known = len(adopted.places)
        last = Pose2D(*adopted.mapping.frames.poses[adopted.places[-1]].tolist())
        motion = last @ Pose2D(*own.poses[known - 1].tolist()).inverse()
        drawn, solves = len(adopted.mapping.frames), self.solves
        frames, places = _with_later_frames(adopted, own, motion)
        _append_later_edges(adopted.mapping.graph, self.graph, places, frames, adopted.edges)
        placing, before = self._tracker.is_placing, own.scans.copy()
        self._tracker.resume(frames, motion @ pose, odometry)
        if placing:
            self._tracker.place(motion @ pose @ frames.geometry.mount.inverse())
        self._take_over(adopted.mapping)
        self._searched = sum(submap.end <= adopted.searched for submap in self._submaps.finished)
        self.solves = solves
        self._canvas = adopted.canvas or MapCanvas(self._drawing)
        self._drawn = drawn if adopted.canvas is not None else 0
        return Adoption(motion, before, frames.scans[places])


def _with_later_frames(adopted: Adopted, own: KeyFrames, motion: Pose2D) -> tuple[KeyFrames, NDArray[np.int64]]:
    """Return the key frames of a joint map with those that came meanwhile, and the place (k,) of each own one."""
    frames, known = adopted.mapping.frames, len(adopted.places)
    places = np.concatenate((adopted.places, len(frames) + np.arange(len(own) - known)))
    frames.extend(
        compose(np.array(motion), own.poses[known:]), own.information[known:],
        own.scans[known:] - own.scans[known - 1] + frames.scans[-1],
        own.scan_points(slice(known, None)),
    )  # fmt: skip
    return frames, places


def _append_later_edges(
    graph: PoseGraph, own: PoseGraph, places: NDArray[np.int64], frames: KeyFrames, known: int
) -> None:
    """Append the nodes and edges that came meanwhile to the graph of a joint map."""
    for pose in frames.poses[graph.node_count :]:
        graph.add_node(pose)
    for first, second, measurement, information, kind in zip(*own.edges.since(known), strict=True):
        graph.add_edge(int(places[first]), int(places[second]), measurement, information, EdgeKind(kind))
