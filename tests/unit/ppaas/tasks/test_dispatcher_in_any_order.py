"""Whatever happens, every task ends once, no robot has two, and a dispatcher made anew goes on."""

from typing import Any

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule
from msgspec.structs import replace

from ppaas.tasks.dispatcher import GONE_AFTER, REST, Dispatcher
from ppaas.tasks.options import After, PlaceHold, Repeat
from ppaas.tasks.orders import Cancel, Order, RobotNow, Send
from ppaas.tasks.records import Task
from tests.support.budget import examples

NAMES = ("a", "b", "c")
robots = st.sampled_from(NAMES)
places = st.tuples(st.integers(0, 40), st.integers(0, 40), st.just(0)).map(lambda xyz: tuple(map(float, xyz)))


class Tasks(RuleBasedStateMachine):
    """A dispatcher, a store that it may lose its place to, and robots whose Move Base has one goal each."""

    def __init__(self) -> None:
        super().__init__()
        self.now = 0.0
        self.kept: dict[str, Task] = {}
        self.goals: dict[str, str] = {}
        self.known: set[str] = set()
        self.there = dict.fromkeys(NAMES, (0.0, 0.0, 0.0))
        self.connected: set[str] = set()
        self.dispatcher = Dispatcher([], 0.0)

    def obey(self, orders: list[Order]) -> None:
        for order in orders:
            match order:
                case Send():
                    if order.robot in self.connected and (order.robot + order.goal_id) not in self.known:
                        assert order.goal_id not in {goal for goal in self.known if goal.endswith(order.goal_id)}
                        self.known.add(order.robot + order.goal_id)
                        self.goals[order.robot] = order.goal_id
                case Cancel():
                    if self.goals.get(order.robot) == order.goal_id:
                        del self.goals[order.robot]
                case _:
                    known = self.kept.get(order.task.id)
                    assert (order.task.run == 2) if known is None else known.is_open, "a task ends once"
                    self.kept[order.task.id] = order.task

    def look(self) -> None:
        seen = {
            name: RobotNow(self.there[name], goals=frozenset({self.goals[name]} if name in self.goals else ()))
            for name in self.connected
        }
        self.obey(self.dispatcher.see(seen, self.now))

    @rule(kind=st.sampled_from(["go_to", "pick_drop", "patrol"]), data=st.data(), priority=st.integers(-2, 2))
    def add(self, kind: str, data: st.DataObject, priority: int) -> None:
        size = {"go_to": 1, "pick_drop": 2, "patrol": 3}[kind]
        spots = tuple(data.draw(st.lists(places, min_size=size, max_size=size)))
        fields: dict[str, Any] = {"kind": kind, "places": spots, "rounds": 2 if kind == "patrol" else 1}
        if data.draw(st.booleans()):
            hold = st.sampled_from(
                [None, PlaceHold(confirm=True), PlaceHold(seconds=1.0), PlaceHold(confirm=True, seconds=REST)]
            )
            fields["holds"] = tuple(data.draw(st.lists(hold, min_size=size, max_size=size)))
        if self.kept and data.draw(st.booleans()):
            fields["after"] = (After(task=data.draw(st.sampled_from(sorted(self.kept))), on="ended"),)
        if data.draw(st.booleans()):
            fields["repeat"] = Repeat(every=REST, count=2)
        fields["preempts"] = data.draw(st.booleans())
        made = Task(id=f"t{len(self.kept)}", priority=priority, created=self.now, **fields)
        self.kept[made.id] = made
        self.dispatcher.add(made, self.now)

    @rule(data=st.data())
    def cancel(self, data: st.DataObject) -> None:
        if self.dispatcher.tasks:
            name = data.draw(st.sampled_from(sorted(self.dispatcher.tasks)))
            self.kept[name] = Task(id=name, kind="go_to", places=((0.0, 0.0, 0.0),), state="cancelled")
            self.obey(self.dispatcher.withdraw(name))
            self.dispatcher.add(self.kept[name], self.now)

    @rule(data=st.data())
    def confirm(self, data: st.DataObject) -> None:
        if self.dispatcher.tasks:
            self.confirm_one(data.draw(st.sampled_from(sorted(self.dispatcher.tasks))))

    def confirm_one(self, name: str) -> None:
        task = self.dispatcher.tasks[name]
        if task.holding is not None:
            self.kept[name] = replace(task, confirmed=task.leg)
            self.dispatcher.confirm(self.kept[name])

    @rule(name=robots, place=places)
    def connect(self, name: str, place: tuple[float, float, float]) -> None:
        self.connected.add(name)
        self.there[name] = place
        self.look()

    @rule(name=robots)
    def disconnect(self, name: str) -> None:
        self.connected.discard(name)
        self.goals.pop(name, None)
        self.known = {goal for goal in self.known if not goal.startswith(name)}
        self.look()

    @rule(name=robots, outcome=st.sampled_from(["succeeded", "succeeded", "aborted", "canceled", "lost"]))
    def end_goal(self, name: str, outcome: str) -> None:
        if name in self.goals:
            goal = self.goals.pop(name)
            self.obey(self.dispatcher.goal_ended(name, goal, outcome, "", self.now))  # type: ignore[arg-type]

    @rule(seconds=st.sampled_from([1.0, REST, GONE_AFTER + 1.0]))
    def wait(self, seconds: float) -> None:
        self.now += seconds
        self.look()
        self.obey(self.dispatcher.release(self.now))
        self.obey(self.dispatcher.decide(self.now))

    @rule()
    def restart(self) -> None:
        self.dispatcher = Dispatcher(list(self.kept.values()), self.now)
        self.look()

    @invariant()
    def the_records_are_those_of_the_dispatcher(self) -> None:
        assert {name: task for name, task in self.kept.items() if task.is_open} == dict(self.dispatcher.tasks)

    @invariant()
    def no_robot_has_two_tasks(self) -> None:
        busy = [task.robot for task in self.dispatcher.tasks.values() if task.robot]
        assert len(busy) == len(set(busy))
        assert all((task.state == "queued") == (not task.robot) for task in self.dispatcher.tasks.values())

    def teardown(self) -> None:
        self.connected = set(NAMES)
        for _ in range(400):
            self.now += REST
            self.look()
            for name in tuple(self.dispatcher.tasks):
                self.confirm_one(name)
            self.obey(self.dispatcher.release(self.now))
            self.obey(self.dispatcher.decide(self.now))
            for name in NAMES:
                self.end_goal_of(name)
        assert not self.dispatcher.tasks, "every task ends while robots arrive"
        assert not self.goals

    def end_goal_of(self, name: str) -> None:
        if name in self.goals:
            goal = self.goals.pop(name)
            self.obey(self.dispatcher.goal_ended(name, goal, "succeeded", "", self.now))


TestTasks = Tasks.TestCase
TestTasks.settings = settings(max_examples=examples(60), stateful_step_count=40)
