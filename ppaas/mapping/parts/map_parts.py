"""Parts of a map: key frames that no edge connects, since the robot was carried away between them."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import Unavailable
from ppaas.mapping.closures.submaps import Submap
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph, components
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.planar_poses import relative

LOOSE = np.diag((1e-2, 1e-2, 1e-2))
"""Information of the edges that hold parts where they are while a graph is solved [1/m², 1/rad²]."""


class MapParts(NamedTuple):
    """Parts of the key frames of a map, as runs of successive key frames. The current part has the last key frame.

    Parameters
    ----------
    starts : tuple of int
        Index of the first key frame of each run; the first one is 0.
    numbers : tuple of int
        Part of each run.
    """

    starts: tuple[int, ...] = (0,)
    numbers: tuple[int, ...] = (0,)

    @classmethod
    def of(cls, graph: PoseGraph) -> "MapParts":
        """Return the components of a graph that has a node for each key frame."""
        labels = components(graph)
        if not len(labels):
            return cls()
        starts = [0, *(np.flatnonzero(np.diff(labels)) + 1).tolist()]
        return cls(tuple(starts), tuple(labels[starts].tolist()))

    @property
    def is_whole(self) -> bool:
        """Whether there is one part only."""
        return len(set(self.numbers)) == 1

    @property
    def current(self) -> int:
        """Number of the current part."""
        return self.numbers[-1]

    @property
    def others(self) -> list[int]:
        """Numbers of the other parts."""
        return sorted(set(self.numbers) - {self.current})

    @property
    def last_start(self) -> int:
        """Index of the first key frame of the last run of successive ones that are in the current part."""
        return self.starts[-1]

    def begin(self, first: int) -> "MapParts":
        """Return the parts when another one begins with a key frame, the last one."""
        return MapParts((*self.starts, first), (*self.numbers, max(self.numbers) + 1))

    def join(self, one: int, other: int) -> "MapParts":
        """Return the parts when two of them have become one, which has the smaller number."""
        numbers = [min(one, other) if number in (one, other) else number for number in self.numbers]
        kept = [at for at, number in enumerate(numbers) if not at or number != numbers[at - 1]]
        return MapParts(tuple(self.starts[at] for at in kept), tuple(numbers[at] for at in kept))

    def runs(self, number: int, count: int) -> list[slice]:
        """Return the successive key frames of a part; ``count`` is the number of all key frames."""
        ends = [*self.starts[1:], count]
        of = zip(self.starts, ends, self.numbers, strict=True)
        return [slice(start, min(end, count)) for start, end, part in of if part == number and start < count]

    def indices(self, number: int, count: int) -> NDArray[np.int64]:
        """Return the indices of the key frames of a part; ``count`` is the number of all key frames."""
        runs = [np.arange(run.start, run.stop) for run in self.runs(number, count)]
        return np.concatenate(runs) if runs else np.zeros(0, np.int64)

    def beside(self, submaps: Sequence[Submap]) -> list[Submap]:
        """Return the submaps that are in the run of the last one; all if there is one part only."""
        run = self._run(submaps[-1].first)
        return [submap for submap in submaps if self._run(submap.first) == run]

    def by_run(self, submaps: Sequence[Submap]) -> list[list[Submap]]:
        """Return the submaps of each run; all in one list if there is one part only."""
        runs = [self._run(submap.first) for submap in submaps]
        return [[submap for submap, at in zip(submaps, runs, strict=True) if at == run] for run in sorted(set(runs))]

    def held(self, graph: PoseGraph) -> PoseGraph:
        """Return a copy of a graph of all key frames with edges that hold each part where it is, beside the first."""
        held, seen = graph.copy(), {self.numbers[0]}
        for start, number in zip(self.starts, self.numbers, strict=True):
            if number not in seen and start < graph.node_count:
                seen.add(number)
                step = relative(graph.poses[start - 1], graph.poses[start])
                held.add_edge(start - 1, start, step, LOOSE, EdgeKind.ODOMETRY)
        return held

    def _run(self, frame: int) -> int:
        return int(np.searchsorted(self.starts, frame, side="right")) - 1


WHOLE = MapParts()
"""Parts of a map that is whole."""


def extract(mapping: Mapping, chosen: NDArray[np.int64]) -> Mapping:
    """Return the mapping of some key frames.

    Parameters
    ----------
    mapping : Mapping
        Left unchanged.
    chosen : (m,) int64 array
        Indices of its key frames, ascending.
    """
    of, edges = mapping.frames, mapping.graph.edges
    frames = KeyFrames(of.geometry, max(len(chosen), 1))
    scans = of.scan_points(chosen)
    frames.extend(mapping.graph.poses[chosen], of.information[chosen], of.scans[chosen], scans)
    places = np.full(len(of), -1, np.int64)
    places[chosen] = np.arange(len(chosen))
    first, second = places[edges.first], places[edges.second]
    inner = edges._replace(first=first, second=second).take((first >= 0) & (second >= 0))
    return Mapping(frames, PoseGraph.of(frames.poses, inner), mapping.laser_frame)


def current_part(mapping: Mapping, parts: MapParts) -> Mapping:
    """Return the mapping of the current part."""
    return mapping if parts.is_whole else extract(mapping, parts.indices(parts.current, len(mapping.frames)))


def check_is_main(parts: MapParts, count: int) -> None:
    """Raise ``Unavailable`` if the current part is not the largest: a map of it lacks most of what the robot has seen.

    Parameters
    ----------
    parts : MapParts
    count : int
        Number of all key frames.
    """
    most = max((len(parts.indices(number, count)) for number in parts.others), default=0)
    if most > len(parts.indices(parts.current, count)):
        raise Unavailable(
            f"the robot was carried away, and has not found the {most} key frames of its map again: drive it where it "
            "was before, or call 'clear' to begin another map"
        )
