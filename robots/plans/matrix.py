"""What it costs to get from each of many starts to each of many goals, on a map file."""

import json
import math
import os
from pathlib import Path
from typing import Any

from ppaas.clock import monotonic
from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidInput
from ppaas.planners.batch.cost_matrix import cost_matrix


def read_ends(path: Path) -> dict[str, Any]:
    """Return the ``starts`` and ``goals`` of a JSON file, lists of [x, y] or [x, y, yaw] in metres and radians.

    Raises
    ------
    InvalidInput
        It cannot be read, or has not these two lists.
    """
    try:
        ends = json.loads(path.read_bytes())
    except (OSError, ValueError) as error:
        raise InvalidInput(f"cannot read starts and goals: {error}") from error
    if not (isinstance(ends, dict) and ends.keys() == {"starts", "goals"} and all(map(_are_poses, ends.values()))):
        raise InvalidInput(
            f'{path} must be a JSON object of starts and goals: {{"starts": [[x, y], ...], "goals": [[x, y], ...]}}'
        )
    return ends


def _are_poses(given: object) -> bool:
    return isinstance(given, list) and all(
        isinstance(pose, list) and len(pose) in (2, 3) and all(type(number) in (int, float) for number in pose)
        for pose in given
    )


def answer_of(costmap: Costmap, ends: dict[str, Any]) -> dict[str, Any]:
    """Return the costs, a row for each start, ``None`` where no way leads, and in how many seconds they were found.

    Raises
    ------
    InvalidInput
        A number is not finite, or some rows have a yaw and others not.
    PlanningError
        A start or a goal is not on the map, or not free.
    """
    began = monotonic()
    costs = cost_matrix(costmap, ends["starts"], ends["goals"], threads=len(os.sched_getaffinity(0)))
    rows = [[cost if math.isfinite(cost) else None for cost in row] for row in costs.tolist()]
    return {"costs": rows, "seconds": monotonic() - began}


def table_of(answer: dict[str, Any]) -> tuple[list[dict[str, Any]], list[str]]:
    """Return the rows that people see, and their columns: costs by the numbers of start and goal, from 0."""
    rows = answer["costs"]
    columns = ["start", *(f"goal {number}" for number in range(len(rows[0]) if rows else 0))]
    return [dict(zip(columns, [number, *row], strict=True)) for number, row in enumerate(rows)], columns
