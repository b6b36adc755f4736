"""Chart of an evaluation of planners: the time to compute a path over the distance from start to goal."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ppaas.errors import InvalidInput
from robots.pictures.line_chart import Axis, Line, write_chart


def write_evaluation(path: Path, evaluation: Mapping[str, Any]) -> None:
    """Draw an evaluation, in the JSON of the REST service, and write the chart to a PNG file.

    Raises
    ------
    InvalidInput
        No path has been computed on the map yet, or the file cannot be written.
    """
    lines = [line for line in map(_line, evaluation["planners"]) if line.points]
    if not lines:
        raise InvalidInput(f"no path was computed on map {evaluation['map']!r} yet, so there is nothing to draw")
    title = f"{evaluation['map']}: computing time of the planners"
    x = Axis("cells between start and goal", logarithmic=True)
    write_chart(path, title, lines, x, Axis("typical time to compute [ms]", logarithmic=True))


def _line(planner: Mapping[str, Any]) -> Line:
    points = [
        (_geometric_mean(*each["cells"]), each["typical_seconds"] * 1e3)
        for each in planner["complexities"]
        if each["typical_seconds"]
    ]
    return Line(f"{planner['planner']}, {planner['queries']} queries{_reuse_rate(planner)}", points)


def _reuse_rate(planner: Mapping[str, Any]) -> str:
    return f", {planner['reuse_rate']:.0%} reused" if planner["reuse_rate"] else ""


def _geometric_mean(first: float, last: float) -> float:
    return math.sqrt(max(first, 0.5) * last)
