"""Generated drawings, packed clouds, rasters and maps of mowers, of a few kilobytes or of about 10 MB."""

import io
import math
from collections.abc import Iterator

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.maps.exports.geotiff import geotiff_file
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo, GridMap

ROOM, BRICK = 3.0, 0.25
"""Edges of a room of a floor plan, and of the bricks in which its walls are drawn [m]."""

DOOR = (4, 5, 6, 7)
"""Bricks of a wall that a door takes the place of."""

UNIT = 0.01
"""Metres of a unit of a floor plan."""

PIXEL = 0.025
"""Edge of a pixel of a plan in its own size [m]: half a cell, as it is imported."""

_Wall = tuple[float, float, float, float]
"""x, y of its ends [units of the plan]."""


def drawings(rooms: int) -> Iterator[tuple[str, bytes]]:
    """Return a floor plan of so many rooms as DXF and as SVG."""
    side = math.isqrt(rooms)
    walls = [wall for room in range(side * side) for wall in _walls(room % side, room // side)]
    yield "plan.dxf", _dxf(walls)
    yield "plan.svg", _svg(walls, side * ROOM / UNIT)


def _walls(column: int, row: int) -> Iterator[_Wall]:
    """Return the walls of a room, with a door to the right and one above."""
    edge, brick = ROOM / UNIT, BRICK / UNIT
    x, y, count = column * edge, row * edge, round(ROOM / BRICK)
    for at in range(count):
        low, high = at * brick, (at + 1) * brick
        yield x + low, y, x + high, y
        yield x, y + low, x, y + high
        if at not in DOOR:
            yield x + low, y + edge, x + high, y + edge
            yield x + edge, y + low, x + edge, y + high


def _dxf(walls: list[_Wall]) -> bytes:
    """Return a drawing of AutoCAD 2000: one half of the walls are lines, the other polylines; each has a handle."""
    head = "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1015\n9\n$INSUNITS\n70\n5\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n"
    line = (
        "0\nLINE\n5\n{handle:X}\n100\nAcDbEntity\n8\nWALLS\n100\nAcDbLine\n"
        "10\n{0:.3f}\n20\n{1:.3f}\n30\n0.0\n11\n{2:.3f}\n21\n{3:.3f}\n31\n0.0\n"
    )
    polyline = (
        "0\nLWPOLYLINE\n5\n{handle:X}\n100\nAcDbEntity\n8\nWALLS\n100\nAcDbPolyline\n90\n2\n70\n0\n"
        "10\n{0:.3f}\n20\n{1:.3f}\n10\n{2:.3f}\n20\n{3:.3f}\n"
    )
    entities = [(line, polyline)[at % 2].format(*wall, handle=0x100 + at) for at, wall in enumerate(walls)]
    return "".join((head, *entities, "0\nENDSEC\n0\nEOF\n")).encode()


def _svg(walls: list[_Wall], size: float) -> bytes:
    """Return a picture of walls with its origin at the upper left corner; one half are lines, the other paths."""
    line = '<line x1="{0:.2f}" y1="{1:.2f}" x2="{2:.2f}" y2="{3:.2f}" class="wall"/>'
    path = '<path d="M {0:.2f} {1:.2f} L {2:.2f} {3:.2f}" class="wall" id="w{at}"/>'
    parts = [(line, path)[at % 2].format(*wall, at=at) for at, wall in enumerate(walls)]
    pixels = round(size * UNIT / PIXEL)
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{pixels}" height="{pixels}" viewBox="0 0 {size:g} {size:g}">'
        '<g stroke="black" stroke-width="10" fill="none">'
    )
    return "".join((head, *parts, "</g></svg>")).encode()


def packed_cloud(points: NDArray[np.float32]) -> bytes:
    """Return points [m] as LAZ, in millimetres."""
    import laspy  # noqa: PLC0415 - of the extra of clouds

    header = laspy.LasHeader(point_format=0, version="1.2")
    header.scales = np.full(3, 0.001)
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = points.T.astype(np.float64)
    written = io.BytesIO()
    cloud.write(written, do_compress=True)
    return written.getvalue()


def raster(side: int) -> bytes:
    """Return a hall with pillars and unknown places as GeoTIFF, of so many pixels of 5 cm along an edge."""
    rng = np.random.default_rng(0)
    cells = np.full((side, side), FREE, np.int8)
    cells[rng.random(cells.shape) < 0.3] = UNKNOWN
    cells[::40, ::40] = OCCUPIED
    cells[[0, -1]] = cells[:, [0, -1]] = OCCUPIED
    return geotiff_file(GridMap(cells, GridInfo(0.05, side, side, Pose2D(0.0, 0.0, 0.0))), None)


def mower(corners: int) -> bytes:
    """Return a map of OpenMower: a round lawn with an outline of so many corners, and a flower bed in it."""

    def ring(radius: float, count: int) -> list[dict[str, float]]:
        angles = np.linspace(0.0, math.tau, count, endpoint=False).tolist()
        return [{"x": radius * math.cos(angle), "y": radius * math.sin(angle)} for angle in angles]

    areas = [
        {"id": kind, "properties": {"type": kind, "name": name, "active": True}, "outline": outline}
        for kind, name, outline in (("mow", "lawn", ring(15.0, corners)), ("obstacle", "bed", ring(2.0, 40)))
    ]
    return msgspec.json.encode({"areas": areas, "docking_stations": []})
