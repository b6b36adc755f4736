"""Queries of a container for stored plans, and its reports of planning times."""

import asyncio
from collections.abc import AsyncIterator

import numpy as np
import pytest

from engine.container.machine_client import MachineClient
from engine.container.shared_plans import PlanningNotes, SharedPlans
from engine.protocols import machine_link
from engine.protocols.framing import FrameStream
from engine.protocols.robot_link import Refusal
from ppaas.geometry import Pose2D
from ppaas.plans.history import LinkHistory, bucket_of, computed_row, failed_row
from ppaas.plans.reuse.measured_times import Times
from ppaas.plans.stored import PlanQuery
from tests.support.engine.engine_links import pair, receive
from tests.support.storage.records import plan

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


async def test_a_library_without_a_machine_has_nothing_and_lets_wait() -> None:
    plans = Plans()
    assert plans.shared.may_wait()
    assert await plans.find() == ()


async def test_what_the_machine_finds_comes_as_arrays_and_is_timed(ends: tuple[MachineClient, Machine]) -> None:
    client, machine = ends
    plans, poses = Plans(), np.arange(14.0).reshape(2, 7)
    plans.shared.ask(client)
    finding = asyncio.create_task(plans.find())
    asked = await receive(machine)
    assert isinstance(asked, machine_link.FindPlans)
    assert (asked.start, asked.goal, asked.planner, asked.tolerance) == ((1, 2), (4, 5), "dijkstra", 0.25)
    kept = plan("p1", poses=poses.tobytes(), version="v1")
    machine.write(machine_link.PlansFound(asked.request, [machine_link.Candidate(kept, whole=False)]))
    found = await finding
    assert [(each.id, each.whole, each.poses.tolist()) for each in found] == [("p1", False, poses.tolist())]
    assert plans.times.link.answers == 1


async def test_who_waited_too_long_goes_on_and_the_answer_is_timed_all_the_same(
    ends: tuple[MachineClient, Machine],
) -> None:
    client, machine = ends
    plans = Plans()
    plans.shared.ask(client)
    finding = asyncio.create_task(plans.find(within=0.01))
    asked = await receive(machine)
    assert await finding is None
    machine.write(machine_link.PlansFound(asked.request, []))
    async with asyncio.timeout(10):
        while not plans.times.link.answers:
            await asyncio.sleep(0.001)


async def test_a_machine_that_refuses_has_nothing(ends: tuple[MachineClient, Machine]) -> None:
    client, machine = ends
    plans = Plans()
    plans.shared.ask(client)
    finding = asyncio.create_task(plans.find())
    asked = await receive(machine)
    machine.write(machine_link.Done(asked.request, Refusal("unavailable", "no store")))
    assert await finding == []


async def test_on_the_loop_nobody_waits_and_the_job_is_sent_elsewhere(ends: tuple[MachineClient, Machine]) -> None:
    plans = Plans()
    plans.shared.ask(ends[0])
    assert not plans.shared.may_wait()
    assert plans.elsewhere == 1
    assert await asyncio.to_thread(plans.shared.may_wait)


async def test_a_container_begins_with_what_is_known_and_tells_what_is_new(ends: tuple[MachineClient, Machine]) -> None:
    client, machine = ends
    times = Times()
    notes = PlanningNotes(times)
    beginning = asyncio.create_task(notes.begin(client))
    asked = await receive(machine)
    link = LinkHistory("m1", 0.02, 1e8, 7, 1.0)
    machine.write(machine_link.PlanningHistory(asked.request, [computed_row(KEY, 0.5)] * 3, "m1", link))
    await beginning
    expected = times.computation.expect("dijkstra", 100.0)
    assert expected is not None and expected.mean == pytest.approx(0.5, rel=1e-3)
    assert times.link.answers == 7
    notes.tell(client)  # nothing new to report
    for _ in range(2):
        notes(failed_row(KEY))
    times.link.note(100.0, 0.01)
    notes.tell(client)
    told = await receive(machine)
    assert isinstance(told, machine_link.NoteHistory)
    assert [(row.key, row.failed) for row in told.rows] == [(KEY, 2)]
    assert told.link is not None and (told.link.link, told.link.answers) == ("m1", 8)
