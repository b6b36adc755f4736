"""Any order of events: robots come, cancel, vanish; a lift obeys, is taken, falls silent, flaps, stops elsewhere."""

import math

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule
from msgspec.structs import replace

from ppaas.buildings.building import Building, Floor, LiftSettings
from ppaas.buildings.lifts.attendant import NO_RADIO, PATIENCE
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
)

FLOORS = ("L1", "L2", "L3")
ROBOTS = [f"r{number}" for number in range(6)]
CAPACITY = 2
BUILDING = Building(
    floors=tuple(Floor(name=name, map=name, elevation=3.0 * number) for number, name in enumerate(FLOORS)),
    lifts=(LiftSettings(lift="A", robots=CAPACITY),),
)
STEP = 0.25
PASSAGE = 3.0
"""Time that a robot takes through the doors [s]."""


class LiftsMachine(RuleBasedStateMachine):
    """Robots that obey, and a lift that may not."""

    @initialize(seed=st.integers(0, 1000), wrong=st.sampled_from([0.0, 0.5]))
    def start(self, seed, wrong):
        self.now = 1000.0
        levels = {floor.name: floor.elevation for floor in BUILDING.floors}
        self.lift = SimulatedLift("A", levels, self.now, LiftModel(seed=seed, wrong_floor=wrong))
        self.stored: dict[str, LiftRide] = {}
        self.robots = set(ROBOTS)
        self.moving: dict[str, tuple[float, Board | Alight]] = {}
        self.inside: set[str] = set()
        self.silent_until = self.flaps_until = self.lobby_taken_until = 0.0
        self.idle_since = self.now
        self.reported = self.lift.state(self.now)
        self.controller = self.restored()

    def restored(self):
        may_leave = lambda _lift, floor: self.now >= self.lobby_taken_until or floor != "L2"  # noqa: E731
        return LiftController("b", BUILDING, {"A": FLOORS}, self.now, rides=self.stored.values(), may_leave=may_leave)

    # -- rules -------------------------------------------------------------------------------------------------------

    @rule(robot=st.sampled_from(ROBOTS), way=st.permutations(FLOORS), size=st.integers(1, CAPACITY))
    def request(self, robot, way, size):
        if robot in self.robots and robot not in self.moving:
            self.obey(self.controller.request(robot, "A", way[0], way[1], self.now, size=size))

    @rule(robot=st.sampled_from(ROBOTS))
    def cancel(self, robot):
        self.obey(self.controller.cancel(robot, self.now))

    @rule(robot=st.sampled_from(ROBOTS))
    def lose(self, robot):
        self.robots.discard(robot)

    @rule(robot=st.sampled_from(ROBOTS))
    def find(self, robot):
        self.robots.add(robot)

    @rule(seconds=st.floats(1.0, 20.0))
    def silence(self, seconds):
        self.silent_until = self.now + seconds

    @rule(seconds=st.floats(1.0, 10.0))
    def flap(self, seconds):
        self.flaps_until = self.now + seconds

    @rule(seconds=st.floats(1.0, 60.0))
    def fill_lobby(self, seconds):
        self.lobby_taken_until = self.now + seconds

    @rule(mode=st.sampled_from(["agv", "human", "fire", "offline", "emergency"]))
    def change_mode(self, mode):
        self.lift.set_mode(mode, self.now)

    @rule()
    def kill(self):
        self.controller = self.restored()

    @rule(seconds=st.sampled_from([1.0, 10.0, 60.0]))
    def go_on(self, seconds):
        end = self.now + seconds
        while self.now < end:
            self.step()

    @precondition(lambda self: self.stored)
    @rule()
    def every_request_ends(self):
        """With a lift that works, and robots that obey or are gone, no ride is left."""
        self.lift.set_mode("agv", self.now)
        end = self.now + PATIENCE + NO_RADIO + 60.0
        while self.stored and self.now < end:
            self.step()
        assert not self.stored

    # -- the world ---------------------------------------------------------------------------------------------------

    def step(self):
        self.now += STEP
        self.obey(self.controller.robots_seen(self.robots, self.now))
        for robot, (until, order) in tuple(self.moving.items()):
            if robot in self.robots and self.now >= until:
                del self.moving[robot]
                is_in = isinstance(order, Board)
                (self.inside.add if is_in else self.inside.discard)(robot)
                arrived = self.controller.entered if is_in else self.controller.left
                self.obey(arrived(robot, self.now))
        if self.now >= self.silent_until:
            self.reported = self.lift.state(self.now)
            if self.now < self.flaps_until and int(self.now / STEP) % 2:
                self.reported = replace(self.reported, door="moving")
            self.obey(self.controller.lift_state(self.reported, self.now))
        if self.stored or not self.lift.state(self.now).session:
            self.idle_since = self.now

    def obey(self, orders):
        for order in orders:
            match order:
                case LiftRequest():
                    self.lift.request(order, self.now)
                case EndSession():
                    self.lift.end(order, self.now)
                case StoreRide(ride):
                    self.stored[ride.robot] = ride
                case RemoveRide(robot) | Refuse(robot):
                    if isinstance(order, RemoveRide):
                        del self.stored[robot]
                    self.inside.discard(robot)
                    self.moving.pop(robot, None)
                case Board() | Alight():
                    assert (self.reported.door, self.reported.motion) == ("open", "stopped"), order
                    assert self.reported.floor == order.floor
                    if isinstance(order, Board):
                        assert self.reported.mode == "agv" and self.reported.session
                        assert order.floor == self.stored[order.robot].origin
                    self.moving[order.robot] = (self.now + PASSAGE, order)

    # -- invariants --------------------------------------------------------------------------------------------------

    @invariant()
    def never_over_capacity(self):
        if hasattr(self, "controller"):
            assert sum(ride.size for ride in self.stored.values() if ride.is_aboard) <= CAPACITY

    @invariant()
    def no_session_is_left(self):
        if hasattr(self, "controller"):
            assert self.now - self.idle_since <= 10.0

    @invariant()
    def what_is_stored_is_what_is_known(self):
        if hasattr(self, "controller"):
            assert self.controller.rides == self.stored
            assert not math.isnan(self.controller.estimate("A", "L1", self.now))


TestLifts = LiftsMachine.TestCase
TestLifts.settings = settings(max_examples=25, stateful_step_count=25, deadline=None)
