"""Converts plans received over the machine link for the planners."""

from engine.protocols.machine_link import Candidate
from ppaas.plans.stored import StoredPlan
from storage.plan_checks import array_of


def stored_plan(candidate: Candidate) -> StoredPlan:
    """Return a candidate as a stored plan."""
    plan = candidate.plan
    poses = array_of(plan.poses)
    return StoredPlan(
        plan.id, plan.version, plan.planner, plan.start, plan.goal, plan.length, poses, candidate.whole,
        plan.parameters, plan.origin == "given",
    )  # fmt: skip
