"""Simulated shelf, which robots drive under and carry away, and the lift of a robot that does so."""

from collections.abc import Sequence
from dataclasses import dataclass

from ppaas.footprints import Footprint
from ppaas.geometry import Pose2D, wrap_angle
from robots.sim.bodies.furniture import Furniture, table
from robots.sim.robot import SimulatedRobot
from robots.sim.world import World


@dataclass(frozen=True, slots=True)
class LiftModel:
    """Parameters of a lift.

    Parameters
    ----------
    seconds : float
        Time until it is up or down [s].
    reach, turn : float
        Largest differences to the middle of a shelf, and to its direction or the opposite one, at which it lifts the
        shelf [m, rad].
    """

    seconds: float = 1.0
    reach: float = 0.12
    turn: float = 0.3


class Shelf:
    """Shelf on four legs in a world.

    Parameters
    ----------
    world : World
        It belongs there before the first people.
    pose : Pose2D
        Its middle in the frame of the map.
    length, width : float
        Along and across its pose [m]; the legs are 6 cm inside.
    """

    def __init__(self, world: World, pose: Pose2D, length: float = 1.0, width: float = 0.7) -> None:
        self.length, self.width = length, width
        self._world, self._pose = world, pose
        self._piece = self._at(pose)
        world.add_furniture(self._piece)

    @property
    def pose(self) -> Pose2D:
        """Its middle in the frame of the map."""
        return self._pose

    def move(self, pose: Pose2D, carrier: SimulatedRobot | None) -> None:
        """Put it to another pose, on the lift of a robot or on the floor."""
        piece, self._pose = self._at(pose), pose
        self._world.move_furniture(self._piece, piece, carrier)
        self._piece = piece

    def _at(self, pose: Pose2D) -> Furniture:
        return table(pose, self.length, self.width)


class SimulatedLift:
    """Lift of a robot.

    Parameters
    ----------
    robot : SimulatedRobot
    shelves : sequence of Shelf
        Shelves in its world.
    model : LiftModel, optional

    Attributes
    ----------
    up : bool
        Whether it is up, as the robot reports.
    shelf : Shelf or None
        The shelf on it.
    jammed : bool
        Whether it does not move.
    """

    def __init__(self, robot: SimulatedRobot, shelves: Sequence[Shelf], model: LiftModel | None = None) -> None:
        self.shelf: Shelf | None = None
        self.up = self.jammed = False
        self._robot, self._shelves, self._model = robot, shelves, model or LiftModel()
        self._wanted, self._left = False, 0.0
        self._offset = Pose2D(0.0, 0.0)

    def command(self, up: bool) -> None:
        """Begin to move up or down."""
        if up != self._wanted:
            self._wanted, self._left = up, self._model.seconds

    def after_step(self, seconds: float) -> None:
        """Move for a step of the world [s], with the shelf on it."""
        if not self.jammed:
            self._left -= seconds
        if self._wanted != self.up and self._left <= 0.0:
            self.up = self._wanted
            self._take() if self.up else self._put_down()
        if self.shelf is not None:
            self.shelf.move(self._robot.base.pose @ self._offset, self._robot)

    def _take(self) -> None:
        """Take the shelf above the robot, if there is one."""
        model, inverse = self._model, self._robot.base.pose.inverse()
        for shelf in self._shelves:
            offset = inverse @ shelf.pose
            turn = abs(wrap_angle(2.0 * offset.theta)) / 2.0
            if abs(offset.x) <= model.reach and abs(offset.y) <= model.reach and turn <= model.turn:
                self.shelf, self._offset = shelf, offset

    def _put_down(self) -> None:
        if self.shelf is not None:
            self.shelf.move(self.shelf.pose, None)
        self.shelf = None


def shelf_under(world: World, docked: Pose2D, load: Footprint) -> Shelf:
    """Put a shelf into a world, above a docked robot.

    Parameters
    ----------
    world : World
    docked : Pose2D
        Pose of the docked robot in the frame of the map.
    load : Footprint
        Outline of the shelf in the frame of the robot [m].
    """
    x, y = zip(*load, strict=True)
    middle = docked @ Pose2D(0.5 * (min(x) + max(x)), 0.5 * (min(y) + max(y)))
    return Shelf(world, middle, max(x) - min(x), max(y) - min(y))
