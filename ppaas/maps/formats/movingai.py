"""Reader of the grid maps and scenarios of the MovingAI benchmarks.

Source: Sturtevant, "Benchmarks for Grid-Based Pathfinding", 2012. Row 0 is the first row of the file, so the ``y`` of a
scenario is a row and its ``x`` a column. A cell is one metre.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.maps.grid import FREE, OCCUPIED, GridInfo, GridMap

FREE_TERRAIN = b".GS"
"""Free terrain: ground (two characters) and swamp. Trees, water and all other characters are obstacles."""

_HEADER_LINES = 4
_COLUMNS = 9


@dataclass(frozen=True, slots=True)
class Scenario:
    """Queries of a scenario.

    Parameters
    ----------
    starts, goals : (n, 2) int64 array
        Row, column.
    optima : (n,) float64 array
        Length of a shortest 8-connected path that does not cut corners [cells].
    """

    starts: NDArray[np.int64]
    goals: NDArray[np.int64]
    optima: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.optima)

    def first(self, count: int | None) -> "Scenario":
        """Return the first ``count`` queries, or all for None."""
        return Scenario(self.starts[:count], self.goals[:count], self.optima[:count])

    def spread(self, count: int) -> "Scenario":
        """Return at most ``count`` queries, evenly spaced over the file, whose queries grow in length."""
        chosen = np.unique(np.linspace(0, len(self) - 1, min(count, len(self))).astype(np.int64))
        return Scenario(self.starts[chosen], self.goals[chosen], self.optima[chosen])


def parse_map(text: bytes) -> GridMap:
    """Parse a ``.map`` file.

    Raises
    ------
    InvalidMap
        The file is invalid; the text says where.
    """
    head, body = _split_header(text)
    height, width = (_size(head, key) for key in (b"height", b"width"))
    rows = body.split(b"\n")[:height]
    if len(rows) < height:
        raise InvalidMap(f"the map's header states {height} rows, but it has {len(rows)}")
    for number, row in enumerate(rows):
        if len(row.rstrip(b"\r")) != width:
            raise InvalidMap(f"row {number} of the map must have {width} cells, not {len(row)}")
    terrain = np.frombuffer(b"".join(row[:width] for row in rows), np.uint8).reshape(height, width)
    free = np.isin(terrain, np.frombuffer(FREE_TERRAIN, np.uint8))
    return GridMap(np.where(free, FREE, OCCUPIED).astype(np.int8), GridInfo(1.0, width, height))


def parse_scenario(text: bytes) -> Scenario:
    """Parse a ``.scen`` file.

    Raises
    ------
    InvalidMap
        The file is invalid; the text says where.
    """
    lines = text.decode("ascii", "replace").splitlines()
    if not lines or not lines[0].startswith("version"):
        raise InvalidMap("not a MovingAI scenario: it must begin with the line 'version 1'")
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
        raise InvalidMap(
            "not a MovingAI map: it must begin with the lines 'type octile', 'height N', 'width N' and 'map'"
        )
    return {pair[0]: pair[1] for pair in words if len(pair) == 2}, body


def _size(head: dict[bytes, bytes], key: bytes) -> int:
    value = head.get(key, b"")
    if not (value.isdigit() and len(value) < 10 and int(value)):
        text = value.decode("ascii", "replace")
        raise InvalidMap(f"the map's {key.decode()} must be a whole number of at least 1, not {text!r}")
    return int(value)
