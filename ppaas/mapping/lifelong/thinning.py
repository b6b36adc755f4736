"""Thinning: outdated beams and redundant key frames leave a mapping."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import QuotaExceeded
from ppaas.mapping.closures.closure import Closure
from ppaas.mapping.closures.submaps import Submap
from ppaas.mapping.graph.pose_graph import PoseGraph, join_edges
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.lifelong.marginalisation import without_nodes
from ppaas.mapping.lifelong.neighbourhood import NEAR, Neighbourhoods
from ppaas.mapping.lifelong.parameters import LifelongParameters
from ppaas.mapping.lifelong.redundancy import Redundancy, outdated_beams, without_beams
from ppaas.mapping.near_poses import nearest_poses
from ppaas.mapping.scan_points import ScanPoints
from ppaas.mapping.serialization.mapping_log import Rewritten
from ppaas.mapping.serialization.rows import divided_edges, packed_rows

MOST_BYTES = 12 << 20
"""Largest map that is thinned [bytes]: it is one entry of a log, and Cassandra takes at most 16 MiB at once."""

GROWTH = 0.125
"""Part of the key frames that are new when the pose graph is thinned again."""


class Chosen(NamedTuple):
    """Key frames that are judged.

    Parameters
    ----------
    since : int
        Number of key frames that were there at the last thinning: only those near later ones are judged again.
    protected : (k,) bool array
        Key frames that are not removed.
    """

    since: int
    protected: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Thinned:
    """Result of thinning.

    Parameters
    ----------
    kept : (k,) bool array
        Key frames of the snapshot that are left.
    frames : KeyFrames
        These, without outdated beams.
    graph : PoseGraph
        One node for each.
    edge_count : int
        Number of edges that the graph had before.
    outdated : int
        Number of beams that left.
    rows : bytes
        Records of these key frames and the edges, see `packed_rows`; empty if nothing has changed.
    """

    kept: NDArray[np.bool_]
    frames: KeyFrames
    graph: PoseGraph
    edge_count: int
    outdated: int
    rows: bytes = b""

    @property
    def changes(self) -> bool:
        """Whether the mapping has changed."""
        return bool(self.outdated) or not self.kept.all()

    def rewritten(self, solves: int) -> Rewritten:
        """Return the beginning of another log, after a number of solves."""
        graph = self.graph
        others = len(divided_edges(graph)[1].first)
        return Rewritten(self.rows, graph.node_count, graph.edge_count, others, solves)

    def with_later_nodes(self, graph: PoseGraph) -> PoseGraph | None:
        """Return the graph with the nodes and edges that the original got meanwhile.

        Parameters
        ----------
        graph : PoseGraph
            The original, of which no earlier node has moved.

        Returns
        -------
        PoseGraph or None
            None if one of these edges begins at a node that was removed.
        """
        count, edges = len(self.kept), graph.edges.since(self.edge_count)
        kept = np.concatenate((self.kept, np.ones(graph.node_count - count, np.bool_)))
        if not (kept[edges.first].all() and kept[edges.second].all()):
            # A closure found meanwhile needs a node that is gone: the caller thins again later.
            return None
        number = np.cumsum(kept) - 1
        later = edges._replace(first=number[edges.first], second=number[edges.second])
        joined = join_edges(self.graph.edges, later)
        return PoseGraph.of(np.concatenate((self.graph.poses, graph.poses[count:])), joined)

    def with_later_frames(self, frames: KeyFrames) -> KeyFrames:
        """Return the key frames with those that the original got meanwhile."""
        later = slice(len(self.kept), len(frames))
        scans = frames.scan_points(later)
        self.frames.extend(frames.poses[later], frames.information[later], frames.scans[later], scans)
        return self.frames


def thin(
    frames: KeyFrames,
    graph: PoseGraph,
    chosen: Chosen,
    parameters: LifelongParameters,
    cancelled: Callable[[], bool] = lambda: False,
) -> Thinned | None:
    """Return what is left of a mapping without outdated beams and redundant key frames; nothing given is changed.

    Parameters
    ----------
    frames : KeyFrames
        At their poses.
    graph : PoseGraph
        One node per key frame.
    chosen : Chosen
        Key frames that are judged.
    parameters : LifelongParameters
    cancelled : callable
        Returns whether the result is no longer needed.

    Returns
    -------
    Thinned or None
        None if it was cancelled.

    Raises
    ------
    QuotaExceeded
        What is left is too large for an entry of a log.
    """
    found = _judged(frames, chosen, parameters, cancelled)
    if found is None:
        return None
    outdated, removed = found
    left = kept_frames(frames, without_beams(frames, outdated), ~removed)
    thinned = Thinned(~removed, left, without_nodes(graph, removed), graph.edge_count, int(outdated.sum()))
    return replace(thinned, rows=_packed(left, thinned.graph)) if thinned.changes else thinned


def _packed(frames: KeyFrames, graph: PoseGraph) -> bytes:
    rows = b"".join(packed_rows(frames, graph))
    if len(rows) > MOST_BYTES:
        raise QuotaExceeded(
            f"a map of {len(rows) >> 20} MiB is not thinned, at most {MOST_BYTES >> 20} MiB are: map with fewer beams, "
            "or a larger minimum_travel_distance"
        )
    return rows


def _judged(
    frames: KeyFrames, chosen: Chosen, parameters: LifelongParameters, cancelled: Callable[[], bool]
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]] | None:
    """Return the outdated beams (k, b) and the redundant key frames (k,)."""
    poses, outdated, valid = frames.poses, np.zeros(frames.valid.shape, np.bool_), frames.valid.copy()
    redundancy = Redundancy(poses, parameters.lifelong_iou_match)
    judged = np.flatnonzero(nearest_poses(poses, poses[chosen.since :], 1, NEAR)[:, 0] >= 0)
    # The first key frame is what the frame of the map is known by.
    for near in Neighbourhoods(frames, poses, parameters.pass_distance).around(judged[judged > 0]):
        if cancelled():
            return None
        outdated[near.frame] = outdated_beams(near) & frames.valid[near.frame]
        valid[near.frame] &= ~outdated[near.frame]
        if not chosen.protected[near.frame]:
            redundancy.judge(near, valid)
    return outdated, redundancy.removed


def is_due(count: int, thinned: int, parameters: LifelongParameters) -> bool:
    """Return whether enough key frames are new: of ``count``, ``thinned`` were there at the last thinning."""
    return count - thinned >= max(parameters.least_new_frames, int(GROWTH * thinned))


def kept_frames(frames: KeyFrames, scans: ScanPoints, kept: NDArray[np.bool_]) -> KeyFrames:
    """Return some key frames, in separate arrays.

    Parameters
    ----------
    frames : KeyFrames
    scans : ScanPoints
        Their points, stacked, in place of the scans of ``frames``.
    kept : (k,) bool array
        The key frames that are returned.
    """
    # New arrays: the mapper goes on with the old ones while this runs in another thread.
    left = KeyFrames(frames.geometry)
    chosen = ScanPoints(scans.points[kept], scans.normals[kept], scans.valid[kept])
    left.extend(frames.poses[kept], frames.information[kept], frames.scans[kept], chosen)
    return left


def renumbered_closures(closures: list[Closure], kept: NDArray[np.bool_]) -> list[Closure]:
    """Return closures between the key frames that are left; closures with a missing key frame are left out.

    Parameters
    ----------
    closures : list of Closure
    kept : (k,) bool array
        Key frames that are left.
    """
    before = np.concatenate(([0], np.cumsum(kept)))
    moved = []
    for closure in closures:
        edges = closure.edges
        source, target = (
            Submap(int(before[part.first]), int(before[part.end])) for part in (closure.source, closure.target)
        )
        if kept[edges.first].all() and kept[edges.second].all() and source.first < source.end:
            renumbered = edges._replace(first=before[edges.first], second=before[edges.second])
            moved.append(replace(closure, source=source, target=target, edges=renumbered))
    return moved
