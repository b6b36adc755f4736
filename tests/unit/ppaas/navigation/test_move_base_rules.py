"""Invariants of Move Base under arbitrary sequences of events."""

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from ppaas.controllers.base import Velocity
from ppaas.errors import NoValidPath
from ppaas.geometry import Pose2D
from ppaas.navigation import events, move_base
from ppaas.navigation.move_base import GoalPhase, MoveBase
from ppaas.navigation.parameters import MoveBaseParameters

PLAN = np.zeros((2, 7))
ids = st.sampled_from("abcdef")
seconds = st.sampled_from([0.0, 0.1, 0.5, 3.0, 20.0])


class Rules(RuleBasedStateMachine):
    """Feeds answers early, late or never."""

    @initialize(
        frequency=st.sampled_from([0.0, 1.0]),
        recovery=st.booleans(),
        oscillation=st.sampled_from([0.0, 1.0]),
        retries=st.sampled_from([-1, 0, 2]),
    )
    def begin(self, frequency, recovery, oscillation, retries):
        self.machine = MoveBase(
            MoveBaseParameters(
                planner_frequency=frequency,
                oscillation_timeout=oscillation,
                max_planning_retries=retries,
            ),
            ["one", "two"] if recovery else [],
        )
        self.now = 0.0
        self.accepted = 0
        self.ended = 0
        self.plans: list[int] = []
        self.moving = False
        self.recovering: int | None = None

    def feed(self, event):
        known = {state.goal.id for state in self.machine.goals.states(self.now)}
        for order in self.machine.handle(event):
            match order:
                case move_base.PublishResult():
                    self.ended += 1
                    assert order.status.terminal
                case move_base.PublishGoal():
                    assert order.goal.id not in known
                    self.accepted += 1
                case move_base.RequestPlan():
                    assert not self.plans, "a plan is requested while another is being computed"
                    self.plans.append(order.number)
                case move_base.CancelPlan():
                    assert order.number in self.plans
                    self.plans.remove(order.number)
                case move_base.Recover():
                    assert order.begin == (order.index != self.recovering), "a run begins once"
                    assert not self.plans
                    self.recovering = order.index
                case move_base.SendVelocity():
                    assert self.machine.goals.active is not None
                    self.moving = any(order.velocity)
                case move_base.StopBase():
                    self.moving = False
        if self.machine.state is not GoalPhase.CLEARING:
            self.recovering = None

    @rule(name=ids)
    def goal(self, name):
        self.feed(events.GoalReceived(self.now, events.Goal(name, Pose2D(1, 1, 0), self.now)))

    @rule(name=st.one_of(st.just(""), ids), stamp=st.sampled_from([0.0, 1.0, 1e9]))
    def cancel(self, name, stamp):
        self.feed(events.CancelReceived(self.now, name, stamp))

    @rule(passed=seconds, x=st.floats(0, 2), theta=st.floats(-3, 3), known=st.booleans())
    def tick(self, passed, x, theta, known):
        self.now += passed
        self.feed(events.ControlTick(self.now, Pose2D(x, 0, theta) if known else None, "" if known else "lost"))

    @precondition(lambda self: self.plans)
    @rule(found=st.booleans(), deferred=st.booleans(), final=st.booleans())
    def answer_plan(self, found, deferred, final):
        number = self.plans.pop()
        if found and deferred:
            self.feed(events.PlanDeferred(self.now, number, "blocked"))
        elif found:
            self.feed(events.PlanSucceeded(self.now, number, PLAN))
        else:
            self.feed(events.PlanFailed(self.now, number, NoValidPath("none"), final))

    @rule(number=st.integers(-3, 0))
    def answer_unrequested_plan(self, number):
        self.feed(events.PlanSucceeded(self.now, number, PLAN))

    @rule(reached=st.booleans(), speed=st.floats(0, 1))
    def velocity(self, reached, speed):
        self.feed(events.VelocityComputed(self.now, Velocity(speed, 0.0), reached))

    @rule()
    def no_velocity(self):
        self.feed(events.ControlFailed(self.now))

    @rule(speed=st.floats(-1, 1))
    def continue_recovery(self, speed):
        self.feed(events.RecoveryStepped(self.now, Velocity(speed, 0.0)))

    @rule(reason=st.sampled_from(["", "no room"]))
    def end_recovery(self, reason):
        self.feed(events.RecoveryEnded(self.now, reason))

    @invariant()
    def goals_end_exactly_once(self):
        if hasattr(self, "machine"):
            active = self.machine.goals.active is not None
            assert self.accepted - self.ended == int(active)

    @invariant()
    def no_motion_or_plan_without_a_goal(self):
        if hasattr(self, "machine") and self.machine.goals.active is None:
            assert not self.moving
            assert not self.plans


Rules.TestCase.settings = settings(stateful_step_count=40)
TestRules = Rules.TestCase
