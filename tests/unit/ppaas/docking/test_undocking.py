"""State machine of undocking."""

import numpy as np
import pytest

from ppaas.controllers.base import Velocity
from ppaas.docking.approach import BodyOutline
from ppaas.docking.detection.base import DockView
from ppaas.docking.failures import DockingTimeout
from ppaas.docking.orders import Sight
from ppaas.docking.parameters import DockingParameters, DockType
from ppaas.docking.undocking import Undocking
from ppaas.geometry import Pose2D

BODY = BodyOutline(0.2, 0.2, 0.2)
START = Pose2D(1.0, 2.0, 2.5)
FREE, BEHIND = DockView(np.array([(0.2, 0.0)])), DockView(np.array([(-0.25, 0.0)]))


def undocking(kind: DockType) -> Undocking:
    return Undocking(START, kind, DockingParameters(), BODY, braking=1.0, until=30.0)


@pytest.mark.parametrize(("direction", "end"), [("forward", -0.7), ("backward", 0.7)])
def test_a_robot_drives_out_the_way_it_came(direction: str, end: float) -> None:
    machine = undocking(DockType(dock_direction=direction))  # type: ignore[arg-type]
    pose, now = START, 0.0
    while (order := machine.step(Sight(now, pose))) is not None:
        assert isinstance(order, Velocity), order
        pose, now = pose @ Pose2D(order.linear * 0.05, 0.0, order.angular * 0.05), now + 0.05
    assert (START.inverse() @ pose).x == pytest.approx(end, abs=0.03)


def test_a_robot_waits_for_what_is_behind_it_until_its_time_is_over() -> None:
    machine = undocking(DockType())
    assert machine.step(Sight(0.0, START, view=FREE)) != Velocity()
    assert machine.step(Sight(1.0, START, view=BEHIND)) == Velocity()
    assert machine.text == "waiting: something is in the way"
    assert machine.step(Sight(2.0, START, held="stopped by ann")) == Velocity()
    end = machine.step(Sight(31.0, START, view=BEHIND))
    assert isinstance(end, DockingTimeout)
    assert end.code == 907 and "stopped by ann" in str(end)
