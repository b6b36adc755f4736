"""State machine of docking: a unicycle, a charger with contacts, and what goes wrong with them."""

import math
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
import pytest

from ppaas.controllers.base import Velocity
from ppaas.docking.approach import BodyOutline
from ppaas.docking.charge import CHARGING, ChargeReading
from ppaas.docking.detection.base import NO_POINTS, DockDetector, DockView
from ppaas.docking.dock import MappedDock
from ppaas.docking.docking import Docking, DockingPhase
from ppaas.docking.failures import (
    BatterySilent,
    ChargerLies,
    ContactWithoutCharge,
    DockingFailure,
    DockLost,
    DockNotReached,
    DockNotSeen,
    NotStaged,
)
from ppaas.docking.orders import Docked, DriveTo, Order, Sight
from ppaas.docking.parameters import DockingParameters, DockType
from ppaas.docking.targets import DockTarget
from ppaas.geometry import Pose2D
from robots.sim.docks.charger import Charger, ChargerFault, ChargerModel

BODY = BodyOutline(0.2, 0.2, 0.2)
HOME = Pose2D(3.0, 2.0, 0.5)
DT = 0.05


class TrueFace(DockDetector):
    """Sees the true face of a dock, as long as it may."""

    name: ClassVar[str] = "true"
    purpose: ClassVar[str] = "the truth"

    def __init__(self) -> None:
        self.face: Pose2D | None = None

    def detect(self, view: DockView, expected: Pose2D) -> Pose2D | None:
        """Return it."""
        return self.face


@dataclass
class Loop:
    """A robot in a closed loop with the machine; ``map`` is where the map has the dock, ``true`` where it is."""

    true: Pose2D = HOME
    kind: DockType = field(default_factory=DockType)
    parameters: DockingParameters = field(default_factory=DockingParameters)
    fault: ChargerFault = ChargerFault.NOTHING
    model: ChargerModel = field(default_factory=ChargerModel)
    charges: bool = True
    battery: bool = True
    seen_from: float = 0.0
    others: tuple[DockTarget, ...] = ()
    navigate: bool = True

    def __post_init__(self) -> None:
        self.now, self.robot, self.detector = 0.0, Pose2D(0.0, 0.0), TrueFace()
        stance = self.kind.stance(BODY)
        self.charger = Charger(self.true, 0.2, self.model, self.fault)
        self.place = MappedDock("home", HOME, charges=self.charges)
        self.target = DockTarget(self.place, self.kind, self.detector, stance)
        self.machine = Docking(
            [self.target, *self.others], self.parameters, BODY, braking=1.0, now=0.0, navigate=self.navigate,
            staging_time=100.0,
        )  # fmt: skip
        self.points, self.held, self.lasers, self.phases = NO_POINTS, "", 0, [self.machine.phase]
        self.staged: list[Pose2D] = []
        self.drift = Pose2D(5.0, -3.0, 1.0)
        """Frame of the map in that of the odometry."""

    def step(self) -> Order:
        """Simulate one cycle."""
        self.now += DT
        stance = self.kind.stance(BODY)
        far = self.robot.distance_to(self.true) >= self.seen_from
        self.detector.face = self.robot.inverse() @ stance.face_of(self.true) if far else None
        view = DockView(self.points)
        order = self.machine.step(Sight(self.now, self.drift @ self.robot, self.drift, view, self.held))
        if isinstance(order, DriveTo):
            self.staged.append(order.pose)
            self.robot = order.pose @ Pose2D(0.02, 0.05, -0.1)
            self.machine.staged("", self.now)
        elif isinstance(order, Velocity):
            self._drive(order)
        if self.machine.phase is not self.phases[-1]:
            self.phases.append(self.machine.phase)
        return order

    def _drive(self, velocity: Velocity) -> None:
        moved = self.robot @ Pose2D(velocity.linear * DT, 0.0, velocity.angular * DT)
        ahead = self.kind.stance(BODY).ahead
        if ahead * (self.true.inverse() @ moved).x <= 0.003:  # the dock is solid
            self.robot = moved
        if self.battery and round(self.now / DT) % 10 == 0:
            flow = self.charger.current(self.robot) - 0.9
            status = CHARGING if self.charger.reports_charging(self.robot) else 2
            self.machine.charge.take(ChargeReading(self.now, flow, 0.5, status))

    def run(self, seconds: float = 400.0) -> Docked | DockingFailure:
        """Simulate until the goal ends."""
        while self.now < seconds:
            order = self.step()
            if isinstance(order, Docked | DockingFailure):
                return order
        raise AssertionError(f"{self.machine.phase} at {self.true.inverse() @ self.robot}: {self.machine.text}")


def failure_of(loop: Loop) -> DockingFailure:
    end = loop.run()
    assert isinstance(end, DockingFailure), end
    return end


# -- success -----------------------------------------------------------------------------------------------------------


def test_a_robot_is_staged_sees_the_dock_drives_there_and_is_charged() -> None:
    loop = Loop(model=ChargerModel(forward=0.03))
    end = loop.run()
    assert isinstance(end, Docked) and end.dock == loop.place
    assert loop.staged == [pytest.approx(tuple(HOME @ Pose2D(-0.7, 0.0)))]
    assert loop.phases == [
        DockingPhase.STAGING, DockingPhase.PERCEIVING, DockingPhase.APPROACHING, DockingPhase.WAITING,
    ]  # fmt: skip
    assert loop.charger.touches(loop.robot)
    assert loop.machine.retries == 0


@pytest.mark.parametrize("turn", range(4))
def test_a_dock_that_was_moved_by_20_cm_is_found(turn: int) -> None:
    angle = 0.5 * math.pi * turn
    loop = Loop(true=Pose2D(HOME.x + 0.2 * math.cos(angle), HOME.y + 0.2 * math.sin(angle), HOME.theta + 0.1))
    assert isinstance(loop.run(), Docked)
    assert loop.charger.touches(loop.robot)


def test_a_robot_docks_backwards() -> None:
    loop = Loop(kind=DockType(dock_direction="backward"))
    assert isinstance(loop.run(), Docked)
    assert loop.staged == [pytest.approx(tuple(HOME @ Pose2D(0.7, 0.0)))]
    assert loop.charger.touches(loop.robot)


def test_a_robot_drives_under_a_cart_which_is_not_seen_any_more_then() -> None:
    loop = Loop(kind=DockType(distance=-0.3, blind_distance=0.6), charges=False, battery=False, seen_from=0.5)
    assert isinstance(loop.run(), Docked)
    assert loop.true.distance_to(loop.robot) < 0.03


def test_a_robot_presses_on_until_it_is_charged() -> None:
    loop = Loop(kind=DockType(docking_threshold=0.025, overshoot=0.03), model=ChargerModel(forward=0.01))
    assert isinstance(loop.run(), Docked)
    assert DockingPhase.PRESSING in loop.phases
    assert loop.machine.retries == 0


def test_further_approaches_are_beside_the_axis() -> None:
    loop = Loop(parameters=DockingParameters(retry_offset=0.02), model=ChargerModel(lateral=0.012))
    loop.charger = Charger(HOME @ Pose2D(0.0, -0.02), 0.2, loop.model)  # the contacts are not in the middle
    assert isinstance(loop.run(), Docked)
    assert loop.machine.retries == 2, "to the left, then to the right"


def test_a_robot_at_the_staging_pose_does_not_drive_there() -> None:
    loop = Loop()
    loop.robot = loop.target.staging @ Pose2D(0.05, 0.05, 0.1)
    assert isinstance(loop.run(), Docked)
    assert loop.staged == []


# -- failures that say so ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("loop", "kind", "code", "text", "retries"),
    [
        (Loop(seen_from=99.0), DockNotSeen, 904, "dock 'home' is not seen: it was looked for by the truth", 3),
        (Loop(seen_from=0.4), DockLost, 904, "is not seen any more", 3),
        (Loop(fault=ChargerFault.DEAD), ContactWithoutCharge, 906, r"its battery is not charged \(-0.90 A\)", 3),
        (Loop(fault=ChargerFault.LIAR), ChargerLies, 906, "reports that it is charged, while it is discharged", 0),
        (Loop(battery=False), BatterySilent, 906, "publish battery_state", 0),
        (Loop(navigate=False), NotStaged, 903, "m from the staging pose of dock 'home'", 0),
    ],
    ids=["not seen", "lost", "dead", "liar", "silent", "not staged"],
)  # fmt: skip
def test_a_failure_says_what_it_is(loop: Loop, kind: type[DockingFailure], code: int, text: str, retries: int) -> None:
    end = failure_of(loop)
    assert (type(end), int(end.code), loop.machine.retries) == (kind, code, retries)
    with pytest.raises(kind, match=text):
        raise end


@pytest.mark.parametrize("fault", [ChargerFault.DEAD, ChargerFault.LIAR])
def test_a_robot_is_not_left_at_a_dock_that_does_not_charge_it(fault: ChargerFault) -> None:
    loop = Loop(fault=fault)
    failure_of(loop)
    assert loop.robot.distance_to(HOME) > 0.6


def test_the_next_dock_is_tried_after_one_that_fails() -> None:
    other = MappedDock("other", HOME @ Pose2D(0.0, 2.0))
    kind = DockType(detection="map")
    second = DockTarget(other, kind, TrueFace(), kind.stance(BODY))
    loop = Loop(fault=ChargerFault.LIAR, others=(second,))
    end = failure_of(loop)
    assert loop.staged[1] == pytest.approx(tuple(other.pose @ Pose2D(-0.7, 0.0)))
    assert "'other'" in str(end)


def test_a_staging_pose_that_is_not_reached_ends_the_goal_or_leads_to_the_next_dock() -> None:
    loop = Loop()
    end = loop.machine.staged("no path", 1.0)
    assert isinstance(end, NotStaged) and "was not reached: no path" in str(end)
    second = Loop(others=(loop.target,))
    assert second.machine.staged("no path", 1.0) is None
    assert second.machine.phase is DockingPhase.STAGING


def test_a_robot_that_is_not_localized_is_not_sent_anywhere() -> None:
    machine = Loop().machine
    assert machine.step(Sight(1.0, Pose2D(0.0, 0.0))) == Velocity()
    end = machine.step(Sight(101.0, Pose2D(0.0, 0.0)))
    assert isinstance(end, NotStaged) and str(end).endswith("the robot is not localized")


# -- what is in the way ------------------------------------------------------------------------------------------------


def person_before(loop: Loop) -> None:
    """Put somebody between the robot and the dock."""
    loop.points = np.array([(0.24, 0.0)])


def until_driving(loop: Loop) -> None:
    while loop.machine.phase is not DockingPhase.APPROACHING or loop.robot.distance_to(HOME) > 0.6:
        loop.step()


def test_a_robot_waits_for_somebody_in_its_way_and_goes_on() -> None:
    loop = Loop()
    until_driving(loop)
    person_before(loop)
    at = loop.robot
    for _ in range(100):
        loop.step()
    assert loop.robot == at
    assert loop.machine.text == "waiting: something is in the way"
    loop.points = NO_POINTS
    loop.step()
    assert loop.machine.text == "driving to the dock (dock 'home')"
    assert isinstance(loop.run(), Docked)


def test_a_robot_gives_up_when_somebody_stays_in_its_way() -> None:
    loop = Loop()
    until_driving(loop)
    person_before(loop)
    end = failure_of(loop)
    assert isinstance(end, DockNotReached) and "something is in the way" in str(end)


def test_a_robot_that_cannot_back_off_says_why_it_was_not_charged() -> None:
    loop = Loop(fault=ChargerFault.LIAR)
    while loop.machine.phase is not DockingPhase.BACKING:
        loop.step()
    loop.points = np.array([(-0.24, 0.0)])
    assert isinstance(failure_of(loop), ChargerLies)


def test_a_robot_that_somebody_moved_away_is_staged_again() -> None:
    loop = Loop()
    until_driving(loop)
    loop.robot = HOME @ Pose2D(-3.0, 1.0, 2.0)
    assert isinstance(loop.run(), Docked)
    assert len(loop.staged) == 2


def test_a_robot_that_is_stopped_waits_as_long_as_that_lasts() -> None:
    loop = Loop()
    until_driving(loop)
    loop.held, at = "stopped by ann", loop.robot
    for _ in range(2000):
        assert loop.step() == Velocity()
    assert loop.robot == at
    assert loop.machine.text == "waiting: stopped by ann"
    loop.held = ""
    assert isinstance(loop.run(), Docked)


def test_a_robot_that_does_not_move_is_not_at_the_dock() -> None:
    loop = Loop(parameters=DockingParameters(max_retries=0))
    until_driving(loop)
    loop.true = loop.robot @ Pose2D(0.3, 0.0)  # it stands against something 30 cm before the face
    far = Loop.step

    def stuck() -> Order:
        before = loop.robot
        order = far(loop)
        if loop.machine.phase is DockingPhase.APPROACHING:
            loop.robot = before
        return order

    end: Order = Velocity()
    while not isinstance(end, DockingFailure | Docked) and loop.now < 200.0:
        end = stuck()
    assert isinstance(end, DockNotReached) and "does not come nearer" in str(end)
