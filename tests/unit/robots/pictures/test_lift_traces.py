"""Pictures of runs in buildings."""

from pathlib import Path

import numpy as np
import pytest

from ppaas.errors import InvalidInput
from ppaas.maps.grid import FREE, GridInfo, GridMap
from robots.pictures.lift_traces import DOORS, FloorTracks, LiftTrace, colour_of, draw_lift_traces, write_lift_traces

GRID = GridMap(np.full((20, 30), FREE, np.int8), GridInfo(0.1, 30, 20))
FLOORS = [FloorTracks("L1", GRID, [(3, np.array([[0.5, 0.5], [1.0, 0.5]]))]), FloorTracks("L2", GRID, [])]
TIMES = [0.0, 1.0, 2.0, 3.0]
LIFT = LiftTrace("A", [0, 0, 1, 1], ["open", "open", "closed", "offline"], [[], [(0, 3)], [(0, 3)], []])


def test_tracks_are_on_their_floor_and_riders_on_the_line_of_the_lift() -> None:
    from matplotlib.colors import to_rgba

    first, second, lift = draw_lift_traces(FLOORS, TIMES, [LIFT]).axes
    assert (first.get_title(), second.get_title(), lift.get_title()) == ("L1", "L2", "A")
    assert (len(first.lines), len(second.lines)) == (1, 0)
    assert first.lines[0].get_color() == colour_of(3)
    bars = {
        (tuple(bar.get_facecolor()[0]), *bar.get_paths()[0].get_extents().intervalx.tolist())
        for bar in lift.collections
    }
    assert bars == {
        (to_rgba(DOORS["open"]), 0.0, 2.0),
        (to_rgba(DOORS["offline"]), 3.0, 3.0),
        (colour_of(3), 1.0, 2.0),
        (colour_of(3), 2.0, 3.0),
    }


def test_a_picture_is_a_png_file_and_one_of_nothing_is_refused(tmp_path: Path) -> None:
    write_lift_traces(tmp_path / "run.png", FLOORS, TIMES, [])
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(InvalidInput, match="nothing to draw"):
        write_lift_traces(tmp_path / "run.png", FLOORS, [], [LIFT])
