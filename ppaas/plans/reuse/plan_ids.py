"""Ids of plans. Equal plans get equal ids, so a plan is stored once however often it is made."""

import hashlib

import msgspec

from ppaas.planners.base import PlanResult
from ppaas.plans.stored import Conditions, Origin


class PlanIds:
    """Computes the ids of plans made on one map version, by one planner, under the same conditions.

    Parameters
    ----------
    map_id, version, planner : str
        Map, its version, and planner.
    conditions : dict
        Conditions under which the plans are made.
    origin : Origin
        Origin of the plans.
    reused : str
        Id of the stored plan that they were made from; empty for computed plans.
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
        self._prefix = hashlib.blake2b(msgspec.json.encode(made_from), digest_size=16)

    def of(self, result: PlanResult) -> str:
        """Return the id of a plan: a hash of its conditions, its end poses and the cells that it crosses.

        The poses between follow from these. Hashing them too would take longer than making many a plan.
        """
        digest = self._prefix.copy()
        digest.update(result.poses[:1].tobytes())
        digest.update(result.poses[-1:].tobytes())
        digest.update(result.cells.tobytes())
        return digest.hexdigest()
