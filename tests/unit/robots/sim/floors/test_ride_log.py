from ppaas.buildings.lifts.states import LiftRequest
from ppaas.geometry import Pose2D
from ppaas.messages.geometry_msgs import Twist, Vector3
from robots.sim.floors.building import SimulatedBuilding
from robots.sim.floors.ride_log import RideLog
from robots.sim.robot import SimulatedRobot
from tests.support.world.simulated_building import BEFORE, MODEL, building


def run(
    simulated: SimulatedBuilding, log: RideLog, seconds: float, floor: str, robot: SimulatedRobot, speed: float
) -> None:
    """Simulate for a time with the lift at a floor, while a robot drives."""
    for step in range(round(seconds / simulated.dt)):
        if step % 50 == 0:
            simulated.lifts["A"].request(LiftRequest("A", "s", floor), simulated.time())
        robot.command(Twist(Vector3(x=speed), Vector3()))
        simulated.step()
        log.after_step()


def test_waits_and_rides_are_measured() -> None:
    simulated = building()
    log = RideLog(simulated)
    idle = simulated.add_robot(BEFORE @ Pose2D(-0.5, 0.0), MODEL)
    robot = simulated.add_robot(BEFORE @ Pose2D(0.0, 0.5), MODEL)
    run(simulated, log, 6.0, "low", robot, 0.0)
    run(simulated, log, 5.0, "low", robot, 0.4)  # 2 m: into the car
    assert log.rides == []
    run(simulated, log, 8.0, "up", robot, 0.0)
    run(simulated, log, 8.0, "up", robot, -0.4)
    [ride] = log.rides
    assert (ride.robot, ride.lift, ride.origin, ride.destination) == (1, "A", "low", "up")
    assert 8.0 < ride.waited < 11.0, "6 s before the door, and the way in"
    assert 8.0 < ride.rode < 14.0
    assert 19.0 < ride.left < 27.0
    assert simulated.floor_of(idle) == "low"


def test_a_robot_that_passes_by_a_lift_does_not_ride() -> None:
    simulated = building()
    log = RideLog(simulated)
    robot = simulated.add_robot(Pose2D(1.6, 1.2, 0.0), MODEL)
    run(simulated, log, 8.0, "up", robot, 0.4)
    assert robot.base.pose.x > 3.5 and log.rides == []
