"""The grid maps and scenarios of the MovingAI benchmarks, the yardstick of grid planners.

Source: Sturtevant, "Benchmarks for Grid-Based Pathfinding", 2012. Rows keep the order of the file: row 0 is its first,
so the ``y`` of a scenario is a row and its ``x`` a column. A cell is one metre.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.maps.grid import FREE, OCCUPIED, GridInfo, GridMap

FREE_TERRAIN = b".GS"
"""Ground, ground again, and swamp, which those benchmarks take for ground; trees, water and the rest block."""

_HEADER_LINES = 4
_COLUMNS = 9


@dataclass(frozen=True, slots=True)
class Scenario:
    """The queries of a scenario.

    Parameters
    ----------
    starts, goals : (n, 2) int64 array
        Row, column.
    optima : (n,) float64 array
        Length of a shortest path, octile, that cuts no corner [cells].
    """

    starts: NDArray[np.int64]
    goals: NDArray[np.int64]
    optima: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.optima)

    def first(self, count: int | None) -> "Scenario":
        """Return the first so many queries; all for None."""
        return Scenario(self.starts[:count], self.goals[:count], self.optima[:count])

    def spread(self, count: int) -> "Scenario":
        """Return so many queries from all over the file, which begins with short ones; all if it has no more."""
        chosen = np.unique(np.linspace(0, len(self) - 1, min(count, len(self))).astype(np.int64))
        return Scenario(self.starts[chosen], self.goals[chosen], self.optima[chosen])


def parse_map(text: bytes) -> GridMap:
    """Read a ``.map`` file.

    Raises
    ------
    InvalidMap
        It is none; the text says where.
    """
    head, body = _split_header(text)
    height, width = (_size(head, key) for key in (b"height", b"width"))
    rows = body.split(b"\n")[:height]
    if len(rows) < height:
        raise InvalidMap(f"the map says it has {height} rows, and has {len(rows)}")
    for number, row in enumerate(rows):
        if len(row.rstrip(b"\r")) != width:
            raise InvalidMap(f"row {number} of the map has {len(row)} cells instead of {width}")
    terrain = np.frombuffer(b"".join(row[:width] for row in rows), np.uint8).reshape(height, width)
    free = np.isin(terrain, np.frombuffer(FREE_TERRAIN, np.uint8))
    return GridMap(np.where(free, FREE, OCCUPIED).astype(np.int8), GridInfo(1.0, width, height))


def parse_scenario(text: bytes) -> Scenario:
    """Read a ``.scen`` file.

    Raises
    ------
    InvalidMap
        It is none; the text says where.
    """
    lines = text.decode("ascii", "replace").splitlines()
    if not lines or not lines[0].startswith("version"):
        raise InvalidMap("a MovingAI scenario begins with the line 'version 1'")
    queries = [_query(number, line) for number, line in enumerate(lines[1:], start=2) if line.strip()]
    table = np.array(queries, np.float64).reshape(-1, 5)
    cells = table[:, :4].astype(np.int64)
    return Scenario(cells[:, 1::-1].copy(), cells[:, 3:1:-1].copy(), table[:, 4].copy())


def _query(number: int, line: str) -> list[float]:
    columns = line.split()
    try:
        if len(columns) != _COLUMNS:
            raise ValueError(f"{len(columns)} columns instead of {_COLUMNS}")
        return [*(float(int(value)) for value in columns[4:8]), float(columns[8])]
    except ValueError as error:
        raise InvalidMap(f"line {number} of the scenario cannot be read: {error}") from error


def _split_header(text: bytes) -> tuple[dict[bytes, bytes], bytes]:
    *lines, body = text.split(b"\n", _HEADER_LINES)
    words = [line.split() for line in lines]
    if len(words) != _HEADER_LINES or words[0] != [b"type", b"octile"] or words[-1] != [b"map"]:
        raise InvalidMap("a MovingAI map begins with the lines 'type octile', 'height N', 'width N' and 'map'")
    return {pair[0]: pair[1] for pair in words if len(pair) == 2}, body


def _size(head: dict[bytes, bytes], key: bytes) -> int:
    value = head.get(key, b"")
    if not (value.isdigit() and len(value) < 10 and int(value)):
        raise InvalidMap(f"the map's {key.decode()} is {value.decode('ascii', 'replace')!r}: a whole number from 1 up")
    return int(value)
