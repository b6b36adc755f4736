"""Offline planning: paths on a map file, without a cloud."""

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
from robots.client.map_files import read_map_file

MODEL = "turtlebot2"
"""Default robot model, the same as in the cloud."""

_TWO_CELLS = Costmap(np.zeros((1, 2), np.uint8), GridInfo(1.0, 2, 1))


@dataclass(frozen=True, slots=True)
class PlannedRobot:
    """Robot to plan for: a model by name, a URDF that overrides it, and a radius [m] that overrides both."""

    model: str = MODEL
    radius: float | None = None
    urdf: bytes | None = None

    def body(self) -> RobotModel:
        """Return the robot model that the map is inflated for, as in a clone.

        Raises
        ------
        NotFound
            There is no such model; the text lists the models.
        InvalidParameter
            The radius is invalid.
        InvalidInput
            The URDF is invalid or has no footprint.
        """
        described = None if self.urdf is None else describe(self.urdf)
        if described is not None and not described.footprint and self.radius is None:
            raise InvalidInput(
                f"the URDF has no footprint: {'; '.join(described.warnings) or 'its shapes have no size'}"
            )
        parameters = {} if self.radius is None else {COSTMAP: {"robot_radius": self.radius}}
        return robot_body(self.model, described, parameters)

    def radius_of(self) -> float:
        """Return the radius [m]. Raises as ``body`` does."""
        return self.body().robot_radius


def inflated(record: bytes, image: bytes, radius: float, rules: Rules | None = None) -> Costmap:
    """Return the costmap of a YAML file and an image, inflated for a robot as in a clone.

    Raises
    ------
    InvalidMap
        The files do not describe a map.
    """
    return build_layers(load_map(record, image, rules), robot_radius=radius).costmap


def costmap_of_file(path: Path, radius: float, rules: Rules | None = None) -> Costmap:
    """Return the inflated costmap of a map file: the YAML file, its image, or a map of MovingAI.

    Raises
    ------
    InvalidMap
        The file or its image cannot be read.
    """
    return build_layers(read_map_file(path, rules), robot_radius=radius).costmap


def plan(
    costmap: Costmap, start: Pose2D, goal: Pose2D, planner: str, tolerance: float, *, robot: PlannedRobot | None = None
) -> PlanResult:
    """Plan a path with one thread per CPU and no time limit; planners that can use the robot's footprint do.

    Raises
    ------
    NotFound
        There is no such planner; the text lists the planners.
    InvalidInput
        A pose is not finite, or the tolerance is negative.
    PlanningError
        There is no path; one of its subclasses.
    """
    chosen = planner_of((robot or PlannedRobot()).body(), planner, {})
    # A first plan loads the kernels, so the reported time is that of planning alone.
    threads = len(os.sched_getaffinity(0))
    chosen.plan(_TWO_CELLS, PlanRequest(Pose2D(0.5, 0.5), Pose2D(1.5, 0.5), threads=threads))
    return chosen.plan(costmap, PlanRequest(start, goal, tolerance, threads=threads))


def answer_of(result: PlanResult) -> Mapping[str, Any]:
    """Return a result with the keys of the REST service."""
    return {
        "planner": result.planner,
        "length": result.length,
        "cost": result.cost,
        "expanded": result.expanded,
        "seconds": result.seconds,
        "poses": result.poses.tolist(),
    }
