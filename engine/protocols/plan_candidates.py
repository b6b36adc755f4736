"""Kept plans on their way from a machine to a container, as planning sees them."""

from engine.protocols.machine_link import Candidate
from ppaas.plans.stored import StoredPlan
from storage.plan_checks import array_of


def stored_plan(candidate: Candidate) -> StoredPlan:
    """Return a plan that was found as planning sees it."""
    plan = candidate.plan
    poses = array_of(plan.poses)
    return StoredPlan(
        plan.id, plan.version, plan.planner, plan.start, plan.goal, plan.length, poses, candidate.whole,
        plan.parameters, plan.origin == "given",
    )  # fmt: skip
