"""Simulated world: walls of a map, robots and pedestrians, in fixed time steps."""

import numpy as np
import pymunk
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.maps.grid import OCCUPIED_THRESHOLD, GridMap
from robots.sim.contacts import ContactCounter
from robots.sim.laser import Discs
from robots.sim.pedestrian import Pedestrian, PedestrianModel
from robots.sim.robot import SimulatedRobot, SimulatedRobotModel
from robots.sim.shortest_paths import ShortestPaths
from robots.sim.wall_rectangles import merge_rectangles


class World:
    """Map with robots and pedestrians. The same seed and commands give the same simulation.

    Parameters
    ----------
    grid : GridMap
        The map; cells of 65 or more are walls. Unknown cells are free.
    seed : int
        Seed of all random numbers.
    dt : float
        Length of a step [s].
    epoch : float
        Stamp of the start [seconds since the epoch].
    """

    def __init__(self, grid: GridMap, seed: int = 0, dt: float = 0.02, epoch: float = 0.0) -> None:
        self.grid = grid
        self.dt = dt
        self.steps = 0
        self.epoch = epoch
        self.robots: list[SimulatedRobot] = []
        self.pedestrians: list[Pedestrian] = []
        self.pedestrian_model = PedestrianModel()
        self.occupied: NDArray[np.bool_] = grid.data >= OCCUPIED_THRESHOLD
        self._seed = seed
        self._space = pymunk.Space()
        self._space.collision_slop = 0.001
        self.contacts = ContactCounter(self.time)
        self._build_walls()

    def _build_walls(self) -> None:
        info = self.grid.info
        body = pymunk.Body(body_type=pymunk.Body.STATIC)
        body.position = info.origin.x, info.origin.y
        body.angle = info.origin.theta
        corners = (merge_rectangles(self.occupied) * info.resolution).tolist()
        shapes = [pymunk.Poly.create_box_bb(body, pymunk.BB(*box)) for box in corners]
        for shape in shapes:
            shape.friction = 0.4
        self._space.add(body, *shapes)

    def time(self) -> float:
        """Return the simulated time since the start [s]."""
        return self.steps * self.dt

    def stamp(self) -> float:
        """Return the stamp of the current time [seconds since the epoch]."""
        return self.epoch + self.time()

    def add_robot(self, pose: Pose2D, model: SimulatedRobotModel | None = None) -> SimulatedRobot:
        """Add a robot.

        Raises
        ------
        InvalidInput
            The pose is not finite.
        """
        if not pose.is_finite():
            raise InvalidInput(f"pose of a robot must be finite, not {tuple(pose)}")
        index = len(self.robots)
        rng = np.random.default_rng((self._seed, index))
        robot = SimulatedRobot(self, self._space, pose, model or SimulatedRobotModel(), rng)
        self.contacts.watch(robot.base.body, index)
        self.robots.append(robot)
        return robot

    def add_pedestrian(self, paths: ShortestPaths, pose: Pose2D) -> Pedestrian:
        """Add a pedestrian.

        Parameters
        ----------
        paths : ShortestPaths
            Paths that the pedestrian walks.
        pose : Pose2D
            Pose at the start.
        """
        rng = np.random.default_rng((self._seed, len(self.pedestrians), 1))
        pedestrian = Pedestrian(self._space, paths, pose, self.pedestrian_model, rng)
        self.contacts.add_person(pedestrian.body)
        self.pedestrians.append(pedestrian)
        return pedestrian

    def others(self, robot: SimulatedRobot) -> tuple[Discs, ...]:
        """Return the true positions of the other robots and of the people, as discs."""
        robots = [tuple(other.base.body.position) for other in self.robots if other is not robot]
        return (_positions(robots), robot.model.base.radius), (self.people(), self.pedestrian_model.radius)

    def people(self) -> NDArray[np.float64]:
        """Return the true positions of the people, (n, 2) x, y [m]."""
        return _positions([tuple(pedestrian.body.position) for pedestrian in self.pedestrians])

    def step(self) -> None:
        """Simulate one step."""
        for robot in self.robots:
            robot.before_step()
        self._walk()
        self._space.step(self.dt)
        self.steps += 1
        self.contacts.update()
        for robot in self.robots:
            robot.after_step(self.dt)

    def _walk(self) -> None:
        """Update the velocities of the pedestrians."""
        if not self.pedestrians:
            return
        robots = [(*robot.base.body.position, robot.model.base.radius) for robot in self.robots]
        people = [(*pedestrian.body.position, self.pedestrian_model.radius) for pedestrian in self.pedestrians]
        around = np.array(robots + people)
        for pedestrian in self.pedestrians:
            pedestrian.walk(self.time(), around, self.dt)


def _positions(found: list[tuple[float, ...]]) -> NDArray[np.float64]:
    return np.array(found, dtype=np.float64).reshape(-1, 2)
