"""Lanes of a map that is in files: the cells that robots have along them in the traffic."""

from pathlib import Path
from typing import Any

import numpy as np

from ppaas.clone.traffic import roadmaps_of
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidInput
from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.maps.grid import GridMap
from ppaas.traffic.settings import TrafficParameters
from ppaas.zones.gate import checked_zones
from robots.client.map_files import read_map_file


def cells_on_lanes(map_file: Path, zones_file: Path, radius: float) -> tuple[GridMap, MetricRoadmap]:
    """Return a map and the cells along its lanes for robots of a radius [m], as the traffic has them.

    Raises
    ------
    InvalidMap, InvalidZones
        A file is not valid.
    InvalidInput
        The zones cannot be read, have no lanes, or these leave no room for the robots; the text says where.
    """
    try:
        zones, _ = checked_zones(zones_file.read_bytes())
    except OSError as error:
        raise InvalidInput(f"cannot read {zones_file}: {error.strerror}") from error
    if not zones.lanes:
        raise InvalidInput(f"{zones_file.name} has no zones of the kind 'lane'")
    grid = read_map_file(map_file)
    return grid, roadmaps_of(build_layers(grid, robot_radius=radius, zones=zones))((radius,), TrafficParameters())


def facts_of(cells: MetricRoadmap) -> dict[str, Any]:
    """Return the number of cells, their width, the length of all lanes and of the longest move [m]."""
    ends = cells.centres[np.unique(np.sort(cells.roadmap.moves, axis=1), axis=0)]
    length = float(np.hypot(*(ends[:, 1] - ends[:, 0]).T).sum())
    return {
        "cells": len(cells.roadmap),
        "width": round(cells.spacing, 3),
        "length": round(length, 2),
        "longest_move": round(cells.longest_move, 3),
    }
