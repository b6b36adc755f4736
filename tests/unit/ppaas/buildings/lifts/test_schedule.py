from ppaas.buildings.building import Building, Floor, LiftSettings
from ppaas.buildings.lifts.schedule import CarStop, Shaft, levels_of, next_stop
from ppaas.buildings.lifts.states import LiftRide

SHAFT = Shaft({"L1": 0.0, "L2": 3.0, "L3": 6.0, "L4": 9.0}, LiftSettings(lift="A", robots=3))


def ride(robot, origin, destination, since=0.0, phase="waiting", size=1):
    return LiftRide(robot=robot, lift="A", origin=origin, destination=destination, since=since, phase=phase, size=size)


def test_floors_are_in_the_order_of_their_elevations():
    floors = (Floor(name="top", map="a", elevation=9.0), Floor(name="cellar", map="b", elevation=-3.0))
    assert levels_of(Building(floors=floors)) == {"cellar": -3.0, "top": 9.0}


def test_floors_without_elevations_are_in_their_order():
    levels = levels_of(Building(floors=tuple(Floor(name=name, map=name) for name in "abc")))
    assert list(levels) == ["a", "b", "c"]
    assert len(set(levels.values())) == 3


def test_a_car_that_nobody_needs_stays():
    assert next_stop(SHAFT, "L2", (), (), 0.0) is None


def test_several_robots_on_a_floor_are_fetched_before_one_on_another():
    waiting = [ride("a", "L1", "L4"), ride("b", "L1", "L4"), ride("c", "L1", "L3"), ride("d", "L3", "L1")]
    assert next_stop(SHAFT, "L2", (), waiting, 0.0) == CarStop("L1", 1)


def test_a_robot_that_has_waited_long_is_fetched_before_several():
    waiting = [ride("a", "L1", "L4", 190.0), ride("b", "L1", "L4", 190.0), ride("d", "L3", "L1", 0.0)]
    assert next_stop(SHAFT, "L1", (), waiting, 200.0) == CarStop("L3", -1)


def test_robots_of_the_same_direction_are_collected_on_the_way():
    riders = [ride("a", "L1", "L4", phase="inside")]
    assert next_stop(SHAFT, "L1", riders, [ride("b", "L2", "L3")], 0.0) == CarStop("L2", 1)
    assert next_stop(SHAFT, "L1", riders, [ride("b", "L2", "L1")], 0.0) == CarStop("L4", 1)
    assert next_stop(SHAFT, "L1", riders, [ride("b", "L2", "L3", size=3)], 0.0) == CarStop("L4", 1)


def test_nobody_is_collected_while_one_has_waited_long_elsewhere():
    riders = [ride("a", "L1", "L4", phase="inside")]
    waiting = [ride("b", "L2", "L3", 190.0), ride("c", "L4", "L1", 0.0)]
    assert next_stop(SHAFT, "L1", riders, waiting, 200.0) == CarStop("L4", 1)


def test_riders_leave_at_the_nearest_of_their_floors_first():
    riders = [ride("a", "L1", "L4", 0.0, "inside"), ride("b", "L1", "L2", 1.0, "inside")]
    assert next_stop(SHAFT, "L1", riders, (), 0.0) == CarStop("L2", 1)
