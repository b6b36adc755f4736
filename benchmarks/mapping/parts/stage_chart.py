"""Chart of the error and the time of mapping after each stage."""

from itertools import accumulate
from pathlib import Path
from typing import Any

from robots.pictures.line_chart import Axis, Line, write_chart

STAGES = {
    "tracking": ("points", "tracking"),
    "closures": ("closures", "solver"),
    "refinement": ("refinement",),
    "polish": ("polish",),
}
"""Parts of the time of each stage."""


def write_stages(path: Path, results: list[dict[str, Any]]) -> None:
    """Write the chart of the logs with true relations to a PNG file.

    Raises
    ------
    InvalidInput
        The file name does not end with ``.png``, or the file cannot be written.
    """
    lines = [Line(result["log"], points) for result in results if (points := _points(result))]
    title = "Error after tracking, closures, refinement and polish"
    write_chart(path, title, lines, Axis("CPU time [s]"), Axis("mean error of the relations [m]", logarithmic=True))


def _points(result: dict[str, Any]) -> list[tuple[float, float]]:
    """Return the CPU time [s] and the error [m] after each stage; nothing for a log without relations."""
    # The parts are timed by the clock, of which other work on the computer takes a share.
    share = result["cpu_s"] / result["wall_s"]
    times = accumulate(share * sum(result["seconds"][part] for part in parts) for parts in STAGES.values())
    errors = [result["stages"][stage].get("mean_m") for stage in STAGES]
    return [(seconds, error) for seconds, error in zip(times, errors, strict=True) if error]
