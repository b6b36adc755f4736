"""Service ``find_floor``: on which floor a robot has left a lift, by scans, barometer and the word of the lift."""

import math

import numpy as np
import pytest
from msgspec.structs import replace

from ppaas.buildings.riding.air import GAS
from ppaas.buildings.riding.floor_maps import REACH, grid_of, part_around
from ppaas.clock import ManualClock
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import Conflict, InvalidInput, InvalidMap, PPaaSError, Unavailable
from ppaas.geometry import Pose2D
from ppaas.localization.parameters import AmclParameters
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.fleet.floors import FindFloorRequest, FindFloorResponse, FloorPart
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.sensor_msgs import FluidPressure
from ppaas.nodes.amcl.node import AmclNode
from ppaas.nodes.graph import Graph
from ppaas.nodes.tf.state_publisher import StatePublisherNode, StatePublisherParameters
from ppaas.robot_model.known_models import robot_model
from tests.support.world.planar_world import World, walled_map

FLOORS = {
    "L1": walled_map(6, 5, [(3, 0, 3.2, 2), (4.5, 3.5, 5.5, 4)]),
    "L2": walled_map(6, 5, [(3, 0, 3.2, 2), (1.5, 3.0, 2.5, 3.4)]),
    "L3": walled_map(6, 5, [(3, 0, 3.2, 2), (4.0, 1.0, 5.0, 3.0)]),
}
START = Pose2D(1.0, 1.0, 0.5)


def parts(shift: Pose2D = Pose2D(0.0, 0.0)) -> list[FloorPart]:
    """Return the maps of all floors; the frame of the robot's map has a pose in each of theirs."""
    found = [part_around(grid, START, name, 4.0 * n) for n, (name, grid) in enumerate(FLOORS.items())]
    return [replace(part, change=Pose.of(shift)) for part in found]


def asked(**fields: object) -> FindFloorRequest:
    return FindFloorRequest("L1", "L2", **{"named": "L2", "floors": parts(), **fields})  # type: ignore[arg-type]


class Leaving:
    """A robot that believes to be on one floor, and is on another."""

    def __init__(self, really: str, believed: str = "L2", **amcl: object) -> None:
        self.world, self.clock = World(FLOORS[really], START), ManualClock(100.0)
        self.graph = Graph(clock=self.clock, stamp_clock=self.clock)
        self.answers: list[FindFloorResponse | PPaaSError] = []
        model, state = robot_model("turtlebot2"), StatePublisherParameters()
        self.graph.add(lambda context: StatePublisherNode(context, model, state))
        layers, parameters = build_layers(FLOORS[believed]), AmclParameters(**amcl)  # type: ignore[arg-type]
        self.graph.add(lambda context: AmclNode(context, layers, START, parameters))

    def call(self, request: FindFloorRequest) -> None:
        self.graph.call("find_floor", request, self.answers.append)

    def step(self, count: int = 1, turn: float = 0.0) -> None:
        for _ in range(count):
            self.clock.advance(0.1)
            self.world.move(0.0, turn, 0.1)
            self.graph.inject("odom", self.world.odometry(self.clock()))
            self.graph.inject("scan", self.world.scan(self.clock()))
            self.graph.run_due()

    def air(self, pascal: float) -> None:
        self.graph.inject("barometer", FluidPressure(Header(), pascal))


@pytest.mark.parametrize("really", ["L1", "L2", "L3"])
def test_the_floor_is_found_by_scans_whatever_the_lift_says(really: str) -> None:
    robot = Leaving(really)
    robot.step(2)
    robot.call(asked())
    robot.step(30, turn=0.8)
    [answer] = robot.answers
    assert isinstance(answer, FindFloorResponse) and (answer.floor, answer.known, answer.fits) == (really, True, True)
    assert answer.pose.planar().distance_to(robot.world.pose) < 0.1 and answer.probability > 0.99


def test_the_pose_is_on_the_map_of_the_floor_that_was_found() -> None:
    robot = Leaving("L3")
    robot.step(2)
    shift = Pose2D(10.0, -3.0, 0.0)
    moved = {
        name: GridMap(grid.data, GridInfo(grid.info.resolution, grid.info.width, grid.info.height, shift))
        for name, grid in FLOORS.items()
    }
    floors = [part_around(grid, shift @ START, name, 4.0 * n) for n, (name, grid) in enumerate(moved.items())]
    robot.call(asked(floors=[replace(part, change=Pose.of(shift)) for part in floors]))
    robot.step(30, turn=0.8)
    [answer] = robot.answers
    assert isinstance(answer, FindFloorResponse) and answer.floor == "L3"
    assert answer.pose.planar().distance_to(shift @ START) < 0.1


def test_floors_that_look_alike_are_distinguished_by_the_barometer_alone() -> None:
    alike = [replace(part, data=parts()[0].data) for part in parts()]
    for pressure, floor, known in ((0.0, "L2", False), (101_325.0, "L3", True)):
        robot = Leaving("L1", believed="L1")
        robot.step(2)
        robot.air(101_325.0 * math.exp(-8.1 / GAS))
        robot.call(asked(floors=alike, named="", pressure=pressure, seconds=20.0, timeout=3.0))
        robot.step(40)
        [answer] = robot.answers
        assert isinstance(answer, FindFloorResponse) and (answer.floor, answer.known) == (floor, known)


def test_the_pressure_alone_is_answered_at_once_and_forgotten_when_it_is_old() -> None:
    robot = Leaving("L1")
    robot.call(FindFloorRequest())
    robot.air(99_000.0)
    robot.call(FindFloorRequest())
    robot.clock.advance(20.0)
    robot.call(FindFloorRequest())
    assert [answer.pressure for answer in robot.answers] == [0.0, 99_000.0, 0.0]  # type: ignore[union-attr]
    for wrong in (1013.0, math.nan):
        with pytest.raises(InvalidInput, match="30000 to 120000 Pa"):
            robot.air(wrong)


def test_a_search_that_cannot_be_is_refused_and_a_second_one_ends_the_first() -> None:
    robot = Leaving("L1")
    robot.call(asked())
    robot.step(2)
    robot.call(asked(timeout=1.0))
    robot.call(asked(timeout=1.0))
    for _ in range(30):
        robot.clock.advance(0.1)
        robot.graph.run_due()
    assert [type(answer) for answer in robot.answers] == [Unavailable, Conflict, Unavailable]
    assert "no scan could be used within 1 s" in str(robot.answers[2])
    itself = Leaving("L1", localize=False)
    itself.call(asked())
    assert isinstance(itself.answers[0], Conflict)


def test_damaged_maps_are_refused() -> None:
    robot = Leaving("L1")
    robot.step(2)
    robot.call(asked(floors=[replace(parts()[0], data=b"no"), *parts()[1:]]))
    robot.step(2)
    assert isinstance(robot.answers[0], InvalidInput) and "damaged" in str(robot.answers[0])
    with pytest.raises(InvalidInput, match="must have"):
        grid_of(replace(parts()[0], width=7))
    with pytest.raises(InvalidInput, match="at most"):
        grid_of(replace(parts()[0], width=3000, height=3000))


def test_a_part_of_a_large_map_is_around_the_lift() -> None:
    large = GridMap(
        np.arange(1000 * 800, dtype=np.int64).reshape(800, 1000).astype(np.int8) % 100, GridInfo(0.1, 1000, 800)
    )
    part = part_around(large, Pose2D(90.0, 5.0), "L1", 0.0)
    assert part.origin.planar() == pytest.approx(Pose2D(90.0 - REACH, 0.0, 0.0), abs=0.1)
    cells = grid_of(part)
    row, column = cells.info.to_cells(np.array((90.0, 5.0))).tolist()
    first, second = large.info.to_cells(np.array((90.0, 5.0))).tolist()
    assert cells.data[row, column] == large.data[first, second]
    with pytest.raises(InvalidMap, match="around the lift"):
        part_around(large, Pose2D(200.0, 5.0), "L1", 0.0)
