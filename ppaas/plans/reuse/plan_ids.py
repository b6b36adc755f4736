"""Ids of plans: of the same plan the same, so that it is kept once however often it is made."""

import hashlib

import msgspec

from ppaas.planners.base import PlanResult
from ppaas.plans.stored import Conditions, Origin


class PlanIds:
    """Gives ids to the plans that are made on one map version, by one planner, under the same conditions.

    Parameters
    ----------
    map_id, version, planner : str
        Where, and by whom.
    conditions : dict
        Under which they are made.
    origin, reused
        Where they come from.
    """

    def __init__(
        self,
        map_id: str,
        version: str,
        planner: str,
        conditions: Conditions,
        *,
        origin: Origin = "computed",
        reused: str = "",
    ) -> None:
        made_from = map_id, version, planner, origin, reused, sorted(conditions.items())
        self._begun = hashlib.blake2b(msgspec.json.encode(made_from), digest_size=16)

    def of(self, result: PlanResult) -> str:
        """Return the id of a plan: of what it was made from, its ends and the cells that it runs through.

        Its poses follow from these, so that they need not all be read, which would take longer than many a plan.
        """
        digest = self._begun.copy()
        digest.update(result.poses[:1].tobytes())
        digest.update(result.poses[-1:].tobytes())
        digest.update(result.cells.tobytes())
        return digest.hexdigest()
