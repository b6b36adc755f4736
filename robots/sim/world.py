"""Simulated world: walls of a map, robots, pedestrians and furniture, in fixed time steps."""

import numpy as np
import pymunk
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.maps.grid import OCCUPIED_THRESHOLD, GridMap
from robots.sim.actors import Actor, Script
from robots.sim.barrier import Barrier, Segment
from robots.sim.bodies.figure import PersonFigure
from robots.sim.bodies.furniture import Furniture
from robots.sim.contacts import ContactCounter
from robots.sim.depth.camera import Scene
from robots.sim.depth.shapes import Shapes, capsule, joined, shapes_of
from robots.sim.laser import Discs
from robots.sim.pedestrian import PEOPLE, Pedestrian, PedestrianModel
from robots.sim.robot import SimulatedRobot, SimulatedRobotModel
from robots.sim.shortest_paths import ShortestPaths
from robots.sim.walls import wall_of

TURTLEBOT_HEIGHT = 0.42
"""Height of a Turtlebot [m]."""


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
    bodies : bool
        Whether people have bodies: lasers see their two legs, and depth cameras the whole. Without, lasers see discs.
    contacts : ContactCounter, optional
        Counter that the floors of a building share; by default one for this world.
    """

    def __init__(
        self,
        grid: GridMap,
        seed: int = 0,
        dt: float = 0.02,
        epoch: float = 0.0,
        bodies: bool = False,
        *,
        contacts: ContactCounter | None = None,
    ) -> None:
        self.grid = grid
        self.dt = dt
        self.steps = 0
        self.epoch = epoch
        self.robots: list[SimulatedRobot] = []
        self.pedestrians: list[Pedestrian] = []
        self.furniture: list[Furniture] = []
        self.figures: list[PersonFigure] = []
        self._legs: dict[int, list[pymunk.Circle]] = {}
        self.pedestrian_model = PedestrianModel()
        self.occupied: NDArray[np.bool_] = grid.data >= OCCUPIED_THRESHOLD
        self._seed = seed
        self._bodies = bodies
        self._drawn: tuple[int, Shapes] | None = None
        self._space = pymunk.Space()
        self._space.collision_slop = 0.001
        self.contacts = ContactCounter(self.time) if contacts is None else contacts
        body, shapes = wall_of(self.occupied, grid.info)
        self._space.add(body, *shapes)

    def time(self) -> float:
        """Return the simulated time since the start [s]."""
        return self.steps * self.dt

    def stamp(self) -> float:
        """Return the stamp of the current time [seconds since the epoch]."""
        return self.epoch + self.time()

    def add_robot(
        self, pose: Pose2D, model: SimulatedRobotModel | None = None, number: int | None = None
    ) -> SimulatedRobot:
        """Add a robot.

        Parameters
        ----------
        pose : Pose2D
        model : SimulatedRobotModel, optional
        number : int, optional
            Number of the robot, which its noise and its contacts depend on; by default its index in this world.

        Raises
        ------
        InvalidInput
            The pose is not finite.
        """
        if not pose.is_finite():
            raise InvalidInput(f"pose of a robot must be finite, not {tuple(pose)}")
        index = len(self.robots) if number is None else number
        rng = np.random.default_rng((self._seed, index))
        robot = SimulatedRobot(self, self._space, pose, model or SimulatedRobotModel(), rng)
        self.contacts.watch(robot.base.body, index)
        self.robots.append(robot)
        return robot

    def take_over(self, robot: SimulatedRobot, origin: "World", pose: Pose2D) -> None:
        """Continue with a robot of another world, which has the same time and contacts, at a pose here."""
        origin.robots.remove(robot)
        robot.enter(self, self._space, pose)
        self.robots.append(robot)

    def add_barrier(self, ends: Segment) -> Barrier:
        """Add what can close the line between two points, such as a door; it is open at first."""
        return Barrier(self._space, self.occupied, self.grid.info, ends)

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
        self._add_person(pedestrian, pose)
        return pedestrian

    def add_actor(self, paths: ShortestPaths, pose: Pose2D, script: Script) -> Actor:
        """Add a person who follows a script.

        Parameters
        ----------
        paths : ShortestPaths
            Paths that the person walks.
        pose : Pose2D
            Pose at the start.
        script : iterator of Activity
        """
        rng = np.random.default_rng((self._seed, len(self.pedestrians), 1))
        actor = Actor(self._space, paths, pose, self.pedestrian_model, rng, script=script)
        self._add_person(actor, pose)
        return actor

    def _add_person(self, pedestrian: Pedestrian, pose: Pose2D) -> None:
        if self._bodies:
            figure = PersonFigure(np.random.default_rng((self._seed, len(self.pedestrians), 2)))
            figure.face(pose.theta)
            self.figures.append(figure)
        self.contacts.add_person(pedestrian.body)
        self.pedestrians.append(pedestrian)

    def add_furniture(self, piece: Furniture) -> None:
        """Add a piece of furniture; robots that touch its legs touch a wall. It belongs before the first people."""
        self._add_legs(piece, self._space.static_body)
        self.furniture.append(piece)

    def move_furniture(self, piece: Furniture, moved: Furniture, carrier: SimulatedRobot | None = None) -> None:
        """Put another piece of furniture in place of one: on the floor, or as a part of the robot that carries it."""
        self._space.remove(*self._legs.pop(id(piece)))
        self._add_legs(moved, self._space.static_body if carrier is None else carrier.base.body)
        self.furniture = [moved if each is piece else each for each in self.furniture]

    def _add_legs(self, piece: Furniture, body: pymunk.Body) -> None:
        legs = [pymunk.Circle(body, radius, body.world_to_local((x, y))) for x, y, radius in piece.discs]
        for leg in legs:
            leg.friction = 0.4
            # People walk around furniture by their paths, and sit down on it.
            leg.filter = pymunk.ShapeFilter(mask=pymunk.ShapeFilter.ALL_MASKS() ^ PEOPLE)
        self._space.add(*legs)
        self._legs[id(piece)] = legs

    def others(self, robot: SimulatedRobot) -> tuple[Discs, ...]:
        """Return the true positions of the other robots and of the people, as discs."""
        robots = [tuple(other.base.body.position) for other in self.robots if other is not robot]
        return (_positions(robots), robot.model.base.radius), *self._people_discs(), *self._furniture_discs()

    def moving(self) -> list[Discs]:
        """Return the true positions of all robots and people, as discs."""
        robots = [(_positions([tuple(robot.base.body.position)]), robot.model.base.radius) for robot in self.robots]
        return [*robots, (self.people(), self.pedestrian_model.radius)]

    def _people_discs(self) -> list[Discs]:
        if not self._bodies:
            return [(self.people(), self.pedestrian_model.radius)]
        legs = [figure.legs(x, y) for figure, (x, y) in zip(self.figures, self.people().tolist(), strict=True)]
        return [(pair[:, :2], float(pair[0, 2])) for pair in legs]

    def _furniture_discs(self) -> list[Discs]:
        discs = np.array([disc for piece in self.furniture for disc in piece.discs]).reshape(-1, 3)
        return [(discs[discs[:, 2] == radius, :2], radius) for radius in np.unique(discs[:, 2]).tolist()]

    def scene(self, robot: SimulatedRobot) -> Scene:
        """Return what the depth camera of a robot sees beside the walls."""
        if self._drawn is None or self._drawn[0] != self.steps:
            bodies = [figure.shapes(x, y) for figure, (x, y) in zip(self.figures, self.people().tolist(), strict=True)]
            self._drawn = self.steps, joined([*bodies, *(piece.shapes for piece in self.furniture)])
        robots = [other for other in self.robots if other is not robot]
        shapes = joined([self._drawn[1], shapes_of([_turtlebot(other) for other in robots])])
        return Scene(shapes, tuple(piece.mirror for piece in self.furniture if piece.mirror is not None))

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
        self.contacts.update(robot.base.body for robot in self.robots)
        for robot in self.robots:
            robot.after_step(self.dt)

    def _walk(self) -> None:
        if not self.pedestrians:
            return
        robots = [(*robot.base.body.position, robot.model.base.radius) for robot in self.robots]
        people = [(*pedestrian.body.position, self.pedestrian_model.radius) for pedestrian in self.pedestrians]
        around = np.array(robots + people)
        for pedestrian in self.pedestrians:
            pedestrian.walk(self.time(), around, self.dt)
        for pedestrian, figure in zip(self.pedestrians, self.figures, strict=False):
            figure.sitting, figure.facing = pedestrian.sitting, pedestrian.facing
            figure.move(pedestrian.velocity, self.dt)


def _positions(found: list[tuple[float, ...]]) -> NDArray[np.float64]:
    return np.array(found, dtype=np.float64).reshape(-1, 2)


def _turtlebot(robot: SimulatedRobot) -> tuple[float, ...]:
    """Return a robot as a shape: a column up to its upper plate."""
    (x, y), radius = robot.base.body.position, robot.model.base.radius
    return capsule((x, y, 0.0), (x, y, TURTLEBOT_HEIGHT - radius), radius)
