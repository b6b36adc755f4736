"""Offline planning: paths on a map file, without a cloud."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ppaas.clone.planning_variants import allows_unknown, planner_with, split
from ppaas.clone.robot_body import COSTMAP, costmap_parameters, robot_body
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.costmap import Costmap
from ppaas.costmap.global_parameters import CostParameters
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.maps.formats.map_yaml import Rules
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.planners.base import Planner, PlanRequest, PlanResult
from ppaas.robot_model.describe import describe
from ppaas.robot_model.known_models import RobotModel
from robots.client.map_files import read_map_file

MODEL = "turtlebot2"
"""Default robot model, the same as in the cloud."""

_TWO_CELLS = Costmap(np.zeros((1, 2), np.uint8), GridInfo(1.0, 2, 1))


@dataclass(frozen=True, slots=True)
class PlannedRobot:
    """Robot to plan for, and parameters of planning.

    Parameters
    ----------
    model : str
        Name of its model.
    radius : float, optional
        Radius that overrides all others [m].
    urdf : bytes, optional
        URDF that overrides the model.
    parameters : dict
        Parameters of the planner and the global costmap, as in requests to the cloud.
    """

    model: str = MODEL
    radius: float | None = None
    urdf: bytes | None = None
    parameters: Mapping[str, Any] = field(default_factory=dict)

    def body(self) -> RobotModel:
        """Return the robot model that the map is inflated for, as in a clone.

        Raises
        ------
        NotFound
            There is no such model; the text lists the models.
        InvalidParameter
            The radius or a parameter of the costmap is invalid.
        InvalidInput
            The URDF is invalid or has no footprint.
        """
        described = None if self.urdf is None else describe(self.urdf)
        if described is not None and not described.footprint and not self._has_size():
            raise InvalidInput(
                f"the URDF has no footprint: {'; '.join(described.warnings) or 'its shapes have no size'}"
            )
        return robot_body(self.model, described, {COSTMAP: self._of_costmap()})

    def costs(self) -> CostParameters:
        """Return the parameters of the costs; raises ``InvalidParameter`` as ``body`` does."""
        return costmap_parameters({COSTMAP: self._of_costmap()}).costs

    def planner(self, name: str) -> Planner:
        """Return a planner with the parameters.

        Raises
        ------
        NotFound
            There is no such planner; the text lists the planners.
        InvalidParameter
            A parameter is unknown or invalid; the text lists those that exist.
        """
        return planner_with(self.body(), name, split(self.parameters)[1])

    def allows_unknown(self) -> bool:
        """Return whether paths of a cost matrix lead through unknown cells; raises ``InvalidParameter``."""
        return allows_unknown(self.parameters)

    def _of_costmap(self) -> dict[str, Any]:
        own = {} if self.radius is None else {"robot_radius": self.radius}
        return split(self.parameters)[0] | own

    def _has_size(self) -> bool:
        return not self._of_costmap().keys().isdisjoint(("robot_radius", "footprint"))

    def radius_of(self) -> float:
        """Return the radius [m]. Raises as ``body`` does."""
        return self.body().robot_radius


def inflated(grid: GridMap, robot: PlannedRobot) -> Costmap:
    """Return the costmap of a map, inflated for a robot as in a clone; raises as ``PlannedRobot.body`` does."""
    costs = robot.costs()
    return build_layers(
        grid,
        robot_radius=robot.radius_of(),
        inflation_radius=costs.inflation_radius,
        cost_scaling_factor=costs.cost_scaling_factor,
        lethal_cost_threshold=costs.lethal_cost_threshold,
    ).costmap


def costmap_for(path: Path, robot: PlannedRobot, rules: Rules | None = None) -> Costmap:
    """Return the costmap of a map file for a robot: of a YAML file, its image, or a map of MovingAI.

    Raises
    ------
    InvalidMap
        The file or its image cannot be read.
    """
    return inflated(read_map_file(path, rules), robot)


def costmap_of_file(path: Path, radius: float, rules: Rules | None = None) -> Costmap:
    """Return the costmap of a map file for a round robot of this radius [m]; raises as ``costmap_for`` does."""
    return costmap_for(path, PlannedRobot(radius=radius), rules)


def plan(
    costmap: Costmap, start: Pose2D, goal: Pose2D, planner: str, tolerance: float, *, robot: PlannedRobot | None = None
) -> PlanResult:
    """Plan a path with one thread per CPU and no time limit; planners that can use the robot's footprint do.

    Raises
    ------
    NotFound
        There is no such planner; the text lists the planners.
    InvalidParameter
        A parameter is unknown or invalid.
    InvalidInput
        A pose is not finite, or the tolerance is negative.
    PlanningError
        There is no path; one of its subclasses.
    """
    chosen = (robot or PlannedRobot()).planner(planner)
    # A first plan loads the kernels, so the reported time is for planning alone.
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
