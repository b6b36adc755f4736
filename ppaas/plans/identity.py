"""Ids of plans: of the same plan the same, so that it is kept once however often it is made."""

import hashlib

import msgspec

from ppaas.planners.base import PlanResult


def plan_id(map_id: str, version: str, result: PlanResult) -> str:
    """Return the id of a plan: of what it was made from, its ends and the cells that it runs through.

    Its poses follow from these, so that they need not all be read, which would take longer than many a plan.
    """
    made_from = map_id, version, result.planner, result.origin, result.reused, sorted(result.conditions.items())
    digest = hashlib.blake2b(msgspec.json.encode(made_from), digest_size=16)
    digest.update(result.poses[:1].tobytes())
    digest.update(result.poses[-1:].tobytes())
    digest.update(result.cells.tobytes())
    return digest.hexdigest()
