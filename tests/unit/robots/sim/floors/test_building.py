"""Robots of a simulated building ride in its lift, and meet its doors."""

import numpy as np
import pytest

from ppaas.buildings.doors.states import DoorRequest
from ppaas.buildings.lifts.states import EndSession, LiftRequest
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages.geometry_msgs import Twist, Vector3
from robots.sim.depth.camera import DepthCameraModel
from robots.sim.floors.building import SimulatedBuilding
from robots.sim.robot import SimulatedRobot, SimulatedRobotModel
from robots.sim.simulator import Simulator
from tests.support.world.planar_world import walled_map
from tests.support.world.simulated_building import BEFORE, IN_CAR, MODEL, building, layout


def run(simulated: SimulatedBuilding, seconds: float, *asked: LiftRequest | DoorRequest) -> None:
    """Simulate for a time, and repeat requests each second."""
    for step in range(round(seconds / simulated.dt)):
        if step % 50 == 0:
            for request in asked:
                if isinstance(request, LiftRequest):
                    simulated.lifts[request.lift].request(request, simulated.time())
                else:
                    simulated.doors[request.floor, request.door].request(request, simulated.time())
        simulated.step()


def ahead(robot: SimulatedRobot) -> float:
    """Return the range that the laser measures straight ahead."""
    scan = robot.scan()
    found = scan.ranges[len(scan.ranges) // 2]
    return np.inf if found is None else found


def test_a_robot_rides_to_the_other_floor_at_its_place_in_the_car() -> None:
    simulated = building()
    robot = simulated.add_robot(IN_CAR, MODEL)
    passenger = simulated.add_robot(Pose2D(2.6, 3.5, 1.0), MODEL)
    other = simulated.add_robot(BEFORE, MODEL)
    before = robot.odometry().pose
    apart = robot.base.pose.inverse() @ passenger.base.pose
    run(simulated, 10.0, LiftRequest("A", "s", "up"))
    assert [simulated.floor_of(one) for one in (robot, passenger, other)] == ["up", "up", "low"]
    assert robot.base.pose == pytest.approx((3.0, 3.0, 0.0), abs=1e-6), "the map of this floor is turned by a quarter"
    assert robot.base.pose.inverse() @ passenger.base.pose == pytest.approx(apart, abs=1e-6)
    assert robot.odometry().pose == before
    assert robot.base.travelled == 0.0
    assert ahead(robot) > 2.0, "the landing is open"
    assert ahead(other) == pytest.approx(1.075, abs=0.03), "the landing of the floor that the car has left is closed"
    assert simulated.contacts.wall_contacts.total() == simulated.contacts.robot_contacts.total() == 0


def test_a_robot_in_a_car_sees_its_closed_doors_until_they_are_open() -> None:
    simulated = building()
    robot = simulated.add_robot(IN_CAR, MODEL)
    seen = []
    for _ in range(80):
        run(simulated, 0.1, LiftRequest("A", "s", "up"))
        seen.append((simulated.lifts["A"].state(simulated.time()).door, ahead(robot)))
    assert {door for door, _ in seen} == {"closed", "moving", "open"}
    for door, distance in seen:
        assert (distance > 2.0) == (door == "open"), (door, distance)
        assert door == "open" or distance == pytest.approx(0.875, abs=0.03)


def test_depth_cameras_see_doors_too() -> None:
    simulated = building()
    robot = simulated.add_robot(BEFORE, SimulatedRobotModel(camera=DepthCameraModel(width=64, height=48)))
    closed = robot.depths()[20:28, 28:36]
    assert closed.mean() == pytest.approx(1050, abs=60)
    run(simulated, 4.0, LiftRequest("A", "s", "low"))
    assert robot.depths()[20:28, 28:36].mean() > 2000


@pytest.mark.parametrize(("is_open", "contacts"), [(False, 1), (True, 0)])
def test_a_closed_landing_is_in_the_way_of_a_robot(is_open: bool, contacts: int) -> None:
    simulated = building()
    robot = simulated.add_robot(BEFORE, MODEL)
    if is_open:
        run(simulated, 4.0, LiftRequest("A", "s", "low"))
    for _ in range(40):
        robot.command(Twist(Vector3(x=0.4), Vector3()))
        run(simulated, 0.1)
    assert (robot.base.pose.y > 2.4) == is_open
    assert simulated.contacts.total(0) == contacts


def test_doors_do_not_close_on_a_robot_in_the_doorway() -> None:
    simulated = building()
    run(simulated, 4.0, LiftRequest("A", "s", "low"))
    robot = simulated.add_robot(Pose2D(3.0, 2.1, 1.57), MODEL)
    simulated.lifts["A"].end(EndSession("A", "s"), simulated.time())
    run(simulated, 5.0)
    state = simulated.lifts["A"].state(simulated.time())
    assert (state.door, state.floor) == ("open", "low"), "the light curtain sees it"
    run(simulated, 5.0, LiftRequest("A", "t", "up"))
    assert simulated.floor_of(robot) == "low"
    for _ in range(20):
        robot.command(Twist(Vector3(x=0.4), Vector3()))
        run(simulated, 0.1)
    run(simulated, 8.0, LiftRequest("A", "t", "up"))
    assert simulated.floor_of(robot) == "up"
    assert simulated.contacts.total(0) == 0


def test_a_door_is_opened_and_closes_behind_a_robot() -> None:
    simulated = building()
    robot = simulated.add_robot(Pose2D(2.0, 1.0, np.pi), MODEL)
    assert ahead(robot) == pytest.approx(0.95, abs=0.03)
    request = DoorRequest("low", "glass", "s", "open")
    run(simulated, 2.0, request)
    assert ahead(robot) == pytest.approx(1.9, abs=0.03)
    for _ in range(30):
        robot.command(Twist(Vector3(x=0.5), Vector3()))
        run(simulated, 0.1, request)
    run(simulated, 12.0)
    assert simulated.doors["low", "glass"].state(simulated.time()).mode == "closed"
    assert robot.base.pose.x < 1.0 - 0.18
    assert simulated.add_robot(Pose2D(2.0, 1.0, np.pi), MODEL).scan().ranges[180] == pytest.approx(0.95, abs=0.03)


def test_a_door_without_a_device_stands_open() -> None:
    simulated = building(door="")
    assert simulated.doors == {}
    assert ahead(simulated.add_robot(Pose2D(2.0, 1.0, np.pi), MODEL)) == pytest.approx(1.9, abs=0.03)


def test_robots_drive_out_on_the_other_floor_and_contacts_are_counted_there() -> None:
    simulated = building()
    robot = simulated.add_robot(IN_CAR, MODEL)
    run(simulated, 10.0, LiftRequest("A", "s", "up"))
    for _ in range(100):
        robot.command(Twist(Vector3(x=0.5), Vector3()))
        run(simulated, 0.1, LiftRequest("A", "s", "up"))
    assert robot.base.pose.x == pytest.approx(6.0 - 0.1 - 0.18, abs=0.02), "it has driven to the far wall"
    assert simulated.contacts.wall_contacts == {0: 1}


def test_one_seed_gives_one_simulation() -> None:
    def drive(seed: int) -> list[tuple[float, ...]]:
        simulated = building(seed=seed)
        robots = [simulated.add_robot(IN_CAR), simulated.add_robot(BEFORE), simulated.add_robot(IN_CAR, floor="up")]
        for robot in robots:
            robot.command(Twist(Vector3(x=0.2), Vector3(z=0.5)))
        run(simulated, 2.0, LiftRequest("A", "s", "up"))
        return [tuple(robot.base.pose) for robot in robots]

    assert drive(1) == drive(1) != drive(2)


def test_a_building_is_stepped_by_a_simulator() -> None:
    now = [100.0]
    simulated = building()
    simulator = Simulator(simulated, lambda: now[0], lambda: 1e9)
    robot = simulated.add_robot(IN_CAR, floor="up")
    now[0] += 0.2
    assert simulator.catch_up() == 10
    assert robot.odometry().header.stamp.seconds() == pytest.approx(1e9 + 0.2)
    assert {world.time() for world in simulated.floors.values()} == {simulated.time()}


def test_what_does_not_exist_is_refused() -> None:
    with pytest.raises(InvalidInput, match="floors are low, up"):
        building().add_robot(IN_CAR, floor="cellar")
    with pytest.raises(InvalidInput, match="'up' has no map"):
        SimulatedBuilding(layout("", 1.0), {"low": walled_map(6.0, 4.2, [])})
