"""Matches: parts of the second mapping that were found in the first, each with edges that scans confirm."""

from dataclasses import dataclass

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.mapping.closures.check import ScanCheck
from ppaas.mapping.closures.closing import edges_of
from ppaas.mapping.closures.kernels.points import gather, thin
from ppaas.mapping.closures.submaps import Submap, Submaps
from ppaas.mapping.graph.pose_graph import Edges
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.merging.parameters import MergeParameters
from ppaas.mapping.merging.whole_map import WholeMap
from ppaas.planar_poses import compose, relative

REACH = 20.0
"""Points of a part farther than this from its middle are left out, along each axis [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class PlaceMatch:
    """Part of the second mapping at a place of the first.

    Parameters
    ----------
    source : Submap
        Key frames of the part, as nodes of the joined graph.
    motion : Pose2D
        Frame of the second mapping in the frame of the first, as this match has it.
    score : float
        Score of the search, from 0 to 1.
    edges : Edges
        From key frames of the first mapping to key frames of the second, for each scan that passed the check.
    """

    source: Submap
    motion: Pose2D
    score: float
    edges: Edges


class PartSearch:
    """Search for parts of the second mapping in all of the first.

    Parameters
    ----------
    frames : KeyFrames
        Joined: the first mapping's, then the second's, each at their poses in the frame of their mapping.
    first : int
        Number of key frames of the first mapping.
    parameters : MergeParameters
    """

    def __init__(self, frames: KeyFrames, first: int, parameters: MergeParameters) -> None:
        self._frames, self._parameters, self._target = frames, parameters, Submap(0, first)
        points = gather(frames.points[:first], frames.valid[:first], frames.poses[:first], np.zeros(3))
        self._map = WholeMap(points, frames.poses[:first], parameters)
        self._check = ScanCheck(frames, frames.poses, parameters.closures)

    def parts(self) -> list[Submap]:
        """Return the parts, which overlap each other, in the order of the drive."""
        step, poses = self._parameters.part_step / 2.0, self._frames.poses
        short = Submaps(step)
        for node in range(self._target.end, len(poses)):
            known = node > self._target.end
            short.add(relative(poses[node - 1], poses[node]) if known else np.zeros(3))
        short.finish()
        ends, count = short.finished, max(round(self._parameters.part_travel / step), 1)
        starts = range(0, max(len(ends) - count, 0) + 1, 2)
        first = self._target.end
        return [Submap(first + ends[at].first, first + ends[min(at + count, len(ends)) - 1].end) for at in starts]

    def search(self, part: Submap) -> list[PlaceMatch]:
        """Return the places of the first mapping at which a part fits: two, one or none."""
        chosen = slice(part.first, part.end)
        poses = self._frames.poses[chosen]
        middle = Pose2D(*poses[:, :2].mean(axis=0).tolist())
        points = gather(self._frames.points[chosen], self._frames.valid[chosen], poses, np.array(middle))
        found = []
        for place, score in self._map.places(thin(points, self._parameters.thin, REACH)):
            motion = place @ middle.inverse()
            passed = self._check.run(part, self._target, compose(np.array(motion), poses))
            if len(passed) >= self._parameters.closures.loop_match_minimum_chain_size:
                found.append(PlaceMatch(part, motion, score, edges_of(passed)))
        return found
