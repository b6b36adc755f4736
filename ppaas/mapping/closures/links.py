"""Links: the submaps that closures join, and the passes of a place that are not joined yet."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.closures.candidates import Candidate
from ppaas.mapping.closures.submaps import Submap
from ppaas.mapping.graph.pose_graph import EdgeKind, Edges

BESIDE_SOURCE, BESIDE_TARGET = 1, 2
"""Distances up to which a link counts for the neighbours of the later and of the older submap [submaps]."""

SAME_PASS = 3
"""Distance of two candidates up to which the robot passed the place once [submaps]."""


class Links:
    """Submaps joined by closures.

    Parameters
    ----------
    submaps : list of Submap
    edges : Edges
        Edges of the pose graph of their key frames.
    """

    def __init__(self, submaps: list[Submap], edges: Edges) -> None:
        owner = np.repeat(np.arange(len(submaps)), [submap.end - submap.first for submap in submaps])
        ends = np.stack((edges.first, edges.second))[:, edges.kinds == EdgeKind.CLOSURE]
        joined: NDArray[np.int64] = np.sort(owner[ends[:, (ends < len(owner)).all(axis=0)]], axis=0)
        self._joined = set(map(tuple, joined.T.tolist()))

    def join(self, source: int, target: int) -> bool:
        """Return whether a closure joins a submap, or one beside it, with an older one, or one beside it."""
        return any(
            (target + before, source + after) in self._joined
            for after in range(-BESIDE_SOURCE, BESIDE_SOURCE + 1)
            for before in range(-BESIDE_TARGET, BESIDE_TARGET + 1)
        )

    def unlinked(self, source: int, candidates: Iterable[Candidate]) -> list[Candidate]:
        """Return the nearest candidate of each earlier pass, where nothing joins the submap with that pass there."""
        passes: list[list[Candidate]] = []
        for candidate in sorted(candidates, key=lambda candidate: candidate.target):
            if passes and candidate.target - passes[-1][-1].target <= SAME_PASS:
                passes[-1].append(candidate)
            else:
                passes.append([candidate])
        nearest = [min(found, key=lambda candidate: candidate.far) for found in passes]
        return [candidate for candidate in nearest if not self.join(source, candidate.target)]
