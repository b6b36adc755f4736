"""Joint mapper: a live mapper that goes on with a joint map, of which its own map is a part."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.live.adoption import Adopted, AdoptionWork
from ppaas.mapping.live.map_canvas import MapCanvas
from ppaas.mapping.live.refining_mapper import RefiningMapper
from ppaas.mapping.live.refining_work import RefiningWork
from ppaas.planar_poses import compose


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
