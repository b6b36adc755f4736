"""Cost matrix on a map file: the cost from each start to each goal."""

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
        The file cannot be read, or does not have exactly these two lists.
    """
    try:
        ends = json.loads(path.read_bytes())
    except (OSError, ValueError) as error:
        raise InvalidInput(f"cannot read starts and goals: {error}") from error
    if not (isinstance(ends, dict) and ends.keys() == {"starts", "goals"} and all(map(_are_poses, ends.values()))):
        raise InvalidInput(
            f'{path} must be a JSON object with starts and goals: {{"starts": [[x, y], ...], "goals": [[x, y], ...]}}'
        )
    return ends


def _are_poses(given: object) -> bool:
    return isinstance(given, list) and all(
        isinstance(pose, list) and len(pose) in (2, 3) and all(type(number) in (int, float) for number in pose)
        for pose in given
    )


def answer_of(costmap: Costmap, ends: dict[str, Any], *, allow_unknown: bool = True) -> dict[str, Any]:
    """Return the costs, a row per start and ``None`` where there is no path, and the computing time [s].

    Raises
    ------
    InvalidInput
        A number is not finite, or only some of the poses have a yaw.
    PlanningError
        A start or a goal is off the map or not free.
    """
    began = monotonic()
    threads = len(os.sched_getaffinity(0))
    costs = cost_matrix(costmap, ends["starts"], ends["goals"], threads=threads, allow_unknown=allow_unknown)
    rows = [[cost if math.isfinite(cost) else None for cost in row] for row in costs.tolist()]
    return {"costs": rows, "seconds": monotonic() - began}


def table_of(answer: dict[str, Any]) -> tuple[list[dict[str, Any]], list[str]]:
    """Return the rows and columns of the table: costs by the index of start and goal, from 0."""
    rows = answer["costs"]
    columns = ["start", *(f"goal {number}" for number in range(len(rows[0]) if rows else 0))]
    return [dict(zip(columns, [number, *row], strict=True)) for number, row in enumerate(rows)], columns
