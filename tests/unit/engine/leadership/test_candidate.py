"""Candidates for a lease: one, step by step; and several over one store.

The several have pauses of any length, slow and lost answers, and clocks that disagree.
"""

from dataclasses import dataclass, field

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.leadership.candidate import Change, LeaseCandidate, LeaseTiming, Read, Request, Role
from storage.records import Lease
from tests.support.budget import examples

TIMING = LeaseTiming(renew=0.5, look=0.25, validity=2.5, patience=3.0)
OTHERS = Lease("master", "b", 4, 7)
LATE = 100.0


def waiting(lease: Lease, now: float = 0.0) -> LeaseCandidate:
    """Return a candidate that has seen a lease."""
    candidate = LeaseCandidate("master", "a", now, TIMING)
    assert candidate.next(now) == Read("master")
    candidate.was_read(lease, now)
    return candidate


def leading(now: float = 0.0) -> LeaseCandidate:
    """Return a candidate that began to lead at a time."""
    candidate = waiting(Lease("master"), now)
    assert candidate.next(now) == Change(Lease("master", "a", 1), Lease("master"))
    candidate.was_changed(now, done=True)
    return candidate


def renewal(beat: int) -> Change:
    return Change(Lease("master", "a", 1, beat), Lease("master", "a", 1, beat - 1))


@pytest.mark.parametrize("left", [Lease("master"), Lease("master", "", 4, 9), Lease("master", "a", 4, 9)])
def test_a_lease_of_nobody_or_of_an_earlier_process_is_taken_at_once(left: Lease) -> None:
    candidate = waiting(left)
    assert candidate.next(0.0) == Change(Lease("master", "a", left.epoch + 1), left)
    assert candidate.next(0.0) is None, "one request at a time"
    candidate.was_changed(0.1, done=True)
    assert (candidate.role, candidate.held.epoch, candidate.former) == (Role.LEADING, left.epoch + 1, "")


def test_a_lease_that_does_not_change_is_taken_after_the_patience() -> None:
    candidate = waiting(OTHERS)
    for look in range(1, 12):
        now = look * TIMING.look
        assert candidate.next(now - 0.01) is None
        assert candidate.next(now) == Read("master")
        candidate.was_read(OTHERS, now)
    assert candidate.next(2.99) is None
    assert candidate.next(3.0) == Change(Lease("master", "a", 5), OTHERS)
    candidate.was_changed(3.1, done=True)
    assert (candidate.held, candidate.former, candidate.rival) == (Lease("master", "a", 5), "b", "")
    assert candidate.leads(5.4) and not candidate.leads(5.5), "from when it was asked for"


def test_a_lease_that_changes_is_waited_for_and_its_holder_is_a_rival() -> None:
    candidate = waiting(OTHERS)
    assert candidate.next(2.9) == Read("master")
    candidate.was_read(Lease("master", "b", 4, 8), 2.9)
    assert candidate.rival == "b"
    assert candidate.next(3.2) == Read("master")


def test_a_standby_that_was_stopped_asks_for_what_it_has_seen_and_is_refused() -> None:
    candidate = waiting(OTHERS)
    assert candidate.next(LATE) == Read("master")
    candidate.was_read(Lease("master", "b", 4, 200), LATE)
    assert candidate.next(LATE) is None


def test_a_leader_renews_and_leads_from_when_it_asked() -> None:
    candidate = leading()
    assert candidate.next(0.49) is None
    assert candidate.next(0.5) == renewal(1)
    candidate.was_changed(2.0, done=True)
    assert candidate.leads(2.9) and not candidate.leads(3.0)
    assert candidate.next(2.0) == renewal(2), "the answer came late"


def test_a_leader_whose_answer_was_lost_finds_its_renewal() -> None:
    candidate = leading()
    candidate.next(0.5)
    candidate.has_failed(1.0)
    assert candidate.next(1.25) == Read("master")
    candidate.was_read(Lease("master", "a", 1, 1), 1.3)
    assert candidate.next(1.3) == renewal(2)
    candidate.was_changed(1.4, done=True)
    assert candidate.leads(3.7)


def test_a_leader_without_answers_leads_no_more_and_leads_again_if_nobody_took_over() -> None:
    candidate = leading()
    candidate.next(0.5)
    candidate.has_failed(5.5)
    assert (candidate.leads(2.4), candidate.leads(2.5), candidate.role) == (True, False, Role.LEADING)
    assert candidate.next(6.0) == Read("master")
    candidate.was_read(Lease("master", "a", 1), 6.1)
    assert not candidate.leads(6.1), "reading renews nothing"
    assert candidate.next(6.1) == renewal(1)
    candidate.was_changed(6.2, done=True)
    assert candidate.leads(6.2)


def test_a_leader_that_wakes_up_finds_out_that_it_was_replaced() -> None:
    candidate = leading()
    assert not candidate.leads(LATE)
    assert candidate.next(LATE) == renewal(1)
    candidate.was_changed(LATE, done=False)
    assert candidate.next(LATE) == Read("master")
    candidate.was_read(Lease("master", "b", 2, 9), LATE)
    assert (candidate.role, candidate.is_over, candidate.next(LATE + 9)) == (Role.REPLACED, True, None)


def test_a_leader_is_replaced_by_a_later_epoch_that_it_hears_of() -> None:
    candidate = leading()
    candidate.next(0.5)
    for epoch in (0, 1):
        candidate.heard_of(epoch)
        assert candidate.leads(0.5)
    candidate.heard_of(2)
    assert candidate.role is Role.REPLACED
    candidate.was_changed(0.6, done=True)
    assert not candidate.leads(0.6), "an answer that comes later changes nothing"


def test_a_leader_releases_its_lease_once() -> None:
    candidate = leading()
    candidate.next(0.5)
    assert candidate.release() is None, "a renewal is under way"
    candidate.was_changed(0.6, done=True)
    assert candidate.release() == Change(Lease("master", "", 1, 2), Lease("master", "a", 1, 1))
    assert (candidate.release(), candidate.leads(0.6), candidate.role) == (None, False, Role.RELEASED)


def test_a_standby_whose_attempt_was_lost_looks_again() -> None:
    candidate = waiting(Lease("master"))
    candidate.next(0.0)
    candidate.has_failed(1.0)
    assert candidate.next(1.25) == Read("master")
    candidate.was_read(Lease("master", "a", 1), 1.3)
    assert candidate.next(1.3) == Change(Lease("master", "a", 2), Lease("master", "a", 1))


def test_an_answer_without_a_request_is_an_error() -> None:
    with pytest.raises(ValueError, match="under way"):
        waiting(OTHERS).was_changed(0.0, done=True)


USUAL = LeaseTiming()
STEP = 0.05
"""Length of a step of the simulation [s]."""

TAKE_OVER = 5.0
"""Time within which another candidate leads after the leader died [s]."""


class LeaseTable:
    """Store of one lease, which applies one change after another."""

    def __init__(self) -> None:
        self.lease = Lease("master")
        self.epochs = [0]

    def apply(self, request: Request) -> Lease | bool:
        """Apply a request; return the answer."""
        if isinstance(request, Read):
            return self.lease
        if self.lease != request.instead_of:
            return False
        assert (request.lease.epoch, request.lease.beat) > (self.lease.epoch, self.lease.beat)
        self.lease = request.lease
        if self.lease.epoch != self.epochs[-1]:
            self.epochs.append(self.lease.epoch)
        return True


@dataclass
class Flight:
    """A request on its way: steps until it is applied, until its answer is there, and what became of it."""

    request: Request
    to_store: int
    back: int
    lost: bool
    answer: Lease | bool | None = None


@dataclass
class Process:
    """A candidate with its own clock."""

    candidate: LeaseCandidate
    offset: float
    rate: float
    stopped: int = 0
    flight: Flight | None = None
    adrift: list[Flight] = field(default_factory=list)
    """Requests that count as failed and still reach the store."""

    def clock(self, now: float) -> float:
        """Return the time of this process."""
        return self.offset + now * self.rate

    def leads(self, now: float) -> bool:
        """Return whether it believes that it leads, running or not."""
        return self.candidate.leads(self.clock(now))


Fault = tuple[int, int, int, int, bool]
"""Process, steps for which it is stopped, steps to the store and back of its next request, whether that is lost."""

FAULTS = st.tuples(
    st.integers(0, 2), st.sampled_from([0, 0, 1, 20, 70, 400]), st.integers(0, 90), st.integers(0, 90), st.booleans()
)


class World:
    """Processes, a store and faults."""

    def __init__(self, clocks: list[tuple[float, float]]) -> None:
        self.now = 0.0
        self.table = LeaseTable()
        self.processes = [
            Process(LeaseCandidate("master", f"process {number}", offset, USUAL), offset, rate)
            for number, (offset, rate) in enumerate(clocks)
        ]
        self.next_flight: dict[int, tuple[int, int, bool]] = {}

    def strike(self, fault: Fault) -> None:
        """Stop a process, and disturb its next request."""
        process, stopped, *flight, lost = fault
        self.processes[process].stopped += stopped
        self.next_flight[process] = (flight[0], flight[1], lost)

    def step(self) -> None:
        """Let one step of time pass, and check that at most one process believes that it leads."""
        self.now += STEP
        for number, process in enumerate(self.processes):
            self._carry(process)
            if process.stopped > 0:
                process.stopped -= 1
            else:
                self._run(number, process)
            assert [one.leads(self.now) for one in self.processes].count(True) <= 1
        assert self.table.epochs == sorted(set(self.table.epochs))

    def _carry(self, process: Process) -> None:
        """Bring requests nearer to the store and answers back."""
        for flight in (*process.adrift, *([process.flight] if process.flight else [])):
            flight.to_store -= 1
            if flight.to_store == 0:
                flight.answer = self.table.apply(flight.request)
        process.adrift = [flight for flight in process.adrift if flight.to_store > 0]

    def _run(self, number: int, process: Process) -> None:
        clock = process.clock(self.now)
        flight = process.flight
        if flight is not None:
            flight.back -= flight.to_store <= 0
            if flight.back <= 0 or (flight.lost and flight.to_store <= 0):
                self._answer(process, flight, clock)
        request = process.candidate.next(clock)
        if request is not None:
            to_store, back, lost = self.next_flight.pop(number, (1, 1, False))
            process.flight = Flight(request, max(1, to_store), max(1, back), lost)

    def _answer(self, process: Process, flight: Flight, clock: float) -> None:
        process.flight = None
        if flight.lost or flight.answer is None:
            process.candidate.has_failed(clock)
            process.adrift.append(Flight(flight.request, 30, 0, lost=True))  # it may reach the store again, later
        elif isinstance(flight.answer, Lease):
            process.candidate.was_read(flight.answer, clock)
        else:
            process.candidate.was_changed(clock, done=flight.answer)

    def run(self, seconds: float) -> None:
        """Let time pass."""
        for _ in range(round(seconds / STEP)):
            self.step()


CLOCKS = st.lists(
    st.tuples(st.sampled_from([0.0, -3600.0, 3600.0, 1e9]), st.sampled_from([1.0, 0.97, 1.03])), min_size=3, max_size=3
)


@settings(max_examples=examples(60), deadline=None)
@given(CLOCKS, st.lists(st.tuples(st.integers(1, 120), FAULTS), max_size=40))
def test_never_two_lead_and_another_takes_over_within_the_time(
    clocks: list[tuple[float, float]], faults: list[tuple[int, Fault]]
) -> None:
    world = World(clocks)
    for steps, fault in faults:
        for _ in range(steps):
            world.step()
        world.strike(fault)
    for process in world.processes:
        process.stopped = 0
    world.next_flight.clear()
    world.run(10.0)  # requests of the faults arrive
    running = [process for process in world.processes if not process.candidate.is_over]
    leaders = [process for process in running if process.leads(world.now)]
    assert len(leaders) == 1 or not running
    for leader in leaders:
        leader.stopped = 10**9
        world.run(TAKE_OVER)
        assert any(process.leads(world.now) for process in running if process is not leader) or running == [leader]
        assert not leader.leads(world.now)
        leader.stopped = 0
        world.run(1.0)
        assert leader.candidate.role is Role.REPLACED or running == [leader]


def test_a_change_is_what_the_store_decides() -> None:
    table = LeaseTable()
    assert table.apply(Change(Lease("master", "a", 1), Lease("master"))) is True
    assert table.apply(Change(Lease("master", "b", 1), Lease("master"))) is False
    assert table.apply(Read("master")) == Lease("master", "a", 1)
