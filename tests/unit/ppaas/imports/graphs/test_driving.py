"""Robots drive along the lanes of real graphs: the fleet is planned on the cells along them, as the traffic does."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from ppaas.fleet.first_plan import first_plan
from ppaas.fleet.lane_drawing import DrawnLane, lines_in
from ppaas.fleet.lane_roadmap import lane_roadmap
from ppaas.fleet.metric_roadmap import MetricFloor
from ppaas.fleet.robot_sizes import RobotSizes
from ppaas.geometry import Pose2D
from ppaas.imports.graphs.model.route_graph import GraphOptions
from ppaas.imports.graphs.reading import import_graph
from ppaas.maps.grid import GridInfo

FILES = {
    "foreign/nav2_wh.geojson": GraphOptions(),
    "buildings/office.building.yaml": GraphOptions(),
    "buildings/hotel.building.yaml": GraphOptions(level="L2"),
    "buildings/campus.building.yaml": GraphOptions(),
    "buildings/airport_terminal.building.yaml": GraphOptions(graph=2),
    "lif/10-7-station-with-two-nodes.lif.json": GraphOptions(),
    "lif/10-13-battery-charging-station.lif.json": GraphOptions(),
}


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("radius", [0.18, 0.3])
def test_robots_drive_from_end_to_end_along_the_lanes(data: Path, name: str, radius: float) -> None:
    given = FILES[name]
    options = GraphOptions(level=given.level, graph=given.graph, radius=radius)
    zones, _ = import_graph((data / name).read_bytes(), name, options)
    lines = lines_in(zones.zones)
    places = np.concatenate([line.points for line in lines])
    low, (wide, high) = places.min(axis=0) - 2.0, np.ptp(places, axis=0) + 4.0
    info = GridInfo(0.5, int(wide / 0.5), int(high / 0.5), Pose2D(float(low[0]), float(low[1]), 0.0))
    sizes = RobotSizes(radius, 0.1)
    free = np.full(info.shape, 9.0, np.float32)
    floor = MetricFloor(free, info, lane_roadmap(lines, free, info, sizes), radius)
    starts, goals = _ends(lines)
    plan = first_plan(floor.problem(starts, goals))
    centres = floor.metric.centres[plan.steps]
    assert np.hypot(*(centres[-1] - goals).T).max() < sizes.spacing
    moves = {(one, other) for one, other in floor.metric.roadmap.moves.tolist()}
    for robot in plan.steps.T.tolist():
        assert all(one == other or (one, other) in moves for one, other in pairwise(robot))


def _ends(lines: list[DrawnLane]) -> tuple[np.ndarray, np.ndarray]:
    """Return the start of the longest lane, and the end of it, which a robot reaches on any graph."""
    longest = max(lines, key=lambda line: float(np.hypot(*np.diff(line.points, axis=0).T).sum()))
    return longest.points[:1], longest.points[-1:] if len(longest.points) == 2 else longest.points[-2:-1]
