"""Driver of the Move Base state machine, for tests."""

import numpy as np

from ppaas.errors import NoValidPath
from ppaas.geometry import Pose2D
from ppaas.navigation.events import ControlTick, Goal, GoalReceived, PlanFailed, PlanSucceeded
from ppaas.navigation.move_base import GoalPhase, MoveBase, RequestPlan
from ppaas.navigation.parameters import MoveBaseParameters, recovery_behaviors

HERE = Pose2D(0.0, 0.0, 0.0)
THERE = Pose2D(5.0, 0.0, 0.0)
PLAN = np.zeros((3, 7))
BLOCKED = NoValidPath("no way")


class Driver:
    """Feeds events to a Move Base, and keeps the orders of the last event."""

    def __init__(self, **parameters) -> None:
        own = MoveBaseParameters(**parameters)
        self.machine = MoveBase(own, [each.name for each in recovery_behaviors(own)])
        self.now = 100.0
        self.orders: list = []

    def feed(self, event):
        self.orders = self.machine.handle(event)
        return self.orders

    def goal(self, name="a", pose=THERE, stamp=None):
        return self.feed(GoalReceived(self.now, Goal(name, pose, self.now if stamp is None else stamp)))

    def tick(self, pose=HERE, seconds=0.1, reason=""):
        self.now += seconds
        return self.feed(ControlTick(self.now, pose, reason))

    def of(self, kind):
        return [order for order in self.orders if isinstance(order, kind)]

    def one(self, kind):
        (order,) = self.of(kind)
        return order

    def to_planning(self, **goal):
        self.goal(**goal)
        self.tick()
        return self.one(RequestPlan).number

    def to_controlling(self):
        number = self.to_planning()
        return self.feed(PlanSucceeded(self.now, number, PLAN))

    def fail_plan(self, error=BLOCKED, final=False):
        number = self.one(RequestPlan).number
        return self.feed(PlanFailed(self.now, number, error, final))

    def fail_plans_until_recovery(self):
        for _ in range(1000):
            self.tick()
            if self.of(RequestPlan):
                self.fail_plan()
            if self.machine.state is GoalPhase.CLEARING or self.machine.goals.active is None:
                return
        raise AssertionError("no recovery began")

    def status(self):
        active = self.machine.goals.active
        return active and active.status

    @property
    def text(self):
        return self.machine.goals.active.text
