import math

import pytest
from msgspec.structs import replace

from ppaas.buildings.building import Building, Floor, LiftSettings
from ppaas.buildings.lifts.car import Car
from ppaas.buildings.lifts.controller import LiftController
from ppaas.buildings.lifts.schedule import Shaft
from ppaas.buildings.lifts.states import (
    Alight,
    Board,
    EndSession,
    LiftAlert,
    LiftRequest,
    LiftRide,
    LiftState,
    Refuse,
    RemoveRide,
    StoreRide,
    Wait,
)

FLOORS = ("L1", "L2", "L3")
SESSION = "ppaas/b/A"
BUILDING = Building(
    floors=tuple(Floor(name=name, map=name, elevation=3.0 * number) for number, name in enumerate(FLOORS)),
    lifts=(LiftSettings(lift="A", robots=2), LiftSettings(lift="B")),
)


class Scene:
    """A controller, and a lift whose state the test sets."""

    def __init__(self, rides=(), lobbies_taken=()):
        self.now = 100.0
        self.state = LiftState(lift="A", floor="L1")
        self.taken = set(lobbies_taken)
        self.controller = LiftController(
            "b",
            BUILDING,
            {"A": FLOORS, "B": FLOORS[:2]},
            self.now,
            rides=rides,
            may_leave=lambda _lift, floor: floor not in self.taken,
        )
        self.orders = []
        self.rides = {ride.robot: ride for ride in rides}

    def do(self, event, *arguments, **options):
        orders = getattr(self.controller, event)(*arguments, self.now, **options)
        self.orders += orders
        for order in orders:
            if isinstance(order, StoreRide):
                self.rides[order.ride.robot] = order.ride
            elif isinstance(order, RemoveRide):
                del self.rides[order.robot]
        return [order for order in orders if not isinstance(order, StoreRide | RemoveRide)]

    def request(self, robot, origin, destination, size=1, lift="A"):
        return self.do("request", robot, lift, origin, destination, size=size)

    def for_seconds(self, seconds, **changes):
        """Report a state four times a second; return the orders."""
        self.state = replace(self.state, **changes)
        before = len(self.orders)
        for _ in range(round(seconds * 4)):
            self.now += 0.25
            self.do("lift_state", self.state)
        return [order for order in self.orders[before:] if not isinstance(order, StoreRide | RemoveRide)]

    def silence(self, seconds):
        before = len(self.orders)
        for _ in range(round(seconds * 4)):
            self.now += 0.25
            self.do("tick")
        return [order for order in self.orders[before:] if not isinstance(order, StoreRide | RemoveRide)]

    def opens_at(self, floor, seconds=1.0):
        return self.for_seconds(seconds, floor=floor, door="open", motion="stopped", mode="agv", session=SESSION)

    def inside(self, robot, origin, destination):
        """Lead a robot into the car."""
        self.request(robot, origin, destination)
        assert Board(robot, "A", origin) in self.opens_at(origin)
        return self.do("entered", robot)

    def without_heartbeats(self, orders):
        return [order for order in orders if not isinstance(order, LiftRequest)]


def test_a_ride_from_request_to_end():
    scene = Scene()
    scene.for_seconds(1.0)
    assert LiftRequest("A", SESSION, "L1") in scene.request("r", "L1", "L3")
    assert Board("r", "A", "L1") in scene.opens_at("L1")
    assert LiftRequest("A", SESSION, "L3") in scene.do("entered", "r")
    scene.for_seconds(2.0, door="closed", motion="up")
    assert Alight("r", "A", "L3") in scene.opens_at("L3")
    assert scene.do("left", "r") == [EndSession("A", SESSION)]
    assert scene.rides == {}
    assert scene.for_seconds(3.0, session="", door="closed") == []


def test_requests_are_repeated_while_the_session_lasts():
    scene = Scene()
    scene.inside("r", "L1", "L3")
    orders = scene.for_seconds(5.0, door="closed", motion="up")
    assert orders == [LiftRequest("A", SESSION, "L3")] * 5


def test_an_end_that_the_lift_did_not_get_is_repeated():
    scene = Scene()
    scene.for_seconds(0.25, session=SESSION)
    assert scene.for_seconds(3.0).count(EndSession("A", SESSION)) >= 2


def test_doors_that_were_held_in_an_ended_session_let_nobody_in_at_once():
    scene = Scene()
    scene.inside("r", "L1", "L3")
    scene.do("left", "r")
    scene.request("r", "L1", "L3")
    assert not any(isinstance(order, Board) for order in scene.opens_at("L1", 0.5))
    assert Board("r", "A", "L1") in scene.opens_at("L1")


def test_doors_that_flap_let_nobody_in():
    scene = Scene()
    scene.request("r", "L1", "L3")
    for _ in range(20):
        scene.opens_at("L1", 0.25)
        scene.for_seconds(0.25, door="moving")
    assert not any(isinstance(order, Board) for order in scene.orders)
    assert Board("r", "A", "L1") in scene.opens_at("L1")


def test_robots_of_one_direction_share_the_car():
    scene = Scene()
    scene.for_seconds(0.5)
    scene.request("up", "L1", "L3")
    scene.request("also up", "L2", "L3")
    scene.request("down", "L2", "L1")
    assert Board("up", "A", "L1") in scene.opens_at("L1")
    assert LiftRequest("A", SESSION, "L2") in scene.do("entered", "up")
    assert Board("also up", "A", "L2", 1) in scene.opens_at("L2")
    assert LiftRequest("A", SESSION, "L3") in scene.do("entered", "also up")
    assert scene.rides["down"].phase == "waiting"


def test_robots_leave_before_others_enter():
    scene = Scene()
    scene.inside("in", "L1", "L2")
    scene.request("out", "L2", "L3")
    assert scene.without_heartbeats(scene.opens_at("L2")) == [Alight("in", "A", "L2")]
    assert Board("out", "A", "L2") in scene.do("left", "in")


def test_a_large_robot_has_the_car_alone():
    scene = Scene()
    scene.request("large", "L1", "L3", size=2)
    scene.request("small", "L1", "L3")
    scene.opens_at("L1")
    assert LiftRequest("A", SESSION, "L3") in scene.do("entered", "large")
    assert scene.rides["small"].phase == "waiting"


def test_nobody_boards_while_the_lobby_of_the_destination_is_taken():
    scene = Scene(lobbies_taken={"L3"})
    scene.request("r", "L1", "L3")
    assert scene.without_heartbeats(scene.opens_at("L1", 5.0))[-1:] == [EndSession("A", SESSION)]
    assert not any(isinstance(order, Board) for order in scene.orders)
    scene.taken.clear()
    assert Board("r", "A", "L1") in scene.opens_at("L1")


def test_robots_in_the_lobby_board_first_or_make_way_for_one_that_cannot_leave():
    scene = Scene()
    scene.inside("in", "L1", "L2")
    scene.request("out", "L2", "L3")
    scene.taken.add("L2")
    assert Wait("in", "the lobby of floor 'L2' is taken") in scene.opens_at("L2", 10.0)
    assert scene.rides["out"].phase == "waiting"
    assert Board("out", "A", "L2", 1) in scene.opens_at("L2", 10.0)
    scene.do("entered", "out")
    scene.request("third", "L2", "L3")
    scene.opens_at("L2", 20.0)
    assert Wait("third", "robots leave the lift here", clear=True) in scene.orders


def test_a_lift_that_never_comes_is_refused():
    scene = Scene()
    scene.for_seconds(1.0, session=SESSION)
    scene.request("r", "L3", "L1")
    orders = scene.for_seconds(65.0)
    assert Refuse("r", "lift 'A' does not come") in orders
    assert EndSession("A", SESSION) in orders
    assert scene.rides == {}


def test_robots_are_sent_elsewhere_within_five_seconds_when_a_lift_goes_out_of_order():
    scene = Scene()
    scene.for_seconds(1.0)
    for number in range(5):
        scene.request(f"r{number}", "L3", "L1")
    scene.for_seconds(5.0, mode="offline")
    assert sum(isinstance(order, Refuse) for order in scene.orders) == 5


def test_people_who_take_the_lift_are_waited_for():
    scene = Scene()
    scene.for_seconds(1.0, mode="human", session="attendant")
    scene.request("r", "L1", "L2")
    orders = scene.for_seconds(100.0)
    assert LiftRequest("A", SESSION, "L1") in orders
    assert not any(isinstance(order, Board | Refuse) for order in orders)
    assert Board("r", "A", "L1") in scene.opens_at("L1")


def test_a_robot_in_a_car_that_people_take_rides_on_later():
    scene = Scene()
    scene.inside("r", "L1", "L3")
    orders = scene.for_seconds(30.0, floor="L2", door="open", mode="human", session="")
    assert not any(isinstance(order, Alight) for order in orders)
    assert Alight("r", "A", "L3") in scene.opens_at("L3")


@pytest.mark.parametrize("mode", ["fire", "emergency"])
def test_in_case_of_fire_robots_leave_where_the_doors_open_and_nobody_boards(mode):
    scene = Scene()
    scene.inside("in", "L1", "L3")
    scene.request("out", "L2", "L3")
    orders = scene.for_seconds(3.0, floor="L2", door="open", motion="stopped", mode=mode, session="")
    assert [order for order in orders if isinstance(order, Board | Alight)] == [Alight("in", "A", "L2")]
    assert LiftRequest not in {type(order) for order in orders}
    assert Refuse("out", f"lift 'A' is in the mode {mode!r}") in orders


def test_a_robot_in_the_door_holds_it_open_and_people_are_called():
    scene = Scene()
    scene.request("r", "L1", "L3")
    orders = scene.opens_at("L1", 400.0)
    assert [order for order in orders if isinstance(order, LiftAlert)] == [
        LiftAlert("A", "r", "robot 'r' stands in the door of lift 'A'")
    ]
    assert {order.floor for order in orders[-40:] if isinstance(order, LiftRequest)} == {"L1"}
    assert not any(isinstance(order, EndSession) for order in scene.opens_at("L1", 20.0))


def test_a_robot_that_boards_is_stopped_by_doors_that_close():
    scene = Scene()
    scene.request("r", "L1", "L3")
    scene.opens_at("L1")
    assert Wait("r", "the doors of lift 'A' are not open") in scene.for_seconds(0.5, door="moving")
    assert Board("r", "A", "L1") in scene.opens_at("L1")


def test_a_robot_in_a_car_that_stops_elsewhere_for_good_leaves_there():
    scene = Scene()
    scene.inside("r", "L1", "L3")
    scene.for_seconds(1.0, door="closed", motion="up")
    orders = scene.opens_at("L2", 80.0)
    assert not any(isinstance(order, Alight) for order in orders)
    assert LiftRequest("A", SESSION, "L3") in orders
    assert Alight("r", "A", "L2") in scene.opens_at("L2", 20.0)


def test_a_silent_lift_is_let_go_within_ten_seconds_if_nobody_is_in_it():
    scene = Scene()
    scene.for_seconds(1.0, session=SESSION)
    scene.request("r", "L3", "L1")
    assert EndSession("A", SESSION) in scene.silence(10.0)
    assert Refuse("r", "lift 'A' reports nothing") in scene.silence(2.0)


def test_a_silent_lift_is_asked_further_while_a_robot_is_in_it():
    scene = Scene()
    scene.inside("r", "L1", "L3")
    orders = scene.silence(30.0)
    assert orders.count(LiftRequest("A", SESSION, "L3")) >= 29
    assert EndSession("A", SESSION) not in orders


def test_a_robot_that_is_lost_before_the_lift_leaves_the_queue_within_ten_seconds():
    scene = Scene()
    scene.for_seconds(1.0, session=SESSION)
    scene.request("r", "L3", "L1")
    scene.do("robots_seen", {"r"})
    for _ in range(40):
        scene.now += 0.25
        scene.do("robots_seen", set())
    assert Refuse("r", "robot 'r' is not connected any more") in scene.orders
    assert EndSession("A", SESSION) in scene.orders


def test_a_robot_may_be_silent_in_the_car_for_a_minute():
    scene = Scene()
    scene.inside("r", "L1", "L3")
    for _ in range(60):
        scene.do("robots_seen", set())
        scene.for_seconds(1.0, door="closed", motion="up")
    assert scene.rides["r"].phase == "inside"
    scene.do("robots_seen", {"r"})
    assert Alight("r", "A", "L3") in scene.opens_at("L3")


def test_a_robot_that_dies_in_the_car_is_reported_and_the_lift_let_go():
    scene = Scene()
    scene.inside("r", "L1", "L3")
    for _ in range(100):
        scene.do("robots_seen", set())
        scene.for_seconds(1.0, door="closed", motion="stopped")
    assert any(isinstance(order, LiftAlert) for order in scene.orders)
    assert any(isinstance(order, Refuse) for order in scene.orders)
    assert EndSession("A", SESSION) in scene.orders


@pytest.mark.parametrize("phase", ["waiting", "boarding", "inside", "alighting"])
def test_a_controller_goes_on_from_the_stored_rides(phase):
    scene = Scene()
    scene.request("r", "L1", "L3")
    if phase != "waiting":
        scene.opens_at("L1")
    if phase in ("inside", "alighting"):
        scene.do("entered", "r")
    if phase == "alighting":
        scene.for_seconds(1.0, door="closed", motion="up")
        scene.opens_at("L3")
    assert scene.rides["r"].phase == phase
    again = Scene(rides=scene.rides.values())
    assert again.controller.rides == scene.rides
    at = "L3" if phase in ("inside", "alighting") else "L1"
    expected = Alight("r", "A", "L3") if at == "L3" else Board("r", "A", "L1")
    assert expected in again.opens_at(at)


def test_a_session_that_a_killed_controller_left_is_ended():
    scene = Scene()
    assert EndSession("A", SESSION) in scene.for_seconds(1.0, session=SESSION)


def test_a_cancelled_robot_leaves_the_queue_the_doorway_or_the_car():
    scene = Scene()
    scene.for_seconds(1.0)
    scene.request("r", "L1", "L3")
    assert scene.do("cancel", "r") == [EndSession("A", SESSION)]
    scene.request("r", "L1", "L3")
    scene.opens_at("L1")
    assert Alight("r", "A", "L1") in scene.do("cancel", "r")
    scene.do("left", "r")
    scene.inside("r", "L1", "L3")
    scene.for_seconds(1.0, door="closed", motion="up")
    scene.do("cancel", "r")
    assert Alight("r", "A", "L2") in scene.opens_at("L2")


def test_a_robot_that_is_aboard_may_change_its_destination():
    scene = Scene()
    scene.inside("r", "L1", "L3")
    scene.for_seconds(1.0, floor="L2", door="closed", motion="stopped")
    assert LiftRequest("A", SESSION, "L2") in scene.request("r", "L1", "L2")
    assert Alight("r", "A", "L2") in scene.opens_at("L2")


def test_a_robot_aboard_that_wants_another_lift_leaves_at_the_next_floor():
    scene = Scene()
    scene.inside("r", "L1", "L3")
    assert Alight("r", "A", "L1") in scene.request("r", "L1", "L2", lift="B")


@pytest.mark.parametrize(
    ("lift", "origin", "destination", "size", "text"),
    [
        ("C", "L1", "L2", 1, "lift 'C' has no device that sends it; lifts with one: A, B"),
        ("B", "L1", "L3", 1, "lift 'B' does not stop on floor 'L3'; it stops on L1, L2"),
        ("A", "L1", "L1", 1, "robot 'r' is on floor 'L1' already"),
        ("A", "L1", "L2", 3, "lift 'A' has room for 2 robots, not 3"),
        ("A", "L1", "L2", 0, "lift 'A' has room for 2 robots, not 0"),
    ],
)
def test_a_ride_that_no_lift_can_serve_is_refused(lift, origin, destination, size, text):
    assert Refuse("r", text) in Scene().request("r", origin, destination, size, lift)


def test_a_floor_that_the_lift_does_not_serve_now_is_refused():
    scene = Scene()
    scene.for_seconds(1.0, floors=("L1", "L2"))
    assert any(isinstance(order, Refuse) for order in scene.request("r", "L1", "L3"))


def test_stored_rides_of_a_lift_that_is_no_more_are_refused():
    scene = Scene()
    scene.request("r", "L1", "L3")
    controller = LiftController("b", BUILDING, {}, 0.0, rides=scene.rides.values())
    assert [type(order) for order in controller.tick(1.0)] == [RemoveRide, Refuse]


def test_two_lifts_have_separate_sessions():
    scene = Scene()
    scene.do("lift_state", LiftState(lift="B", floor="L2"))
    scene.request("r", "L1", "L3")
    orders = scene.request("q", "L1", "L2", lift="B")
    assert LiftRequest("B", "ppaas/b/B", "L1") in orders
    assert {ride.lift for ride in scene.controller.rides.values()} == {"A", "B"}


def test_a_queue_makes_the_estimated_wait_longer_and_a_fault_infinite():
    scene = Scene()
    assert math.isinf(scene.controller.estimate("A", "L2", scene.now))
    scene.for_seconds(1.0)
    alone = scene.controller.estimate("A", "L2", scene.now)
    scene.request("r", "L1", "L3")
    assert 0.0 < alone < scene.controller.estimate("A", "L2", scene.now) < math.inf
    scene.for_seconds(1.0, mode="fire")
    assert math.isinf(scene.controller.estimate("A", "L2", scene.now))


def test_waits_are_known_once_a_lift_could_have_reported():
    scene = Scene()
    assert scene.controller.waits(scene.now) == {}
    scene.for_seconds(1.0)
    assert set(scene.controller.waits(scene.now)) == {("A", floor) for floor in FLOORS}
    scene.for_seconds(6.0, floors=("L1", "L2"))
    waits = scene.controller.waits(scene.now)
    assert [math.isinf(waits["A", floor]) for floor in FLOORS] == [False, False, True], "it does not stop there now"
    assert math.isinf(waits["B", "L1"]), "it should have reported by now"


def test_people_who_have_a_lift_make_the_wait_longer():
    scene = Scene()
    scene.for_seconds(1.0)
    free = scene.controller.estimate("A", "L2", scene.now)
    for changes in ({"mode": "human"}, {"mode": "agv", "session": "somebody"}):
        scene.for_seconds(1.0, **changes)
        taken = scene.controller.estimate("A", "L2", scene.now)
        assert taken == free + BUILDING.lift("A").wait


def test_an_old_request_is_served_before_many_newer_ones():
    scene = Scene()
    scene.for_seconds(0.5)
    scene.request("old", "L3", "L1")
    for number in range(40):
        scene.request(f"r{number}", "L1", "L2")
        floor = scene.controller.target("A") or "L1"
        orders = scene.opens_at(floor, 10.0)
        for order in orders:
            if isinstance(order, Board):
                scene.do("entered", order.robot)
            elif isinstance(order, Alight):
                scene.do("left", order.robot)
        if scene.rides.get("old", None) is None or scene.rides["old"].phase != "waiting":
            break
    assert "old" not in scene.rides or scene.rides["old"].phase != "waiting"
    assert scene.now < 100.0 + 300.0


def test_those_who_share_a_car_have_separate_places_and_a_place_that_is_left_is_free_again():
    levels = {"L1": 0.0, "L2": 4.0}
    car = Car(Shaft(levels, LiftSettings(lift="A", robots=4)), "s", 0.0)
    rides = [LiftRide(robot=name, lift="A", origin="L1", destination="L2", phase="inside") for name in "abc"]
    for ride, size in zip(rides, (1, 2, 1), strict=True):
        car.put(replace(ride, size=size, place=car.free_place(size)), 0.0)
    assert [car.rides[name].place for name in "abc"] == [0, 1, 3]
    assert car.free_place(1) == 0, "it is full, and nobody boards"
    car.end("b", 1.0)
    assert (car.free_place(1), car.free_place(2)) == (1, 1)


def test_robots_are_fetched_in_the_order_of_their_requests_if_all_are_old_at_once():
    scene = Scene()
    scene.controller = LiftController("b", BUILDING, {"A": FLOORS}, scene.now, aged=0.0)
    scene.for_seconds(0.5)
    scene.request("first", "L3", "L1")
    scene.for_seconds(0.5)
    for name in ("second", "third"):
        scene.request(name, "L1", "L3")
    scene.for_seconds(0.5)
    assert scene.controller.target("A") == "L3"


@pytest.mark.parametrize("ahead", [0.0, 30.0, 3600.0, -3600.0])
def test_a_waiting_robot_keeps_its_ride_when_another_computer_takes_over(ahead):
    """The clock of the other computer may be apart, and it hears the lift only after a moment."""
    scene = Scene()
    scene.for_seconds(1.0)
    scene.request("first", "L1", "L3")
    scene.now += 5.0
    scene.request("then", "L1", "L2")
    scene.for_seconds(20.0)
    began = scene.now + ahead
    again = Scene(rides=[replace(ride, since=ride.since - began + 100.0) for ride in scene.rides.values()])
    assert not [order for order in again.silence(4.0) if isinstance(order, Refuse)]
    assert list(again.controller.rides) == ["first", "then"]
    orders = again.opens_at("L1")
    assert {order for order in orders if isinstance(order, Board)} >= {Board("first", "A", "L1")}


@pytest.mark.parametrize("ahead", [0.0, 3600.0, -3600.0])
def test_a_lift_that_stays_silent_is_given_up_after_a_takeover_too(ahead):
    scene = Scene()
    scene.for_seconds(1.0)
    scene.request("r", "L1", "L3")
    began = scene.now + ahead
    again = Scene(rides=[replace(ride, since=ride.since - began + 100.0) for ride in scene.rides.values()])
    assert [order for order in again.silence(20.0) if isinstance(order, Refuse)]
