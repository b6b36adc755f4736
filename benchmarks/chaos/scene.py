"""Scenes of a chaos run: a map, its world, and robots that drive from goal to goal, some in traffic."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from random import Random

from benchmarks.chaos.robot_under_test import RobotUnderTest
from benchmarks.harness.cloud_under_test import CloudUnderTest
from benchmarks.harness.halls import largest_part
from ppaas.clone.traffic import roadmaps_of
from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.maps.generate import office, warehouse
from ppaas.maps.grid import GridMap
from ppaas.robot_model.known_models import robot_model
from ppaas.traffic.settings import TrafficParameters
from robots.sim.courses import Course, CoursePlanner
from robots.sim.simulator import Simulator
from robots.sim.world import World

CORES = 0.1
"""Size of a container [cores]: small enough that one machine can run all robots while the others are lost."""

GOALS = 6
"""Number of goals of a robot in traffic, which it visits in a circle."""

MODEL = "turtlebot2"
"""Model of the robots."""


@dataclass(frozen=True, slots=True)
class ChaosScene:
    """Robots on a map.

    Parameters
    ----------
    map_id : str
    grid : GridMap
    world : World
    courses : sequence of Course
        Starts and goals, one for each robot.
    operated : int
        Number of robots to which an operator sends the goals.
    simulator : Simulator
        Of the world.
    traffic : bool
        Whether the robots take part in the traffic of the map.
    """

    map_id: str
    grid: GridMap
    world: World
    courses: Sequence[Course]
    operated: int
    simulator: Simulator
    traffic: bool = False

    @property
    def contacts(self) -> int:
        """Number of contacts of two robots so far."""
        return self.world.contacts.robot_contacts.total() // 2

    async def enter(self, target: CloudUnderTest, tell: Callable[[str], None]) -> list[RobotUnderTest]:
        """Publish the map, register the robots, and return them; ``tell`` is called with each error."""
        await target.publish(self.map_id, self.grid)
        robots = []
        for number, course in enumerate(self.courses):
            name = f"{self.map_id}-{number}"
            await target.register(name, self.map_id, course.start, CORES, traffic=self.traffic)
            simulated = self.world.add_robot(course.start)
            address = target.url, target.token
            robots.append(
                RobotUnderTest(
                    address, name, simulated, course, tell, clock=self.world.time, operator=number < self.operated
                )
            )
        return robots


def in_office(number: int, seed: int, robots: int, operated: int, sides: tuple[float, float]) -> ChaosScene:
    """Return robots in an office, which drive around each other."""
    grid = office(seed, *sides)
    world = World(grid, seed)
    return ChaosScene(
        f"chaos-{number}", grid, world, CoursePlanner(grid, seed).choose(robots, 2), operated, Simulator(world)
    )


def in_traffic(seed: int, robots: int, sides: tuple[float, float]) -> ChaosScene:
    """Return robots in a warehouse that take part in its traffic; starts and goals are in cells."""
    grid, random = warehouse(seed, *sides), Random(seed)
    radius = robot_model(MODEL).robot_radius
    cells = roadmaps_of(build_layers(grid, robot_radius=radius))((radius,), TrafficParameters())
    drawn = largest_part(cells.roadmap)

    def pose(cell: int) -> Pose2D:
        return Pose2D(*cells.centre(cell), random.uniform(-3.0, 3.0))

    courses = [
        Course(pose(start), tuple(pose(cell) for cell in random.sample(drawn, GOALS)), ())
        for start in random.sample(drawn, robots)
    ]
    world = World(grid, seed)
    return ChaosScene("chaos-fleet", grid, world, courses, 0, Simulator(world), traffic=True)
