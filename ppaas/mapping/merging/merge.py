"""Merge of two mappings of one place that were made without a common start."""

from collections.abc import Callable
from itertools import islice
from typing import NamedTuple

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.mapping.graph.counterweights import measured_odometry
from ppaas.mapping.graph.pose_graph import PoseGraph
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.merging.acceptance import accepted
from ppaas.mapping.merging.agreement import agreeing_sets
from ppaas.mapping.merging.common_laser import joined_frames
from ppaas.mapping.merging.hypothesis import Hypothesis, hypothesis, joined_graph
from ppaas.mapping.merging.matches import PartSearch, PlaceMatch
from ppaas.mapping.merging.parameters import MergeParameters
from ppaas.mapping.refinement import RefinementSettings, refine
from ppaas.mapping.serialization.mapping import Mapping

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
