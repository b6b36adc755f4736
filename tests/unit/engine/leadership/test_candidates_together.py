"""Several candidates over one store, with pauses of any length, slow and lost answers, and clocks that disagree."""

from dataclasses import dataclass, field

from hypothesis import given, settings
from hypothesis import strategies as st

from engine.leadership.candidate import Candidate, Change, Read, Request, Role, Timing
from storage.records import Lease
from tests.support.budget import examples

TIMING = Timing()
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

    candidate: Candidate
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
            Process(Candidate("master", f"process {number}", offset, TIMING), offset, rate)
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
