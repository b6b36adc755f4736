"""Watch of a docked robot."""

from ppaas.docking.charge import CHARGING, ChargeReading
from ppaas.docking.dock import MappedDock
from ppaas.docking.watch import DockedWatch, has_left
from ppaas.geometry import Pose2D

DOCK = MappedDock("a", Pose2D(1.0, 2.0))


def watched(watch: DockedWatch, begin: int, end: int, current: float | None, status: int = 2) -> None:
    for now in range(begin, end):
        watch.take(ChargeReading(float(now), current, None, status))
        watch.look(float(now))


def test_a_robot_whose_charge_ends_is_noticed_and_so_is_its_return() -> None:
    watch = DockedWatch(DOCK, 0.5, 30.0, 0.0)
    watched(watch, 0, 100, 2.5, CHARGING)
    assert watch.problem == ""
    watched(watch, 100, 120, -0.9)
    assert watch.problem == "", "a short break is none"
    watched(watch, 120, 140, -0.9)
    assert watch.problem.startswith("the robot stands at dock 'a' without charge for 3")
    watched(watch, 140, 150, 2.5, CHARGING)
    assert watch.problem == ""


def test_a_battery_that_falls_silent_is_noticed() -> None:
    watch = DockedWatch(DOCK, 0.5, 30.0, 0.0)
    watched(watch, 0, 10, 2.5, CHARGING)
    watch.look(35.0)
    assert watch.problem == ""
    watch.look(60.0)
    assert watch.problem.endswith("nothing is known of the battery")


def test_a_dock_that_does_not_charge_has_no_problem() -> None:
    watch = DockedWatch(DOCK._replace(charges=False), 0.5, 30.0, 0.0)
    assert not watch.look(1000.0)
    assert watch.problem == ""


def test_a_robot_that_is_elsewhere_has_left() -> None:
    assert not has_left(Pose2D(1.0, 2.0), Pose2D(1.1, 2.1, 3.0))
    assert has_left(Pose2D(1.0, 2.0), Pose2D(1.0, 2.3))
