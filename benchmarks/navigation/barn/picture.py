"""Picture of one run: the cylinders, the true path of the robot, and its local costmap half-way."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.harness.map_figure import empty_figure, show_cells
from benchmarks.navigation.barn.environment import Environment
from benchmarks.navigation.barn.jackal import FOOTPRINT
from benchmarks.navigation.barn.navigator import PERIOD, BarnNavigator
from benchmarks.navigation.barn.run import BarnJob, BarnResult, drive
from benchmarks.navigation.barn.worlds import GOAL, GOAL_TOLERANCE, START, BarnWorld
from ppaas.costmap.costmap import INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, Costmap
from ppaas.geometry import Pose2D
from robots.pictures.figure_file import write_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MARGIN = 0.5
"""Free space around all that is drawn [m]."""

OUTLINE_PERIOD = 0.5
"""Time between two outlines of the robot [s]."""

CYLINDER, PATH, GOAL_AREA = "#545c6a", "#175fd6", "#148c55"

LETHAL = 214, 72, 23
"""RGB colour of cells of the costmap that are marked as obstacles."""


def write_picture(path: Path, job: BarnJob) -> None:
    """Drive one run and draw it into a PNG file.

    Raises
    ------
    InvalidInput
        The file cannot be written.
    """
    poses, costs = [START], []

    def watch(environment: Environment, navigator: BarnNavigator) -> None:
        poses.append(environment.pose)
        costs.append(navigator.costs)

    result = drive(job, watch)
    write_figure(path, draw(job.world, poses, costs[len(costs) // 2] if costs else None, result))


def draw(world: BarnWorld, poses: list[Pose2D], costs: Costmap | None, result: BarnResult) -> "Figure":
    """Return the picture of a run.

    Parameters
    ----------
    world : BarnWorld
    poses : list of Pose2D
        True poses of the robot in the frame of the world, one for each control cycle.
    costs : Costmap, optional
        Local costmap half-way, in the odometry frame.
    result : BarnResult
    """
    path = np.array([(pose.x, pose.y) for pose in poses])
    points = np.vstack((world.centres, path, [(GOAL.x, GOAL.y + GOAL_TOLERANCE)]))
    figure, axes = empty_figure(points.min(axis=0) - MARGIN, points.max(axis=0) + MARGIN)
    if costs is not None:
        show_cells(axes, _colours(costs), costs.info, START)  # the odometry begins at the start of the run
    _draw_world(axes, world)
    for pose in poses[:: round(OUTLINE_PERIOD / PERIOD)]:
        corners = [pose @ Pose2D(*corner) for corner in (*FOOTPRINT, FOOTPRINT[0])]
        axes.plot([corner.x for corner in corners], [corner.y for corner in corners], color=PATH, linewidth=0.8)
    axes.plot(*path.T, color=PATH, linewidth=2.0)
    axes.set_title(
        f"BARN world {world.world}: {result.outcome} after {result.seconds:.2f} s\n"
        f"smallest clearance {result.clearance:.3f} m"
    )
    axes.set_xlabel("grey: cylinders, orange: obstacle cells half-way, shade: their costs")
    return figure


def _draw_world(axes: "Axes", world: BarnWorld) -> None:
    from matplotlib.patches import Circle  # noqa: PLC0415 - heavy, and of the extra plot

    for centre in world.cylinders:
        axes.add_patch(Circle(centre, world.radius, color=CYLINDER))
    axes.add_patch(Circle((GOAL.x, GOAL.y), GOAL_TOLERANCE, edgecolor=GOAL_AREA, fill=False, linewidth=2.0))


def _colours(costs: Costmap) -> np.ndarray:
    """Return (height, width, 4) RGBA colours of the cells: shades of red by cost, orange where lethal."""
    part = np.minimum(costs.data, INSCRIBED_INFLATED_OBSTACLE) / INSCRIBED_INFLATED_OBSTACLE
    colours = np.full((*costs.data.shape, 4), 255, np.uint8)
    colours[..., 1] = colours[..., 2] = 255 - 45 * part
    colours[costs.data == LETHAL_OBSTACLE, :3] = LETHAL
    colours[costs.data == 0, 3] = 0
    return colours
