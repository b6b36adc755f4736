"""Merge of two mappings of one place that were made without a common start, if one hypothesis alone fits."""

from collections.abc import Callable, Sequence
from itertools import islice
from typing import NamedTuple

from ppaas.errors import InvalidInput, MapsNotMerged
from ppaas.geometry import Pose2D
from ppaas.mapping.closures.submaps import travelled
from ppaas.mapping.graph.pose_graph import PoseGraph, measured_odometry
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.merging.common_laser import joined_frames
from ppaas.mapping.merging.hypothesis import Hypothesis, hypothesis, joined_graph
from ppaas.mapping.merging.matches import PartSearch, PlaceMatch, agreeing_sets
from ppaas.mapping.merging.parameters import MergeParameters
from ppaas.mapping.refinement import RefinementSettings, refine
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.planar_poses import relative

# -- acceptance: one hypothesis fits, and no other about as well -------------------------------------------------------

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


# -- the merge ---------------------------------------------------------------------------------------------------------

DEFAULTS = MergeParameters()

REFINEMENT = RefinementSettings(gates=(0.2, 0.1), pair_again=(0,), near=12)
"""Settings of the joint refinement: each of the mappings was refined before."""

MOST_SETS = 4
"""Largest number of sets of matches that are compared."""

FEWEST_OF_RIVAL = 2
"""Fewest matches of a set that is compared with the largest one."""

STAGES = 3
"""Number of steps of the progress after the search: comparison, solve, refinement."""

Progress = Callable[[int, int], None]
"""Called with the number of steps done and of all."""


class Merged(NamedTuple):
    """Result of a merge.

    Parameters
    ----------
    mapping : Mapping
        Key frames of the first mapping, then of the second, in the frame of the first.
    motion : Pose2D
        Frame of the second mapping in the frame of the first, at its first key frame.
    matches : int
        Number of places that agree.
    support, confirmed : float
        See `MergeParameters`.
    """

    mapping: Mapping
    motion: Pose2D
    matches: int
    support: float
    confirmed: float


def merge(
    first: Mapping, second: Mapping, parameters: MergeParameters = DEFAULTS, done: Progress | None = None
) -> Merged:
    """Return one mapping of two.

    Parameters
    ----------
    first, second : Mapping
        Mappings of the same or of different lasers; left unchanged.
    parameters : MergeParameters
    done : callable, optional
        Called with the number of steps done and of all; an exception that it raises ends the merge.

    Raises
    ------
    MapsNotMerged
        The maps do not overlap enough, or several ways to lay one on the other fit about as well.
    InvalidInput
        A mapping has no key frame.
    InvalidGraph
        The merged graph cannot be solved.
    """
    if not (len(first.frames) and len(second.frames)):
        raise InvalidInput("a map without scans cannot be merged: map a part of the area that both share first")
    report = done or _silent
    # Scans are compared at the beams of the coarser laser: a coarse one's scans have gaps at the beams of a fine one.
    coarse, graph = joined_frames(first.frames, second.frames, finest=False), joined_graph(first.graph, second.graph)
    coarse.poses[:] = graph.poses
    found = _found(coarse, graph, len(first.frames), parameters, report)
    return _merged(first, second, found, report)


def _found(
    frames: KeyFrames, graph: PoseGraph, first: int, parameters: MergeParameters, report: Progress
) -> tuple[Hypothesis, int]:
    """Return the only acceptable hypothesis, and the number of steps reported."""
    search = PartSearch(frames, first, parameters)
    matches: list[PlaceMatch] = []
    parts = search.parts()
    for number, part in enumerate(parts):
        report(number, len(parts) + STAGES)
        matches += search.search(part)
    report(len(parts), len(parts) + STAGES)
    sets = islice(agreeing_sets(graph, matches, parameters.closures.drift), MOST_SETS)
    hypotheses = [
        hypothesis(frames, graph, first, chosen, parameters)
        for number, chosen in enumerate(sets)
        if not number or len(chosen) >= FEWEST_OF_RIVAL
    ]
    return accepted(hypotheses, graph, parameters), len(parts) + 1


def _merged(first: Mapping, second: Mapping, found: tuple[Hypothesis, int], report: Progress) -> Merged:
    """Return the mapping of a hypothesis, refined."""
    best, steps = found
    report(steps, steps + STAGES - 1)
    frames, before = joined_frames(first.frames, second.frames), len(first.frames)
    mapping = Mapping(frames, best.graph, first.laser_frame)
    mapping.move(refine(frames, best.graph.poses, measured_odometry(best.graph.edges), REFINEMENT).poses)
    motion = Pose2D(*frames.poses[before].tolist()) @ Pose2D(*second.graph.poses[0].tolist()).inverse()
    report(steps + STAGES - 1, steps + STAGES - 1)
    return Merged(mapping, motion, len(best.matches), best.support, best.confirmed)


def _silent(_done: int, _all: int) -> None:
    """Report no progress."""
