"""Loop closures, candidates that were refused, and the submaps that closures join."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.mapping.closures.candidates import SubmapCandidate
from ppaas.mapping.closures.submaps import Submap
from ppaas.mapping.graph.pose_graph import EdgeKind, Edges


class Reason(Enum):
    """Reason for which a candidate was refused."""

    SCORE = "no motion in the window fits well enough"
    AMBIGUOUS = "another motion fits nearly as well"
    CHECK = "too few scans passed the check"
    CONTRADICTED = "a match with another older submap fits better, elsewhere"


@dataclass(frozen=True, slots=True)
class RefusedClosure:
    """Candidate that was searched and refused.

    Parameters
    ----------
    source, target : Submap
    reason : Reason
    score : float
        Score of the best motion, 0 if it was not found.
    motion : Pose2D, optional
        Motion of the source in the map frame that fits best; None if none was found.
    """

    source: Submap
    target: Submap
    reason: Reason
    score: float
    motion: Pose2D | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Closure:
    """Loop closure between two submaps.

    Parameters
    ----------
    source, target : Submap
        Key frames that were matched, and the older ones.
    edges : Edges
        One edge for each scan that passed the check, from an older key frame to a later one.
    score : float
        Score of the match, from 0 to 1.
    motion : Pose2D
        Motion of the source in the map frame that the match asks for.
    wide : bool
        Whether the window was wide. Such a closure has to agree with others before it is trusted.
    """

    source: Submap
    target: Submap
    edges: Edges
    score: float
    motion: Pose2D
    wide: bool

    def refused(self, reason: Reason) -> RefusedClosure:
        """Return the refusal of this closure."""
        return RefusedClosure(self.source, self.target, reason, self.score, self.motion)


@dataclass(frozen=True, slots=True)
class Searched:
    """Result of a search.

    Parameters
    ----------
    closures : list of Closure
    refusals : list of RefusedClosure
        Candidates that were searched in vain.
    """

    closures: list[Closure] = field(default_factory=list)
    refusals: list[RefusedClosure] = field(default_factory=list)


# -- submaps that closures join, and passes that are not joined yet ----------------------------------------------------

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

    def unlinked(self, source: int, candidates: Iterable[SubmapCandidate]) -> list[SubmapCandidate]:
        """Return the nearest candidate of each earlier pass, where nothing joins the submap with that pass there."""
        passes: list[list[SubmapCandidate]] = []
        for candidate in sorted(candidates, key=lambda candidate: candidate.target):
            if passes and candidate.target - passes[-1][-1].target <= SAME_PASS:
                passes[-1].append(candidate)
            else:
                passes.append([candidate])
        nearest = [min(found, key=lambda candidate: candidate.far) for found in passes]
        return [candidate for candidate in nearest if not self.join(source, candidate.target)]
