import numpy as np
import pytest

from ppaas.buildings.lifts.states import LiftRequest
from ppaas.geometry import Pose2D
from robots.sim.actors import Stay
from robots.sim.floors.people import LiftUser
from tests.support.world.simulated_building import BEFORE, IN_CAR, MODEL, building


def test_people_ride_get_out_and_come_back_and_push_no_robot() -> None:
    simulated = building(bodies=True)
    robot = simulated.add_robot(Pose2D(5.4, 0.5, 0.0), MODEL)
    user = LiftUser(simulated, "low", 1, longest_stay=1.0)
    floors, inside = {user.floor}, 0
    while user.rides < 2:
        simulated.step()
        floors.add(user.floor)
        car = simulated.cars["A"]
        if car.has(user.person):
            inside += 1
            assert simulated.lifts["A"].state(simulated.time()).mode in ("human", "agv")
        assert simulated.time() < 240.0
    assert floors == {"low", "up"} and inside > 100
    assert user.floor == "low", "two rides lead there and back"
    assert simulated.contacts.total(0) == 0
    assert sum(len(world.figures) for world in simulated.floors.values()) == 1
    assert robot.base.pose.x == pytest.approx(5.4, abs=0.01)


def test_robots_do_not_get_a_lift_that_people_use_and_people_none_that_robots_have() -> None:
    simulated = building()
    lift = simulated.lifts["A"]
    assert lift.call("low", "up", simulated.time())
    assert not lift.call("up", "low", simulated.time())
    lift.request(LiftRequest("A", "s", "up"), simulated.time())
    assert (lift.state(0.0).session, lift.state(0.0).mode) == ("", "human")
    for _ in range(1000):
        simulated.step()
    lift.request(LiftRequest("A", "s", "low"), simulated.time())
    assert lift.state(simulated.time()).session == "s"
    assert not lift.call("low", "up", simulated.time())


def test_somebody_who_stands_in_the_car_rides_with_a_robot_and_is_seen_by_it() -> None:
    simulated = building()
    robot = simulated.add_robot(IN_CAR @ Pose2D(0.3, 0.0), MODEL)
    person = simulated.floors["low"].add_actor(simulated.paths("low"), Pose2D(3.0, 3.4), iter([Stay(1000.0)]))
    for step in range(500):
        if step % 50 == 0:
            simulated.lifts["A"].request(LiftRequest("A", "s", "up"), simulated.time())
        simulated.step()
    assert person in simulated.floors["up"].pedestrians and simulated.floors["low"].pedestrians == []
    assert np.hypot(*(np.array(person.body.position) - robot.base.pose[:2])) == pytest.approx(0.7, abs=0.02)
    behind = robot.scan().ranges[0]
    assert behind == pytest.approx(0.7 - 0.25, abs=0.02)
    assert not simulated.cars["A"].is_empty


def test_people_find_no_paths_into_cars_whose_doors_are_closed() -> None:
    simulated = building()
    paths = simulated.paths("low")
    assert paths.allows(*BEFORE[:2]) and not paths.allows(*IN_CAR[:2])
    assert paths is simulated.paths("low")
