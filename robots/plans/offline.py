"""Plans on a map file, without a cloud."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ppaas.clone.body_planners import planner_of
from ppaas.clone.robot_body import COSTMAP, robot_body
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.maps.formats.map_files import load_map
from ppaas.maps.formats.map_yaml import Rules
from ppaas.maps.grid import GridInfo
from ppaas.planners.base import PlanRequest, PlanResult
from ppaas.robot_model.describe import describe
from ppaas.robot_model.known_models import RobotModel
from robots.client.map_files import read_map_files

MODEL = "turtlebot2"
"""The cloud as well plans for it where no robot is named."""

IMAGES = (".pgm", ".png")

_TWO_CELLS = Costmap(np.zeros((1, 2), np.uint8), GridInfo(1.0, 2, 1))


@dataclass(frozen=True, slots=True)
class PlannedRobot:
    """For whom a path is: a model by name, a URDF that goes before it, and a radius [m] that goes before both."""

    model: str = MODEL
    radius: float | None = None
    urdf: bytes | None = None

    def body(self) -> RobotModel:
        """Return the body that the map is inflated for, as a clone has it.

        Raises
        ------
        NotFound
            No such model; the text lists those there are.
        InvalidParameter
            The radius is none.
        InvalidInput
            The URDF is none, or tells no footprint.
        """
        told = None if self.urdf is None else describe(self.urdf)
        if told is not None and not told.footprint and self.radius is None:
            raise InvalidInput(f"the URDF tells no footprint: {'; '.join(told.warnings) or 'its shapes have no size'}")
        said = {} if self.radius is None else {COSTMAP: {"robot_radius": self.radius}}
        return robot_body(self.model, told, said)

    def radius_of(self) -> float:
        """Return the radius [m]; raises as ``body``."""
        return self.body().robot_radius


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


def plan(
    costmap: Costmap, start: Pose2D, goal: Pose2D, planner: str, tolerance: float, *, robot: PlannedRobot | None = None
) -> PlanResult:
    """Plan on as many threads as there are CPUs, for as long as it takes; a robot's outline counts where a planner can.

    Raises
    ------
    NotFound
        No such planner; the text lists those there are.
    InvalidInput
        A pose that is not finite, or a negative tolerance.
    PlanningError
        There is no path; one of its subclasses.
    """
    chosen = planner_of((robot or PlannedRobot()).body(), planner, {})
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
