"""Any order of events: robots come, pass, vanish; a door opens, jams, is out of order or silent."""

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from ppaas.buildings.doors.controller import NO_OPENING, NO_RADIO, DoorController
from ppaas.buildings.doors.simulated import SimulatedDoor
from ppaas.buildings.doors.states import DoorRequest, Pass
from ppaas.buildings.lifts.states import Refuse

KEY = ("L1", "main")
ROBOTS = ["a", "b", "c"]
STEP = 0.25


class DoorMachine(RuleBasedStateMachine):
    """Robots at a door."""

    @initialize()
    def start(self):
        self.now = 1000.0
        self.door = SimulatedDoor(*KEY, self.now)
        self.controller = DoorController("b", [KEY])
        self.connected = set(ROBOTS)
        self.asked: dict[str, float] = {}
        self.silent_until = 0.0
        self.reported = self.door.state(self.now)
        self.left_at = self.now

    @rule(robot=st.sampled_from(ROBOTS))
    def approach(self, robot):
        self.asked.setdefault(robot, self.now)
        self.obey(self.controller.approach(robot, *KEY, self.now))

    @rule(robot=st.sampled_from(ROBOTS))
    def pass_or_turn_back(self, robot):
        self.asked.pop(robot, None)
        self.obey(self.controller.passed(robot, *KEY, self.now))

    @rule(robot=st.sampled_from(ROBOTS), here=st.booleans())
    def connect(self, robot, here):
        (self.connected.add if here else self.connected.discard)(robot)

    @rule(fault=st.sampled_from(["", "jammed", "offline"]))
    def set_fault(self, fault):
        self.door.set_fault(fault, self.now)
        self.left_at = self.now  # a door that was repaired takes time to close

    @rule(seconds=st.floats(1.0, 20.0))
    def silence(self, seconds):
        self.silent_until = self.now + seconds

    @rule()
    def kill(self):
        self.controller = DoorController("b", [KEY])
        for robot in self.asked:
            self.obey(self.controller.approach(robot, *KEY, self.now))

    @rule(seconds=st.sampled_from([1.0, 15.0]))
    def go_on(self, seconds):
        end = self.now + seconds
        while self.now < end:
            self.step()

    @rule()
    def robots_that_are_gone_are_forgotten(self):
        self.connected.clear()
        end = self.now + NO_RADIO + NO_OPENING
        while self.now < end:
            self.step()
        assert self.controller.robots_at(KEY) == ()

    def step(self):
        self.now += STEP
        self.obey(self.controller.robots_seen(self.connected, self.now))
        if self.now >= self.silent_until:
            self.reported = self.door.state(self.now)
            self.obey(self.controller.door_state(self.reported, self.now))
        if self.controller.robots_at(KEY):
            self.left_at = self.now

    def obey(self, orders):
        for order in orders:
            match order:
                case DoorRequest():
                    self.door.request(order, self.now)
                case Pass():
                    assert self.reported.mode == "open"
                case Refuse(robot):
                    self.asked.pop(robot, None)

    @invariant()
    def a_door_that_nobody_needs_closes(self):
        if hasattr(self, "controller") and self.now - self.left_at > 15.0:
            assert self.door.state(self.now).mode in ("closed", "offline") or self.door._fault

    @invariant()
    def robots_are_those_that_asked(self):
        if hasattr(self, "controller"):
            assert set(self.controller.robots_at(KEY)) == set(self.asked)


TestDoors = DoorMachine.TestCase
TestDoors.settings = settings(max_examples=25, stateful_step_count=25, deadline=None)
