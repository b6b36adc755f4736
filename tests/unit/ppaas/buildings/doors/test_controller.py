import pytest

from ppaas.buildings.doors.controller import DoorController
from ppaas.buildings.doors.simulated import SimulatedDoor
from ppaas.buildings.doors.states import DoorAlert, DoorRequest, Pass
from ppaas.buildings.lifts.states import Refuse, Wait

OPEN = DoorRequest("L1", "main", "ppaas/b/L1/main", "open")
CLOSED = DoorRequest("L1", "main", "ppaas/b/L1/main", "closed")


class Scene:
    def __init__(self):
        self.now = 100.0
        self.door = SimulatedDoor("L1", "main", self.now)
        self.controller = DoorController("b", [("L1", "main")])
        self.robots = {"r", "q"}

    def obey(self, orders):
        for order in orders:
            if isinstance(order, DoorRequest):
                self.door.request(order, self.now)
        return orders

    def for_seconds(self, seconds, *, silent=False):
        orders = []
        for _ in range(round(seconds * 4)):
            self.now += 0.25
            orders += self.obey(self.controller.robots_seen(self.robots, self.now))
            if not silent:
                orders += self.obey(self.controller.door_state(self.door.state(self.now), self.now))
        return orders

    def approach(self, robot="r"):
        return self.obey(self.controller.approach(robot, "L1", "main", self.now))


def test_a_door_is_opened_held_and_left_to_close():
    scene = Scene()
    assert OPEN in scene.approach()
    assert Pass("r", "L1", "main") in scene.for_seconds(5.0)
    orders = scene.for_seconds(20.0)
    assert orders.count(OPEN) == 20
    assert scene.door.state(scene.now).mode == "open"
    assert scene.controller.passed("r", "L1", "main", scene.now) == [CLOSED]
    scene.obey([CLOSED])
    assert scene.for_seconds(5.0) == []
    assert scene.door.state(scene.now).mode == "closed"


def test_a_door_that_no_robot_needs_gets_no_order():
    scene = Scene()
    assert scene.for_seconds(3.0) == []
    assert scene.controller.fault(("L1", "main"), scene.now) == ""
    scene.door.set_fault("offline", scene.now)
    scene.for_seconds(1.0)
    assert scene.controller.fault(("L1", "main"), scene.now) == "door 'main' of floor 'L1' is offline"


def test_a_door_stays_open_for_the_next_robot():
    scene = Scene()
    scene.approach("r")
    scene.for_seconds(5.0)
    assert Pass("q", "L1", "main") in scene.approach("q")
    assert CLOSED not in scene.controller.passed("r", "L1", "main", scene.now)
    assert scene.controller.robots_at(("L1", "main")) == ("q",)


def test_a_door_without_a_device_is_passed_as_it_is():
    assert DoorController("b", []).approach("r", "L1", "any", 0.0) == [Pass("r", "L1", "any")]


@pytest.mark.parametrize(
    ("fault", "text"),
    [("jammed", "door 'main' of floor 'L1' does not open"), ("offline", "door 'main' of floor 'L1' is offline")],
)
def test_a_door_that_does_not_open_is_refused_and_reported(fault, text):
    scene = Scene()
    scene.door.set_fault(fault, scene.now)
    scene.approach()
    orders = scene.for_seconds(35.0)
    assert Refuse("r", text) in orders
    assert DoorAlert("L1", "main", "r", text) in orders
    assert CLOSED in orders


def test_a_silent_door_is_refused():
    scene = Scene()
    assert Wait("r", "door 'main' of floor 'L1' reports nothing") in scene.approach()
    assert any(isinstance(order, Refuse) for order in scene.for_seconds(35.0, silent=True))


def test_a_robot_that_is_lost_before_a_door_lets_it_close():
    scene = Scene()
    scene.door.set_fault("jammed", scene.now)
    scene.approach()
    scene.robots.clear()
    assert CLOSED in scene.for_seconds(10.0)


def test_a_robot_in_a_doorway_holds_it_and_is_reported():
    scene = Scene()
    scene.approach()
    orders = scene.for_seconds(60.0)
    assert [order for order in orders if isinstance(order, DoorAlert)] == [
        DoorAlert("L1", "main", "r", "robot 'r' stands in door 'main'")
    ]
    scene.robots.clear()
    assert OPEN in scene.for_seconds(60.0)
    assert CLOSED in scene.for_seconds(60.0)


def test_a_robot_that_asks_again_is_ordered_again():
    scene = Scene()
    scene.approach()
    scene.for_seconds(5.0)
    assert Pass("r", "L1", "main") in scene.approach()


def test_a_held_door_closes_by_itself_without_requests():
    scene = Scene()
    scene.door.request(OPEN, scene.now)
    assert scene.door.state(scene.now + 5.0).mode == "open"
    assert scene.door.state(scene.now + 12.0).mode == "moving"
    assert scene.door.state(scene.now + 14.0).mode == "closed"
