"""Acceptance: a merge needs one hypothesis that fits, and no other that fits about as well."""

from collections.abc import Sequence

from ppaas.errors import MapsNotMerged
from ppaas.mapping.closures.submaps import travelled
from ppaas.mapping.graph.pose_graph import PoseGraph
from ppaas.mapping.merging.hypothesis import Hypothesis
from ppaas.mapping.merging.matches import PlaceMatch
from ppaas.mapping.merging.parameters import MergeParameters
from ppaas.planar_poses import relative

FEWEST_COMPARED = 10
"""Fewest scans of the second mapping that have to be near key frames of the first."""


def accepted(hypotheses: Sequence[Hypothesis], graph: PoseGraph, parameters: MergeParameters) -> Hypothesis:
    """Return the hypothesis that the points confirm best, if it passes all tests.

    Parameters
    ----------
    hypotheses : sequence of Hypothesis
        The one of the largest set of matches first.
    graph : PoseGraph
        Joined graph, before it was solved.
    parameters : MergeParameters

    Raises
    ------
    MapsNotMerged
        None passes, or another fits about as well.
    """
    enough = [one for one in hypotheses if _has_evidence(one.matches, graph, parameters)]
    if not enough:
        count = len(hypotheses[0].matches) if hypotheses else 0
        raise MapsNotMerged(
            f"too few places of the second map were found in the first: {count} agree, and {parameters.least_matches} "
            f"are needed, over {parameters.least_travel:g} m of the drive: map more of the area that both share, in "
            "the same directions"
        )
    best = max(enough, key=lambda one: (one.support >= parameters.least_support, one.confirmed))
    _check_contradictions(best, parameters)
    for rival in hypotheses:
        if rival is not best and _is_rival(rival, best, parameters):
            raise MapsNotMerged(
                f"ambiguous: the second map fits the first in more than one way, at {_place(best)} and at "
                f"{_place(rival)}: map more of what tells these places apart"
            )
    return best


def _has_evidence(matches: Sequence[PlaceMatch], graph: PoseGraph, parameters: MergeParameters) -> bool:
    """Return whether enough places agree, far enough apart along the drive that no corridor looks like all of them."""
    if len({match.source for match in matches}) < parameters.least_matches:
        return False
    middles = [match.source.middle for match in matches]
    poses = graph.poses[min(middles) : max(middles) + 1]
    return float(travelled(relative(poses[:-1], poses[1:])).sum()) >= parameters.least_travel


def _check_contradictions(best: Hypothesis, parameters: MergeParameters) -> None:
    """Raise ``MapsNotMerged`` unless the scans of the second mapping that overlap the first one agree with it."""
    compared = len(best.overlap.fits)
    if compared < FEWEST_COMPARED or best.support < parameters.least_support:
        raise MapsNotMerged(
            f"contradicted: where the maps would overlap, {int(best.overlap.fits.sum())} of {compared} scans fit, and "
            f"{parameters.least_support:.0%} of at least {FEWEST_COMPARED} have to: are these maps of one place?"
        )
    if best.confirmed < parameters.least_confirmed:
        raise MapsNotMerged(
            f"contradicted: where the maps would overlap, {best.confirmed:.1%} of what both saw agrees, and "
            f"{parameters.least_confirmed:.1%} has to: are these maps of one place, in the same state?"
        )


def _is_rival(one: Hypothesis, best: Hypothesis, parameters: MergeParameters) -> bool:
    """Return whether a hypothesis fits about as well as the best one."""
    if len(one.overlap.fits) < FEWEST_COMPARED or one.support < parameters.rival_share * best.support:
        return False
    limit = parameters.rival_factor * (1.0 - best.confirmed) + parameters.rival_margin
    return 1.0 - one.confirmed <= limit


def _place(one: Hypothesis) -> str:
    """Return the motion of the second mapping by a hypothesis, as text."""
    x, y, turn = max(one.matches, key=lambda match: match.score).motion
    return f"({x:.1f} m, {y:.1f} m, {turn:.2f} rad)"
