"""Journeys over floors: from leg to leg, and what goes wrong on the way."""

import dataclasses
import math
import random
from dataclasses import dataclass, field

import pytest
from msgspec.structs import replace

from ppaas.buildings.building import Building, Floor, LiftSettings
from ppaas.buildings.doors.states import Pass
from ppaas.buildings.journeys.journey import MOST_PLANS, NEAR_LIFT, TRIES, JourneyMachine
from ppaas.buildings.journeys.records import (
    AskForDoor,
    AskForLift,
    CancelGoal,
    CancelRide,
    ChangeFloor,
    DoorPassed,
    EnteredCar,
    FindLegs,
    Journey,
    JourneyLeg,
    JourneyOrder,
    Keep,
    LeftCar,
    LookForFloor,
    SendGoal,
)
from ppaas.buildings.layout import BuildingLayout, layout_of
from ppaas.buildings.lifts.controller import LiftController
from ppaas.buildings.lifts.simulated import LiftModel, SimulatedLift
from ppaas.buildings.lifts.states import (
    Alight,
    Board,
    EndSession,
    LiftRequest,
    LiftRide,
    Refuse,
    RemoveRide,
    StoreRide,
    Wait,
)
from ppaas.tasks.records import Place
from ppaas.zones.shapes import LineString, Polygon
from ppaas.zones.zone import Door, LiftCar, Zone, ZoneSet

LEVELS = {"L1": 0.0, "L2": 4.0, "L3": 8.0}
SHIFT = {"L1": 0.0, "L2": 10.0, "L3": 20.0}
"""x of the frame of the building on each map [m]."""

GOAL: Place = (28.0, 5.0, 0.0)


def building_layout() -> BuildingLayout:
    floors = tuple(
        Floor(name=name, map=f"map-{name}", elevation=level, anchor=(-SHIFT[name], 0.0, 0.0))
        for name, level in LEVELS.items()
    )
    zones = {}
    for name, x in SHIFT.items():
        ring = [[x, 0.0], [x + 2.0, 0.0], [x + 2.0, 2.0], [x, 2.0], [x, 0.0]]
        zones[name] = ZoneSet(
            [
                Zone(Polygon([ring]), LiftCar(name="car", lift="north")),
                Zone(LineString([[x + 0.5, 2.1], [x + 1.5, 2.1]]), Door(name="landing", lift="north")),
            ]
        )
    return layout_of(Building(floors=floors, lifts=(LiftSettings(lift="north", device="sim:"),)), zones)


LAYOUT = building_layout()


def wait_at(floor: str) -> Place:
    return SHIFT[floor] + 1.0, 3.0, -math.pi / 2


def out_at(floor: str) -> Place:
    return SHIFT[floor] + 1.0, 3.0, math.pi / 2


def legs_from(floor: str, to: str = "L3") -> list[JourneyLeg]:
    """Return the legs of a plan from a place on a floor, by the lift unless it is the floor of the goal."""
    last = JourneyLeg(kind="drive", floor=to, to_floor=to, start=out_at(to), goal=GOAL)
    if floor == to:
        return [last]
    return [
        JourneyLeg(kind="drive", floor=floor, to_floor=floor, start=out_at(floor), goal=wait_at(floor)),
        JourneyLeg(kind="lift", floor=floor, to_floor=to, start=wait_at(floor), goal=out_at(to), name="north"),
        last,
    ]


def begun(**fields: object) -> JourneyMachine:
    journey = Journey(id="j1", user="ann", robot="tb1", building="hotel", floor="L3", goal=GOAL, on="L1")
    machine = JourneyMachine(journey, LAYOUT)
    assert machine.resume() == [Keep(journey), FindLegs(0)]
    machine.planned(0, legs_from("L1"), 1.0)
    return machine


def goals(orders: list[JourneyOrder]) -> list[SendGoal]:
    return [order for order in orders if isinstance(order, SendGoal)]


def reach(machine: JourneyMachine) -> list[JourneyOrder]:
    return machine.goal_ended(machine.journey.goal_id, True, "", 2.0)


def aboard() -> JourneyMachine:
    """Return a journey whose robot is in the car."""
    machine = begun()
    assert reach(machine)[-1] == AskForLift("north", "L1", "L3")
    [_, sent] = machine.obey(Board("tb1", "north", "L1"), 3.0)
    assert sent == SendGoal("j1/2", LAYOUT.landings["north"][0].car)
    assert reach(machine)[-1] == EnteredCar()
    return machine


def test_a_journey_goes_from_leg_to_leg_and_stores_each_step_first() -> None:
    machine = aboard()
    assert machine.seen_at("L1", (1.2, 0.9, math.pi / 2), 3.5) == []
    [change] = machine.doors_closed("L3")
    assert isinstance(change, ChangeFloor) and change.floor == "L3"
    assert change.pose == pytest.approx((21.2, 0.9, math.pi / 2)), "the same place in the car"
    machine.on_floor("L3")
    assert machine.doors_closed("L3") == []
    [kept, sent, look] = machine.obey(Alight("tb1", "north", "L3"), 5.0)
    assert isinstance(kept, Keep) and sent == SendGoal("j1/3", out_at("L3")) and look == LookForFloor()
    assert machine.looked("L3", True, 1.0, out_at("L3"), 5.2) == [Keep(machine.journey)]
    assert machine.obey(Alight("tb1", "north", "L3"), 5.1) == [], "repeated by the controller"
    left, kept, sent = reach(machine)
    assert (left, sent) == (LeftCar(), SendGoal("j1/4", GOAL))
    assert goals([sent])
    assert reach(machine) == [Keep(machine.journey)]
    assert (machine.journey.state, machine.journey.on, machine.is_over) == ("succeeded", "L3", True)
    assert reach(machine) == machine.cancel(9.0) == machine.resume() == []


def test_a_robot_whose_clone_is_not_there_yet_leaves_once_it_is() -> None:
    machine = aboard()
    [_, change] = machine.obey(Alight("tb1", "north", "L3"), 5.0)
    assert isinstance(change, ChangeFloor)
    again = JourneyMachine(machine.journey, LAYOUT).resume()
    assert again == [AskForLift("north", "L1", "L3"), EnteredCar(), change], "a restart repeats all that may be lost"
    assert goals(machine.on_floor("L3")) == [SendGoal("j1/3", out_at("L3"))]


def test_a_robot_asks_for_the_lift_as_it_nears_it_and_drives_on() -> None:
    machine = begun()
    x, y, _ = wait_at("L1")
    assert machine.seen_at("L1", (x + NEAR_LIFT + 0.1, y, 0.0), 1.5) == []
    assert machine.seen_at("L2", (x, y, 0.0), 1.5) == [], "its clone is on the map of another floor"
    orders = machine.seen_at("L1", (x + NEAR_LIFT - 0.1, y, 0.0), 1.6)
    assert orders == [Keep(machine.journey), AskForLift("north", "L1", "L3")], "nothing is cancelled"
    assert reach(machine) == [] and machine.journey.phase == "waiting"
    assert machine.seen_at("L1", wait_at("L1"), 2.0) == []
    assert goals(machine.obey(Board("tb1", "north", "L1"), 3.0))


def test_a_robot_that_is_clear_of_the_doors_makes_way_and_drives_on() -> None:
    machine = begun()
    reach(machine)
    machine.obey(Board("tb1", "north", "L1"), 3.0)
    assert machine.seen_at("L1", (1.0, 1.7, -1.6), 3.2) == [], "it is in the doorway"
    assert machine.seen_at("L1", (1.0, 1.4, -1.6), 3.4) == [Keep(machine.journey), EnteredCar()]
    assert machine.doors_closed("L3") == [], "its clone goes on once it stands"
    reach(machine)
    assert machine.doors_closed("L3")
    machine.on_floor("L3")
    machine.obey(Alight("tb1", "north", "L3"), 5.0)
    assert machine.seen_at("L3", (21.0, 2.8, 1.6), 5.1) == [], "its scans are still compared"
    machine.looked("L3", True, 1.0, (21.0, 2.4, 1.6), 5.1)
    assert machine.seen_at("L3", (21.0, 2.5, 1.6), 5.2) == []
    left, kept, sent = machine.seen_at("L3", (21.0, 2.8, 1.6), 5.4)
    assert (left, kept, sent) == (LeftCar(), Keep(machine.journey), SendGoal("j1/4", GOAL))


def test_a_robot_that_has_not_reached_its_place_leaves_all_the_same() -> None:
    machine = begun()
    reach(machine)
    machine.obey(Board("tb1", "north", "L1"), 3.0)
    machine.seen_at("L1", (1.0, 1.4, -1.6), 3.4)
    cancelled, _, change = machine.obey(Alight("tb1", "north", "L3"), 5.0)
    assert cancelled == CancelGoal("j1/2") and isinstance(change, ChangeFloor)
    assert change.pose == pytest.approx((21.0, 1.4, -1.6))


def test_robots_that_share_a_car_are_on_the_map_of_the_floor_where_it_stops_next() -> None:
    machine = aboard()
    [change] = machine.doors_closed("L2")
    assert isinstance(change, ChangeFloor) and change.floor == "L2", "others leave there"
    machine.on_floor("L2")
    assert machine.doors_closed("L2") == []
    [change] = machine.doors_closed("L3")
    assert isinstance(change, ChangeFloor) and change.floor == "L3"
    machine.on_floor("L3")
    assert goals(machine.obey(Alight("tb1", "north", "L3"), 5.0)) == [SendGoal("j1/3", out_at("L3"))]


def test_robots_that_share_a_car_have_separate_places() -> None:
    building = replace(LAYOUT.building, lifts=(LiftSettings(lift="north", robots=2),))
    machines = [JourneyMachine(begun().journey, dataclasses.replace(LAYOUT, building=building)) for _ in range(2)]
    poses = []
    for place, machine in enumerate(machines):
        reach(machine)
        [sent] = goals(machine.obey(Board("tb1", "north", "L1", place), 3.0))
        poses.append(sent.pose)
        assert JourneyMachine(machine.journey, machine._layout).resume()[-1] == sent
    assert math.dist(poses[0][:2], poses[1][:2]) == pytest.approx(1.0)


def test_a_robot_on_its_way_to_a_lift_that_breaks_takes_another_way_at_once() -> None:
    machine = begun()
    assert machine.lift_lost("south", "out of order", 2.0) == []
    assert machine.lift_lost("north", "out of order", 2.0) == [CancelGoal("j1/1"), Keep(machine.journey), FindLegs(1)]
    assert machine.journey.avoid == ("north",)
    assert machine.goal_ended("j1/1", False, "cancelled", 2.1) == []
    assert machine.journey.goal_id != "j1/1", "the end of that goal is not taken for an end of the journey"
    machine.no_plan(1, "no way", 2.2)
    assert goals(machine.planned(2, legs_from("L1"), 2.3))
    assert machine.lift_lost("north", "out of order", 2.4) == [], "there is no other way: it waits there"


def test_a_lift_that_stops_on_another_floor_lets_it_out_there_and_the_rest_is_planned_again() -> None:
    machine = aboard()
    machine.doors_closed("L3")
    machine.on_floor("L3")
    [_, change] = machine.obey(Alight("tb1", "north", "L2"), 5.0)
    assert isinstance(change, ChangeFloor) and change.pose == pytest.approx((11.0, 1.0, math.pi / 2))
    assert goals(machine.on_floor("L2")) == [SendGoal("j1/3", pytest.approx(out_at("L2")))]
    machine.looked("L2", False, 0.95, out_at("L2"), 5.5)
    left, _, find = reach(machine)
    assert (left, find) == (LeftCar(), FindLegs(1))
    assert machine.planned(0, legs_from("L1"), 6.0) == [], "an earlier plan is too late"
    assert goals(machine.planned(1, legs_from("L2"), 6.0)) == [SendGoal("j1/4", wait_at("L2"))]


def test_a_lift_that_refuses_is_avoided_and_tried_again_only_if_there_is_no_other_way() -> None:
    machine = begun()
    reach(machine)
    assert machine.obey(Refuse("tb1", "out of order"), 3.0)[-1] == FindLegs(1)
    assert machine.journey.avoid == ("north",)
    assert machine.no_plan(1, "no way", 4.0)[-1] == FindLegs(2) and machine.journey.avoid == ()
    machine.no_plan(2, "no way", 5.0)
    assert (machine.journey.state, machine.journey.text) == ("failed", "no way")


def test_a_building_that_refuses_again_and_again_ends_the_journey() -> None:
    machine = begun()
    for number in range(1, MOST_PLANS + 1):
        if machine.is_over:
            break
        reach(machine)
        machine.obey(Refuse("tb1", "fire"), 3.0)
        machine.planned(number, legs_from("L1"), 4.0)
    assert (machine.journey.state, machine.journey.text) == ("failed", "fire")


def test_goals_that_fail_are_sent_again_and_a_robot_in_a_doorway_is_led_out_first() -> None:
    machine = begun()
    reach(machine)
    machine.obey(Board("tb1", "north", "L1"), 3.0)
    for _ in range(TRIES - 1):
        assert goals(machine.goal_ended(machine.journey.goal_id, False, "blocked", 4.0))
    orders = machine.goal_ended(machine.journey.goal_id, False, "blocked", 4.0)
    assert orders[-1] == CancelRide() and machine.journey.phase == "boarding"
    assert goals(machine.obey(Alight("tb1", "north", "L1"), 5.0)) == [SendGoal(machine.journey.goal_id, out_at("L1"))]
    assert reach(machine)[-1] == FindLegs(1) and machine.journey.avoid == ("north",)


def test_a_robot_that_cannot_leave_a_car_goes_on_to_try() -> None:
    machine = aboard()
    machine.doors_closed("L3")
    machine.on_floor("L3")
    machine.obey(Alight("tb1", "north", "L3"), 5.0)
    ids = {machine.journey.goal_id}
    for _ in range(3 * TRIES):
        [sent] = goals(machine.goal_ended(machine.journey.goal_id, False, "blocked", 6.0))
        ids.add(sent.id)
    assert len(ids) == 3 * TRIES + 1


def test_a_journey_that_is_cancelled_in_a_lift_ends_outside() -> None:
    machine = aboard()
    assert machine.cancel(5.0)[-1] == CancelRide()
    assert not machine.is_over and machine.cancel(5.1) == []
    machine.obey(Alight("tb1", "north", "L2"), 6.0)
    machine.on_floor("L2")
    assert reach(machine)[0] == LeftCar()
    assert (machine.journey.state, machine.journey.on) == ("canceled", "L2")
    waiting = begun()
    reach(waiting)
    assert waiting.cancel(5.0)[:2] == [CancelGoal("j1/1"), CancelRide()] and waiting.is_over
    driving = begun()
    assert driving.cancel(5.0)[0] == CancelGoal("j1/1") and driving.is_over


def test_doors_and_ways_are_legs_too() -> None:
    door = JourneyLeg(kind="door", floor="L1", to_floor="L1", start=(3.0, 3.0, 0.0), goal=(5.0, 3.0, 0.0), name="glass")
    ramp = JourneyLeg(
        kind="way", floor="L1", to_floor="L2", start=(8.0, 3.0, 0.0), goal=(18.0, 3.0, 0.0), length=4.0, name="ramp"
    )
    machine = begun()
    machine.journey = Journey(id="j2", user="ann", robot="tb1", building="hotel", floor="L2", goal=GOAL, on="L1")
    assert machine.planned(0, [door, ramp], 1.0)[-1] == AskForDoor("L1", "glass")
    assert goals(machine.obey(Pass("tb1", "L1", "glass"), 2.0)) == [SendGoal("j2/1", (5.0, 3.0, 0.0))]
    passed, _, change = reach(machine)
    assert passed == DoorPassed("L1", "glass")
    assert change == ChangeFloor("L2", (14.0, 3.0, 0.0)), "at the beginning of the ramp, on the map of its other end"
    assert goals(machine.on_floor("L2")) == [SendGoal("j2/2", (18.0, 3.0, 0.0))]
    reach(machine)
    assert machine.journey.state == "succeeded"


# -- with a lift, and restarts at any time -----------------------------------------------------------------------------


@dataclass
class Site:
    """A robot, a simulated lift with its controller, and the store, all of which are restarted at random."""

    seed: int
    now: float = 0.0
    stored: Journey | None = None
    rides: dict[str, LiftRide] = field(default_factory=dict)
    sent: dict[str, tuple[Place, float]] = field(default_factory=dict)
    done: set[str] = field(default_factory=set)
    floor: str = "L1"
    """Floor on whose map the clone is."""

    car: str = ""
    """Floor at which the robot boarded, while it is in the car."""

    restarts: int = 0
    looks_at: float = math.inf
    """Time at which the scans of the robot have been compared with the maps."""

    def __post_init__(self) -> None:
        self.random = random.Random(self.seed)
        self.lift = SimulatedLift("north", LEVELS, 0.0, LiftModel(wrong_floor=0.3, seed=self.seed))
        first = Journey(id="j1", user="ann", robot="tb1", building="hotel", floor="L3", goal=GOAL, on="L1")
        self.stored = first
        self.restart()

    def restart(self) -> None:
        """Begin with what is stored alone."""
        assert self.stored is not None
        self.controller = LiftController(
            "hotel", LAYOUT.building, {"north": list(LEVELS)}, self.now, rides=self.rides.values()
        )
        self.machine = JourneyMachine(self.stored, LAYOUT)
        self.obey(self.machine.resume())

    def obey(self, orders: list[JourneyOrder]) -> None:
        for order in orders:
            if self.random.random() < 0.01:
                self.restarts += 1
                self.restart()  # killed between two orders
                return
            self.obey_one(order)

    def obey_one(self, order: JourneyOrder) -> None:
        match order:
            case Keep(journey):
                self.stored = journey
            case SendGoal(name, pose):
                self.sent.setdefault(name, (pose, self.now + 2.0))
            case CancelGoal(name):
                self.done.add(name)
            case FindLegs(number):
                self.obey(self.machine.planned(number, legs_from(self.machine.journey.on), self.now))
            case ChangeFloor(floor, _):
                self.floor = floor
            case LookForFloor():
                self.looks_at = self.now + self.random.uniform(0.0, 4.0)
            case _:
                self.ask(order)

    def ask(self, order: JourneyOrder) -> None:
        match order:
            case AskForLift(lift, origin, destination):
                self.lead(self.controller.request("tb1", lift, origin, destination, self.now))
            case EnteredCar():
                self.lead(self.controller.entered("tb1", self.now))
            case LeftCar():
                self.lead(self.controller.left("tb1", self.now))
            case CancelRide():
                self.lead(self.controller.cancel("tb1", self.now))

    def lead(self, orders: list[object]) -> None:
        for order in orders:
            match order:
                case LiftRequest():
                    self.lift.request(order, self.now)
                case EndSession():
                    self.lift.end(order, self.now)
                case StoreRide(ride):
                    self.rides[ride.robot] = ride
                case RemoveRide(robot):
                    self.rides.pop(robot, None)
                case Board() | Alight() | Wait() | Refuse():
                    self.obey(self.machine.obey(order, self.now))

    def step(self) -> None:
        self.now += 0.5
        state = self.lift.state(self.now)
        self.lead(self.controller.lift_state(state, self.now))
        self.lead(self.controller.robots_seen({"tb1"}, self.now))
        if state.door == "closed":
            self.obey(self.machine.doors_closed(self.controller.target("north")))
        if self.floor != self.machine.journey.on:
            self.obey(self.machine.on_floor(self.floor))
        if self.now >= self.looks_at:
            self.looks_at = math.inf
            self.obey(self.machine.looked(self.floor, True, 1.0, out_at(self.floor), self.now))
        for name, (pose, due) in tuple(self.sent.items()):
            if name not in self.done and self.now >= due and name == self.machine.journey.goal_id:
                self.done.add(name)
                self.drive(pose)
                self.obey(self.machine.goal_ended(name, True, "", self.now))
            elif name in self.done and name == self.machine.journey.goal_id:  # reported again after a restart
                self.obey(self.machine.goal_ended(name, True, "", self.now))
        if self.random.random() < 0.02:
            self.restarts += 1
            self.restart()

    def drive(self, pose: Place) -> None:
        """Check that the robot enters and leaves the car only where that stands open."""
        landings = {each.car: each.floor for each in LAYOUT.landings["north"]}
        state = self.lift.state(self.now)
        if pose in landings:
            assert (state.floor, state.door) == (landings[pose], "open")
            self.car = landings[pose]
        elif self.car:
            assert (state.floor, state.door) == (self.floor, "open"), "it leaves on the map of the floor where it is"
            self.car = ""


@pytest.mark.parametrize("seed", range(12))
def test_a_journey_arrives_whatever_is_restarted_and_wherever_the_lift_stops(seed: int) -> None:
    site = Site(seed)
    while not site.machine.is_over and site.now < 3600.0:
        site.step()
    assert (site.machine.journey.state, site.machine.journey.on, site.floor) == ("succeeded", "L3", "L3")
    assert site.rides == {} and site.car == ""


def test_restarts_happen_in_these_tests() -> None:
    sites = [Site(seed) for seed in range(4)]
    for site in sites:
        while not site.machine.is_over and site.now < 3600.0:
            site.step()
    assert sum(site.restarts for site in sites) >= 4
