"""Queries of a container for stored plans, and its reports of planning times."""

import asyncio
from collections.abc import AsyncIterator

import numpy as np
import pytest

from engine.container.machine_client import MachineClient
from engine.container.shared_plans import PlanningNotes, SharedPlans
from engine.protocols import machine_link
from engine.protocols.framing import FrameStream
from engine.protocols.refusals import Refusal
from engine.specs.work_counts import CLASSES, ENDED, PLAN_MICROS
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import Status
from ppaas.plans.history import LinkHistory, bucket_of, computed_row, failed_row
from ppaas.plans.reuse.time_estimates import Times
from ppaas.plans.stored import PlanQuery
from tests.support.engine.engine_links import pair, receive
from tests.support.storage.records import plan
from tests.support.waiting import patience

Machine = FrameStream[machine_link.FromContainer]
QUESTION = PlanQuery(Pose2D(1, 2, 3), Pose2D(4, 5, 6), "v1", "dijkstra", {"smooth": False}, 0.18, 0.25)
KEY = ("house", "v1", "dijkstra", bucket_of(100.0))


@pytest.fixture
async def ends() -> AsyncIterator[tuple[MachineClient, Machine]]:
    near, far = await pair(machine_link.ToContainer, machine_link.FromContainer)
    client = MachineClient(near)
    serving = asyncio.create_task(client.serve(lambda _: None))
    yield client, far
    await far.close()
    await asyncio.wait_for(serving, 10)
    await client.close()


class Plans:
    """A library, with the number of jobs that it sent elsewhere."""

    def __init__(self) -> None:
        self.times, self.elsewhere = Times(), 0
        self.shared = SharedPlans(self.times, self._sent)

    def _sent(self) -> None:
        self.elsewhere += 1

    async def find(self, within: float = 10.0):
        return await asyncio.to_thread(self.shared.find, QUESTION, within)


async def test_library_without_a_machine_finds_nothing() -> None:
    plans = Plans()
    assert plans.shared.may_wait()
    assert await plans.find() == ()


async def test_plans_of_the_machine_are_arrays_and_their_query_is_timed(ends: tuple[MachineClient, Machine]) -> None:
    client, machine = ends
    plans, poses = Plans(), np.arange(14.0).reshape(2, 7)
    plans.shared.ask(client)
    finding = asyncio.create_task(plans.find())
    request = await receive(machine)
    assert isinstance(request, machine_link.FindPlans)
    assert (request.start, request.goal, request.planner, request.tolerance) == ((1, 2), (4, 5), "dijkstra", 0.25)
    kept = plan("p1", poses=poses.tobytes(), version="v1")
    machine.write(machine_link.PlansFound(request.request, [machine_link.PlanCandidate(kept, whole=False)]))
    found = await finding
    assert [(each.id, each.whole, each.poses.tolist()) for each in found] == [("p1", False, poses.tolist())]
    assert plans.times.link.answers == 1


async def test_late_answer_is_ignored_but_timed(
    ends: tuple[MachineClient, Machine],
) -> None:
    client, machine = ends
    plans = Plans()
    plans.shared.ask(client)
    finding = asyncio.create_task(plans.find(within=0.01))
    request = await receive(machine)
    assert await finding is None
    machine.write(machine_link.PlansFound(request.request, []))
    async with patience(10):
        while not plans.times.link.answers:
            await asyncio.sleep(0.001)


async def test_refused_query_finds_nothing(ends: tuple[MachineClient, Machine]) -> None:
    client, machine = ends
    plans = Plans()
    plans.shared.ask(client)
    finding = asyncio.create_task(plans.find())
    request = await receive(machine)
    machine.write(machine_link.Done(request.request, Refusal("unavailable", "no store")))
    assert await finding == []


async def test_query_on_the_loop_moves_the_job_to_a_thread(ends: tuple[MachineClient, Machine]) -> None:
    plans = Plans()
    plans.shared.ask(ends[0])
    assert not plans.shared.may_wait()
    assert plans.elsewhere == 1
    assert await asyncio.to_thread(plans.shared.may_wait)


async def test_container_loads_planning_history_and_reports_new_entries(ends: tuple[MachineClient, Machine]) -> None:
    client, machine = ends
    times = Times()
    notes = PlanningNotes(times)
    beginning = asyncio.create_task(notes.begin(client))
    request = await receive(machine)
    link = LinkHistory("m1", 0.02, 1e8, 7, 1.0)
    machine.write(machine_link.PlanningHistory(request.request, [computed_row(KEY, 0.5)] * 3, "m1", link))
    await beginning
    expected = times.computation.expect("dijkstra", 100.0)
    assert expected is not None and expected.mean == pytest.approx(0.5, rel=1e-3)
    assert times.link.answers == 7
    notes.tell(client)  # nothing new to report
    for _ in range(2):
        notes(failed_row(KEY))
    times.link.note(100.0, 0.01)
    notes.tell(client)
    note = await receive(machine)
    assert isinstance(note, machine_link.NoteHistory)
    assert [(row.key, row.failed) for row in note.rows] == [(KEY, 2)]
    assert note.link is not None and (note.link.link, note.link.answers) == ("m1", 8)


async def test_container_reports_its_counts_once(ends: tuple[MachineClient, Machine]) -> None:
    client, machine = ends
    notes = PlanningNotes(Times())
    notes(computed_row(KEY, 0.004))
    notes(computed_row(KEY, 0.3))
    notes.tell(client)
    note = await receive(machine)
    assert isinstance(note, machine_link.NoteHistory)
    assert len(note.rows) == 1, "they are summed up"
    assert note.counts == {CLASSES[3]: 1, CLASSES[9]: 1, PLAN_MICROS: 304_000}
    notes.goal_ended(Status.ABORTED)
    notes.tell(client)
    note = await receive(machine)
    assert isinstance(note, machine_link.NoteHistory)
    assert (note.rows, note.counts) == ([], {ENDED[Status.ABORTED]: 1})
