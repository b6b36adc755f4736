"""The three criteria of the paper for using a stored plan in place of a computed one.

A stored plan is used if (a) getting it takes no longer than computing it is expected to take, (b) it was made on the
same version of the map, and (c) by the same algorithm, unless it is known to be better: a shorter path between the same
ends.

Criterion (a) is stricter here than in the paper. It is not known beforehand whether a plan is stored, and a robot that
searches in vain has waited for nothing. So a search must be `MARGIN` times faster than computing, and it ends after
that time. A hit then comes `MARGIN` times sooner, and a miss costs 1/`MARGIN` of the computing time.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from ppaas.geometry import Pose2D
from ppaas.plans.reuse.time_estimates import Estimate
from ppaas.plans.stored import PlanQuery, StoredPlan, same_planner

MARGIN = 10.0
"""Factor by which getting a stored plan must be faster than computing one."""

SAME_END = 1e-6
"""Largest distance between two ends that count as equal [m]."""


@dataclass(frozen=True, slots=True)
class ReuseVerdict:
    """Whether a stored plan is used, and the criterion that decided.

    Parameters
    ----------
    taken : bool
        Whether the plan is accepted, as far as this criterion goes.
    criterion : str
        ``transmission`` (a), ``version`` (b), ``algorithm`` (c); ``ends``, ``costmap`` or ``bound`` if the plan cannot
        be joined to the ends, is blocked, or costs too much; ``kept`` if there is no stored plan, ``late`` if no answer
        came in time.
    numbers : dict of str to float
        Values on which the decision rests.
    """

    taken: bool
    criterion: str
    numbers: dict[str, float] = field(default_factory=dict)

    @property
    def is_lasting(self) -> bool:
        """Whether measured times led to the refusal, which the next plan changes little."""
        return not self.taken and self.criterion == UNMEASURED.criterion and self != UNMEASURED

    def __str__(self) -> str:
        """Return the verdict as one line of text."""
        numbers = ", ".join(f"{name} {value:.6g}" for name, value in self.numbers.items())
        return f"{'taken' if self.taken else 'refused'} by {self.criterion}" + (f" ({numbers})" if numbers else "")


UNMEASURED = ReuseVerdict(False, "transmission", {"samples": 0.0})
"""The computing time is unknown: computing a plan measures it."""


def by_time(transmission: Estimate, computation: Estimate | None, margin: float = MARGIN) -> ReuseVerdict:
    """Apply criterion (a) with the pessimistic ends of both estimates."""
    if computation is None:
        return UNMEASURED
    numbers = {
        "transmission": transmission.upper, "computation": computation.lower, "margin": margin,
        "samples": computation.samples,
    }  # fmt: skip
    return ReuseVerdict(transmission.upper * margin <= computation.lower, "transmission", numbers)


def by_version(stored: StoredPlan, query: PlanQuery) -> ReuseVerdict:
    """Apply criterion (b)."""
    return ReuseVerdict(stored.version == query.version, "version")


def by_algorithm(stored: StoredPlan, query: PlanQuery, others: Sequence[StoredPlan]) -> ReuseVerdict:
    """Apply criterion (c). If the requested planner respects how a robot can turn, plans of other planners are refused.

    Parameters
    ----------
    stored : StoredPlan
        The plan.
    query : PlanQuery
        The search.
    others : sequence of StoredPlan
        The other stored plans near both ends. They may show that the requested planner has done worse.
    """
    if same_planner(stored, query):
        return ReuseVerdict(True, "algorithm")
    worse = [each.length for each in others if same_planner(each, query) and _same_ends(each, stored)]
    own = min(worse, default=math.nan)
    better = not query.kinematic and stored.length < own
    return ReuseVerdict(better, "algorithm", {"length": stored.length, "own_length": own})


def _same_ends(one: StoredPlan, other: StoredPlan) -> bool:
    pairs = ((one.start, other.start), (one.goal, other.goal))
    return all(Pose2D(*a).distance_to(Pose2D(*b)) <= SAME_END for a, b in pairs)


def best_candidates(query: PlanQuery, found: Sequence[StoredPlan], most: int = 2) -> list[StoredPlan]:
    """Return the plans that meet (b) and (c), sorted by length plus straight distances to the requested ends."""
    fit = [each for each in found if by_version(each, query).taken and by_algorithm(each, query, found).taken]
    return sorted(fit, key=lambda each: each.length + _detour_to(each, query))[:most]


def _detour_to(stored: StoredPlan, query: PlanQuery) -> float:
    to_start, to_goal = Pose2D(*stored.start), Pose2D(*stored.goal)
    return to_start.distance_to(query.start) + to_goal.distance_to(query.goal)
