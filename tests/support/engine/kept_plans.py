"""Stored plans of another user on the map of a planning container."""

import numpy as np

from ppaas.geometry import poses_along
from storage.records import PlanRecord
from tests.support.engine.specs import planning_spec

PARAMETERS = {"smooth": False}
SPEC = planning_spec()


def record(plan_id: str, first: float, last: float, **changes: object) -> PlanRecord:
    """Return a plan of another user along the x axis."""
    poses = poses_along(np.stack((np.arange(first, last + 0.5), np.zeros(int(last - first) + 1)), axis=1))
    fields = {
        "id": plan_id, "user": "bob", "map": SPEC.map.id, "version": SPEC.map.version, "planner": "dijkstra",
        "start": (first, 0.0, 0.0), "goal": (last, 0.0, 0.0), "length": last - first, "cost": 1.0, "seconds": 0.1,
        "poses": poses.astype("<f8").tobytes(), "created": 1.0, "parameters": PARAMETERS | {"bare_map": True},
    }  # fmt: skip
    return PlanRecord(**(fields | changes))
