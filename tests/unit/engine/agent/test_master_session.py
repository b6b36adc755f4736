"""Master session: the lease, when a machine acts for its cloud, and reports until it registers."""

import asyncio
from collections.abc import AsyncIterator

import pytest

from engine.agent import master_session
from engine.agent.config import AgentConfig
from engine.agent.master_session import DENIED, LEASE, SILENT, Master, MasterLease, MasterSession, report_start
from engine.processes.background import cancel_all
from engine.processes.heartbeats import BEAT_PERIOD, MISSED
from engine.protocols import control_link
from engine.protocols.framing import FrameStream
from engine.runtimes.compilation.compile_pool import CompileReport
from engine.runtimes.compilation.kernel_compiler import KernelCompiler
from engine.specs.start_state import KernelProgress
from ppaas.errors import Unavailable
from tests.support.engine.engine_links import pair, receive
from tests.support.waiting import patience


async def test_machine_acts_from_welcome_until_the_connection_ends() -> None:
    near, far = await pair(control_link.ToAgent, control_link.FromAgent)
    session = MasterSession(remote=False)
    session.tell(control_link.Exited("c0", 0))  # dropped: no master is connected
    assert not session.acts()
    session.begin(near)
    assert not session.acts()
    assert session.welcome(0)
    assert session.acts()
    session.tell(control_link.Exited("c1", 0))
    assert await receive(far) == control_link.Exited("c1", 0)
    session.lost()
    assert not session.acts()
    session.begin(near)
    assert not session.acts()
    await near.close()
    await far.close()


async def test_machine_acts_while_its_lease_holds() -> None:
    near, far = await pair(control_link.ToAgent, control_link.FromAgent)
    session = MasterSession(remote=True)
    session.begin(near)
    assert session.lease.holds() and not session.acts()
    assert session.welcome(0)
    assert session.acts()
    session.lease.holds = lambda: False  # type: ignore[method-assign]
    assert not session.acts()
    await near.close()
    await far.close()


async def test_containers_may_be_replaced_unless_their_master_shows_that_nobody_leads() -> None:
    near, far = await pair(control_link.ToAgent, control_link.FromAgent)
    session = MasterSession(remote=True)
    assert session.may_be_replaced(), "no master is connected"
    session.begin(near)
    session.welcome(0)
    assert not session.may_be_replaced(), "the machine acts"
    lease = session.lease
    lease.holds = lambda: False  # type: ignore[method-assign]
    assert session.may_be_replaced()
    lease.nobody_leads = lambda: True  # type: ignore[method-assign]
    assert not session.may_be_replaced() and not session.acts()
    session.lost()
    assert session.may_be_replaced()
    await near.close()
    await far.close()


async def test_machine_follows_later_masters_and_refuses_an_earlier_one() -> None:
    session = MasterSession(remote=True)
    for epoch, accepted in ((3, True), (3, True), (5, True), (4, False), (5, True)):
        near, far = await pair(control_link.ToAgent, control_link.FromAgent)
        session.begin(near)
        assert session.welcome(epoch) is accepted is session.acts() is not session.refused
        if not accepted:
            assert await receive(far) == control_link.Outranked(5), "it is told why"
        await near.close()
        await far.close()


class Time:
    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def beating(lease: MasterLease, time: Time, beats: int, *, answered: bool) -> list[bool]:
    """Send heartbeats, one each period; return for each whether the master still answers."""
    found = []
    for _ in range(beats):
        time.now += BEAT_PERIOD
        found.append(lease.beat())
        if answered:
            lease.answered()
    return found


def test_lease_holds_while_heartbeats_are_answered() -> None:
    lease = MasterLease(time := Time())
    assert all(beating(lease, time, 20, answered=True))
    assert lease.holds()


def test_lease_ends_before_the_master_gives_the_machine_up() -> None:
    lease = MasterLease(time := Time())
    beating(lease, time, 3, answered=True)
    sent = time.now
    while lease.holds():
        time.now += 0.01
    assert time.now - sent <= LEASE + 0.02 < MISSED * BEAT_PERIOD


def test_lease_counts_from_the_sending_of_the_heartbeat() -> None:
    lease = MasterLease(time := Time())
    lease.beat()
    time.now += LEASE + 0.1
    lease.answered()
    assert not lease.holds()


def test_suspended_agent_has_no_lease_until_the_next_answer() -> None:
    lease = MasterLease(time := Time())
    beating(lease, time, 3, answered=True)
    time.now += 60.0
    assert not lease.holds()
    beating(lease, time, 1, answered=True)
    assert lease.holds()


def test_master_is_given_up_for_missed_answers_not_for_own_suspension() -> None:
    lease = MasterLease(time := Time())
    assert all(beating(lease, time, 3, answered=True))
    time.now += 60.0
    assert lease.beat()
    assert beating(lease, time, MISSED + 1, answered=False)[-1] is False


def test_unsolicited_answer_does_not_extend_the_lease() -> None:
    lease = MasterLease(time := Time())
    time.now += LEASE
    lease.answered()
    assert not lease.holds()


def test_an_answer_of_a_master_that_does_not_lead_shows_only_that_it_runs() -> None:
    lease = MasterLease(time := Time())
    for _ in range(2 * MISSED):
        assert all(beating(lease, time, 1, answered=False)), "it runs"
        lease.answered(leads=False)
    assert not lease.holds()
    beating(lease, time, 1, answered=True)
    assert lease.holds()


def test_unanswered_heartbeats_are_counted() -> None:
    lease = MasterLease(time := Time())
    beating(lease, time, 3, answered=True)
    assert lease.unanswered == 0
    beating(lease, time, 2, answered=False)
    assert lease.unanswered == 2


def test_nobody_leads_once_a_master_has_answered_so_for_long() -> None:
    lease = MasterLease(time := Time())
    for _ in range(DENIED):
        assert not lease.nobody_leads(), "another one may be found"
        beating(lease, time, 1, answered=False)
        lease.answered(leads=False)
    assert lease.nobody_leads()
    beating(lease, time, SILENT, answered=False)
    assert not lease.nobody_leads(), "it is silent: another one may lead"
    lease.answered(leads=False)
    assert lease.nobody_leads()
    lease.answered()
    assert not lease.nobody_leads(), "it leads"


def test_time_in_which_the_agent_was_stopped_shows_nothing() -> None:
    lease = MasterLease(time := Time())
    beating(lease, time, 1, answered=False)
    lease.answered(leads=False)
    time.now += 60.0
    assert not lease.nobody_leads()


CONFIG = AgentConfig("m1", "", "secret", "", "cloud", "memory:", "memory:")


class Cloud:
    """A master that a machine can dial, once the test lets it."""

    def __init__(self) -> None:
        self.is_up = asyncio.Event()
        self.links: asyncio.Queue[FrameStream[control_link.FromAgent]] = asyncio.Queue()

    async def dial(self) -> Master:
        if not self.is_up.is_set():
            raise Unavailable("not yet")
        near, far = await pair(control_link.ToAgent, control_link.FromAgent)
        self.links.put_nowait(far)
        return near


@pytest.fixture
async def compiler(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[KernelCompiler]:
    monkeypatch.setattr(master_session, "REPORT_PERIOD", 0.02)
    made = KernelCompiler()
    monkeypatch.setattr(made, "begin", lambda: None)
    yield made
    await made.close()


async def test_it_reports_again_and_again_how_far_its_kernels_are(compiler: KernelCompiler) -> None:
    cloud = Cloud()
    reporting = asyncio.create_task(report_start(CONFIG, compiler, cloud.dial, delay=0.0))
    await asyncio.sleep(0.05)
    cloud.is_up.set()
    link = await cloud.links.get()
    assert await receive(link) == control_link.MachineStarting("m1", "secret")
    compiler.report = CompileReport(("a.kernels.b", "a.kernels.c"), ("a.kernels.b",))
    expected = control_link.MachineStarting("m1", "secret", KernelProgress(1, 2))
    async with patience(10):
        while await receive(link) != expected:
            pass
    await link.close()
    again = await cloud.links.get()  # the master was restarted
    assert await receive(again) == expected
    await cancel_all((reporting,))
    async with patience(10):
        while await again.receive() is not None:
            pass


async def test_a_usual_start_reports_nothing(compiler: KernelCompiler) -> None:
    cloud = Cloud()
    cloud.is_up.set()
    reporting = asyncio.create_task(report_start(CONFIG, compiler, cloud.dial, delay=600.0))
    await asyncio.sleep(0)
    await cancel_all((reporting,))
    assert cloud.links.empty()
