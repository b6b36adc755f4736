"""The simulated world of ``robots.sim`` with one Turtlebot, stepped by the test instead of a clock."""

from ppaas.geometry import Pose2D
from ppaas.maps.free_space import distance_to_occupied
from ppaas.maps.grid import GridMap
from ppaas.messages.geometry_msgs import Twist, Vector3
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import LaserScan
from robots.sim.odometry import OdometryNoise
from robots.sim.robot import SimulatedRobotModel
from robots.sim.world import World

STEP = 0.025
"""Length of a step of the simulation [s]."""


class SimulatedWorld:
    """World of a `ClosedLoop` with the slip, the odometry errors and the laser noise of the simulator.

    Parameters
    ----------
    grid : GridMap
        Map.
    pose : Pose2D
        Pose of the robot at the start.
    drift : float
        Factor on all errors of the odometry.
    seed : int
        Seed of all random numbers.
    step : float
        Length of a step of the simulation [s].
    """

    def __init__(self, grid: GridMap, pose: Pose2D, *, drift: float = 1.0, seed: int = 0, step: float = STEP) -> None:
        self.grid = grid
        self._step = step
        self._world = World(grid, seed, step)
        self._robot = self._world.add_robot(pose, SimulatedRobotModel(odometry=OdometryNoise(drift=drift)))
        self._distance = distance_to_occupied(grid)

    @property
    def pose(self) -> Pose2D:
        """True pose of the robot in the frame ``map``."""
        return self._robot.base.pose

    @property
    def touched(self) -> int:
        """Number of contacts of the robot with walls."""
        return self._world.contacts.total(0)

    def move(self, linear: float, angular: float, seconds: float) -> None:
        """Command the robot and simulate a time [s]."""
        self._robot.command(Twist(Vector3(x=linear), Vector3(z=angular)))
        for _ in range(round(seconds / self._step)):
            self._world.step()

    def carry_to(self, pose: Pose2D) -> None:
        """Move the robot to another pose without its odometry."""
        self._robot.base.carry_to(pose)

    def clearance(self) -> float:
        """Return the distance from the robot's centre to the nearest wall [m], up to 1 m."""
        cell = self.grid.info.cell_of(self.pose.x, self.pose.y)
        return min(float(self._distance[cell]), 1.0) if cell is not None else 0.0

    def odometry(self, stamp: float) -> Odometry:
        """Return the odometry as the robot sends it."""
        self._world.epoch = stamp - self._world.time()
        return self._robot.odometry()

    def scan(self, stamp: float) -> LaserScan:
        """Return the scan as the robot sends it."""
        self._world.epoch = stamp - self._world.time()
        return self._robot.scan()
