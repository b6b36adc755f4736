"""Loop closures, and candidates that were refused."""

from dataclasses import dataclass, field
from enum import Enum

from ppaas.geometry import Pose2D
from ppaas.mapping.closures.submaps import Submap
from ppaas.mapping.graph.pose_graph import Edges


class Reason(Enum):
    """Reason for which a candidate was refused."""

    SCORE = "no motion in the window fits well enough"
    AMBIGUOUS = "another motion fits nearly as well"
    CHECK = "too few scans passed the check"
    CONTRADICTED = "a match with another older submap fits better, elsewhere"


@dataclass(frozen=True, slots=True)
class Refusal:
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

    def refused(self, reason: Reason) -> Refusal:
        """Return the refusal of this closure."""
        return Refusal(self.source, self.target, reason, self.score, self.motion)


@dataclass(frozen=True, slots=True)
class Searched:
    """Result of a search.

    Parameters
    ----------
    closures : list of Closure
    refusals : list of Refusal
        Candidates that were searched in vain.
    """

    closures: list[Closure] = field(default_factory=list)
    refusals: list[Refusal] = field(default_factory=list)
