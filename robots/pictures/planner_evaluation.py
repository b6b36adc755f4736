"""A picture of how planners did on a map: how long they took over how far apart start and goal were."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ppaas.errors import InvalidInput
from robots.pictures.line_chart import Axis, Line, write_chart


def write_evaluation(path: Path, evaluation: Mapping[str, Any]) -> None:
    """Draw an evaluation, as the cloud gives it, and write it to a PNG file.

    Raises
    ------
    InvalidInput
        Nothing was computed yet, or the file cannot be written.
    """
    lines = [line for line in map(_line, evaluation["planners"]) if line.points]
    if not lines:
        raise InvalidInput(f"nothing was computed on map {evaluation['map']!r} yet: there is nothing to draw")
    title = f"{evaluation['map']}: what planners took, as they were asked"
    x = Axis("cells between start and goal", logarithmic=True)
    write_chart(path, title, lines, x, Axis("typical time to compute [ms]", logarithmic=True))


def _line(planner: Mapping[str, Any]) -> Line:
    points = [
        (_middle(*each["cells"]), each["typical_seconds"] * 1e3)
        for each in planner["complexities"]
        if each["typical_seconds"]
    ]
    return Line(f"{planner['planner']}, {planner['queries']} queries{_reused(planner)}", points)


def _reused(planner: Mapping[str, Any]) -> str:
    return f", {planner['reuse_rate']:.0%} reused" if planner["reuse_rate"] else ""


def _middle(first: float, last: float) -> float:
    return math.sqrt(max(first, 0.5) * last)
