"""Plans on a map file, without a cloud."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ppaas import planners
from ppaas.costmap.build import build_layers
from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.maps.files import load_map
from ppaas.maps.grid import GridInfo
from ppaas.maps.record import Rules
from ppaas.nodes.models import robot_model
from ppaas.planners.base import PlanRequest, PlanResult
from robots.sim.map_file import read_map_files

MODEL = "turtlebot2"
"""The cloud as well plans for it where no robot is named."""

MAX_RADIUS = 100.0

IMAGES = (".pgm", ".png")

_TWO_CELLS = Costmap(np.zeros((1, 2), np.uint8), GridInfo(1.0, 2, 1))


@dataclass(frozen=True, slots=True)
class Robot:
    """What the map is inflated for: a model by name, or a radius [m] that goes before it."""

    model: str = MODEL
    radius: float | None = None

    def radius_of(self) -> float:
        """Return the radius [m].

        Raises
        ------
        NotFound
            No such model; the text lists those there are.
        InvalidParameter
            The radius is none.
        """
        if self.radius is None:
            return robot_model(self.model).robot_radius
        if not 0.0 <= self.radius < MAX_RADIUS:
            raise InvalidParameter(f"the radius of a robot is from 0 to {MAX_RADIUS:g} m, not {self.radius}")
        return self.radius


def yaml_of(path: Path) -> Path:
    """Return the YAML file of a map that is given by it or by its image."""
    return path.with_suffix(".yaml") if path.suffix.lower() in IMAGES else path


def inflated(record: bytes, image: bytes, radius: float, rules: Rules | None = None) -> Costmap:
    """Return the costmap of a map's two files, inflated for a robot as a clone has it.

    Raises
    ------
    InvalidMap
        The files are no map.
    """
    return build_layers(load_map(record, image, rules), robot_radius=radius).costmap


def costmap_of_file(path: Path, radius: float, rules: Rules | None = None) -> Costmap:
    """Return the costmap of a map on the disk.

    Raises
    ------
    InvalidMap
        It or its image cannot be read.
    """
    return inflated(*read_map_files(yaml_of(path)), radius, rules)


def plan(costmap: Costmap, start: Pose2D, goal: Pose2D, planner: str, tolerance: float) -> PlanResult:
    """Plan on as many threads as there are CPUs, for as long as it takes.

    Raises
    ------
    NotFound
        No such planner; the text lists those there are.
    InvalidInput
        A pose that is not finite, or a negative tolerance.
    PlanningError
        There is no path; one of its subclasses.
    """
    chosen = planners.create(planner)
    # A first plan loads the kernels, so that the time told of the second is the planner's alone.
    threads = len(os.sched_getaffinity(0))
    chosen.plan(_TWO_CELLS, PlanRequest(Pose2D(0.5, 0.5), Pose2D(1.5, 0.5), threads=threads))
    return chosen.plan(costmap, PlanRequest(start, goal, tolerance, threads=threads))


def answer_of(result: PlanResult) -> Mapping[str, Any]:
    """Return a result with the names that the cloud's answers have."""
    return {
        "planner": result.planner,
        "length": result.length,
        "cost": result.cost,
        "expanded": result.expanded,
        "seconds": result.seconds,
        "poses": result.poses.tolist(),
    }
