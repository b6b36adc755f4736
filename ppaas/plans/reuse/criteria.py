"""The three criteria of the paper: when a plan that is kept is better than one that is computed.

A kept plan is taken if (a) getting it takes no longer than computing it is expected to take, (b) it was made on the
same version of the map, and (c) by the same algorithm, unless it is proved better by a shorter path for the same ends.

Of (a) more is asked here than in the paper: nobody knows beforehand whether a plan is kept, and a robot that looks in
vain has waited. So looking must be `MARGIN` times faster than computing, and it is given up when it is not: then
a plan that is found is there that much sooner, and one that is not costs a part of computing that is as small.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from ppaas.geometry import Pose2D
from ppaas.plans.reuse.time_estimates import Estimate
from ppaas.plans.stored import PlanQuery, StoredPlan, same_planner

MARGIN = 10.0
"""How many times faster than computing a plan it must be to get one that is kept."""

SAME_END = 1e-6
"""Ends that are no further apart are the same [m]."""


@dataclass(frozen=True, slots=True)
class ReuseVerdict:
    """Whether a kept plan is to be taken, and which criterion decided.

    Parameters
    ----------
    taken : bool
        Whether it is, as far as this criterion goes.
    criterion : str
        ``transmission`` (a), ``version`` (b), ``algorithm`` (c); or ``ends``, ``costmap``, ``bound`` where it cannot be
        joined, is blocked, or is too dear; ``kept`` where there is none, ``late`` where no answer came in time.
    numbers : dict of str to float
        By which it decided.
    """

    taken: bool
    criterion: str
    numbers: dict[str, float] = field(default_factory=dict)

    @property
    def is_for_long(self) -> bool:
        """Whether measured times refused it, which the next plan changes little."""
        return not self.taken and self.criterion == UNMEASURED.criterion and self != UNMEASURED

    def __str__(self) -> str:
        """Say it in a line."""
        numbers = ", ".join(f"{name} {value:.6g}" for name, value in self.numbers.items())
        return f"{'taken' if self.taken else 'refused'} by {self.criterion}" + (f" ({numbers})" if numbers else "")


UNMEASURED = ReuseVerdict(False, "transmission", {"samples": 0.0})
"""Nobody knows how long computing takes: it is measured by doing it."""


def by_time(transmission: Estimate, computation: Estimate | None, margin: float = MARGIN) -> ReuseVerdict:
    """Apply criterion (a), on the safe side of both estimates."""
    if computation is None:
        return UNMEASURED
    numbers = {
        "transmission": transmission.upper, "computation": computation.lower, "margin": margin,
        "samples": computation.samples,
    }  # fmt: skip
    return ReuseVerdict(transmission.upper * margin <= computation.lower, "transmission", numbers)


def by_version(stored: StoredPlan, question: PlanQuery) -> ReuseVerdict:
    """Apply criterion (b)."""
    return ReuseVerdict(stored.version == question.version, "version")


def by_algorithm(stored: StoredPlan, question: PlanQuery, others: Sequence[StoredPlan]) -> ReuseVerdict:
    """Apply criterion (c); where the planner asked heeds how a robot can turn, none of another planner will do.

    Parameters
    ----------
    stored : StoredPlan
        The plan.
    question : PlanQuery
        What is asked for.
    others : sequence of StoredPlan
        What else is kept near both ends: it may prove that the planner asked has done worse.
    """
    if same_planner(stored, question):
        return ReuseVerdict(True, "algorithm")
    worse = [each.length for each in others if same_planner(each, question) and _same_ends(each, stored)]
    own = min(worse, default=math.nan)
    better = not question.kinematic and stored.length < own
    return ReuseVerdict(better, "algorithm", {"length": stored.length, "own_length": own})


def _same_ends(one: StoredPlan, other: StoredPlan) -> bool:
    pairs = ((one.start, other.start), (one.goal, other.goal))
    return all(Pose2D(*a).distance_to(Pose2D(*b)) <= SAME_END for a, b in pairs)


def worth_a_look(question: PlanQuery, found: Sequence[StoredPlan], most: int = 2) -> list[StoredPlan]:
    """Return the plans that meet (b) and (c), the shortest way for who asks first: each has to be reached, too."""
    fit = [each for each in found if by_version(each, question).taken and by_algorithm(each, question, found).taken]
    return sorted(fit, key=lambda each: each.length + _way_to(each, question))[:most]


def _way_to(stored: StoredPlan, question: PlanQuery) -> float:
    to_start, to_goal = Pose2D(*stored.start), Pose2D(*stored.goal)
    return to_start.distance_to(question.start) + to_goal.distance_to(question.goal)
