"""Import of a floor plan: its walls become occupied cells, and what they enclose free ones."""

from collections.abc import Callable
from pathlib import PurePath

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput, InvalidMap
from ppaas.geometry import Pose2D
from ppaas.imports.collection import uncollected
from ppaas.imports.maps.common.enclosed import enclosed
from ppaas.imports.maps.common.imported_map import ImportedMap, check_cells, grid_of, report_cells
from ppaas.imports.maps.drawings.dxf import draw_dxf
from ppaas.imports.maps.drawings.pdf import draw_pdf
from ppaas.imports.maps.drawings.picture import draw_picture
from ppaas.imports.maps.drawings.plan_picture import DrawnPlan, PlanOptions
from ppaas.imports.maps.drawings.svg import draw_svg
from ppaas.imports.report import ImportReport
from ppaas.maps.formats.image import ENDINGS
from ppaas.maps.grid import GridInfo

DRAWINGS: dict[str, Callable[[bytes, PlanOptions, ImportReport], DrawnPlan]] = {
    ".svg": draw_svg, ".dxf": draw_dxf, ".pdf": draw_pdf, **dict.fromkeys(ENDINGS, draw_picture),
}  # fmt: skip
"""Readers of plans by the endings of their names."""

MAX_FILE = 1 << 27
"""Limit of the size of a file [bytes]; the lines of a DXF take ten times their size."""

MOST_DARK = 0.7
"""Part of a plan above which the dark is the background."""

LEAST_ENCLOSED = 0.25
"""Part of the rectangle around all walls that closed walls enclose; the insides of double lines are less."""


@uncollected()
def import_plan(
    content: bytes, name: str, options: PlanOptions | None = None
) -> tuple[ImportedMap, ImportReport, DrawnPlan]:
    """Import a floor plan.

    Parameters
    ----------
    content : bytes
    name : str
        Name of the file, whose ending is that of its format.
    options : PlanOptions, optional

    Returns
    -------
    tuple of ImportedMap, ImportReport and DrawnPlan
        The last is the plan as it was drawn, before walls and free space were found.

    Raises
    ------
    InvalidMap
        The file cannot be read, has no walls, or would be too large.
    InvalidInput
        The format is unknown, a library for it is not installed, or the scale is missing.
    """
    options = options or PlanOptions()
    ending = PurePath(name).suffix.lower()
    if ending not in DRAWINGS:
        raise InvalidInput(f"{name} is not a floor plan; known endings are {', '.join(DRAWINGS)}")
    if len(content) > MAX_FILE:
        raise InvalidMap(f"{name} has {len(content)} bytes; at most {MAX_FILE} are allowed: leave out what is no wall")
    report = ImportReport(name)
    drawn = DRAWINGS[ending](content, options, report)
    dark = _dark(drawn, options, report)
    if options.thinnest > 0.0:
        dark = _without_thin(dark, drawn.pixel, options.thinnest, report)
    walls, info = _cells(dark, drawn, options.resolution)
    report.translated("walls", f"{int(walls.sum())} cells with a grey below {options.dark}")
    free = _free(walls, info, options, report)
    grid = grid_of(info, free, walls)
    report_cells(report, grid)
    return ImportedMap(grid), report, drawn


def _dark(drawn: DrawnPlan, options: PlanOptions, report: ImportReport) -> NDArray[np.bool_]:
    """Return the pixels of walls: the dark ones, or the light ones of a plan that is drawn on black."""
    dark: NDArray[np.bool_] = drawn.greys < options.dark
    if dark.mean() <= MOST_DARK:
        return dark
    report.translated("background", f"{dark.mean():.0%} of the plan are dark, so light lines are walls")
    return ~dark


def _without_thin(dark: NDArray[np.bool_], pixel: float, thinnest: float, report: ImportReport) -> NDArray[np.bool_]:
    """Return dark pixels without lines that are thinner than a width [m] along x or along y."""
    width = max(1, round(thinnest / pixel))
    kept = _runs(_runs(dark, width, 0), width, 1)
    report.without_effect("thin lines", f"{int((dark & ~kept).sum())} pixels of lines thinner than {thinnest:g} m")
    return kept


def _runs(dark: NDArray[np.bool_], width: int, axis: int) -> NDArray[np.bool_]:
    """Return the pixels of runs of dark pixels along an axis that are at least as long as ``width``."""
    count = dark.shape[axis] - width + 1
    if count < 1:
        return np.zeros_like(dark)
    total = np.cumsum(np.insert(dark.astype(np.int32), 0, 0, axis), axis=axis)
    size = total.shape[axis]
    whole = total.take(np.arange(width, size), axis) - total.take(np.arange(size - width), axis) == width
    marks = np.zeros((dark.shape[0] + (axis == 0), dark.shape[1] + (axis == 1)), np.int32)
    begin, end = [slice(None), slice(None)], [slice(None), slice(None)]
    begin[axis], end[axis] = slice(0, count), slice(width, width + count)
    marks[tuple(begin)] += whole
    marks[tuple(end)] -= whole
    return np.asarray(np.cumsum(marks, axis=axis).take(np.arange(dark.shape[axis]), axis) > 0)


def _cells(dark: NDArray[np.bool_], drawn: DrawnPlan, resolution: float) -> tuple[NDArray[np.bool_], GridInfo]:
    """Return the walls in cells of the map, row 0 the lowest: a cell is a wall if any of its pixels is."""
    rows, columns = (side * drawn.pixel / resolution for side in dark.shape)
    check_cells(columns, rows, resolution)
    cells = _resized(_resized(dark[::-1], rows, 0), columns, 1)
    x, y = drawn.corner
    return cells, GridInfo(resolution, cells.shape[1], cells.shape[0], Pose2D(x, y, 0.0))


def _resized(cells: NDArray[np.bool_], wanted: float, axis: int) -> NDArray[np.bool_]:
    size, count = cells.shape[axis], max(1, round(wanted))
    if count >= size:
        source = np.minimum(((np.arange(count) + 0.5) * size / count).astype(np.int64), size - 1)
        return np.asarray(cells.take(source, axis))
    return np.asarray(np.logical_or.reduceat(cells, (np.arange(count) * size / count).astype(np.int64), axis))


def _free(walls: NDArray[np.bool_], info: GridInfo, options: PlanOptions, report: ImportReport) -> NDArray[np.bool_]:
    if options.outside_is_free:
        return ~walls
    if options.start is not None:
        return enclosed(walls, info, options.start)
    inside = enclosed(walls, info)
    rows, columns = np.flatnonzero(walls.any(axis=1)), np.flatnonzero(walls.any(axis=0))
    if not len(rows):
        raise InvalidMap(f"the plan has no walls: nothing is darker than {options.dark}; choose another --dark")
    if inside.sum() >= LEAST_ENCLOSED * (rows[-1] - rows[0] + 1) * (columns[-1] - columns[0] + 1):
        report.translated("free space", "what walls enclose; --outside-free makes the rest free, too")
        return inside
    report.translated("free space", "walls have gaps to the outside, so all cells that are no walls are free")
    return ~walls
