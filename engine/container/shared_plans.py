"""Shared plans: finds stored plans of the container's map, and reports planning times to the machine."""

import asyncio
import logging
import threading
from collections import Counter, deque
from collections.abc import Callable, Sequence

from engine.container.machine_client import MachineClient
from engine.protocols.machine_link import stored_plan
from engine.specs.work_counts import ENDED, plan_counts
from ppaas.clock import Clock, epoch, monotonic
from ppaas.errors import PPaaSError
from ppaas.messages.actionlib_msgs import Status
from ppaas.plans.history import PlannerHistory
from ppaas.plans.reuse.time_estimates import Times
from ppaas.plans.stored import PlanQuery, StoredPlan

logger = logging.getLogger(__name__)


class SharedPlans:
    """A ``PlanLibrary`` over the machine link. Planning threads call it, and block; the event loop does not.

    Parameters
    ----------
    times : Times
        Measured times, to which the answers' times are added.
    elsewhere : callable
        Called on the loop's thread when a job would block there; the job is restarted in another thread.
    clock : callable
        Returns monotonic time [s].
    """

    def __init__(self, times: Times, elsewhere: Callable[[], None], clock: Clock = monotonic) -> None:
        self._times = times
        self._elsewhere = elsewhere
        self._clock = clock
        self._machine: tuple[MachineClient, asyncio.AbstractEventLoop, int] | None = None
        self._refused = False

    def ask(self, machine: MachineClient) -> None:
        """Query this machine from now on, on the running event loop."""
        self._machine = machine, asyncio.get_running_loop(), threading.get_ident()

    def may_wait(self) -> bool:
        """Return whether this thread may block; if not, its job is restarted in one that may."""
        if self._machine is None or self._machine[2] != threading.get_ident():
            return True
        self._elsewhere()
        return False

    def find(self, query: PlanQuery, within: float) -> Sequence[StoredPlan] | None:
        """Return plans that may be reused, best first; None if there is no answer within ``within`` seconds."""
        if self._machine is None:
            return ()
        machine, loop, _ = self._machine
        # The request is not cancelled after the time limit: its duration is still measured.
        asked = asyncio.run_coroutine_threadsafe(self._find(machine, query), loop)
        try:
            return asked.result(within)
        except TimeoutError:
            return None

    async def _find(self, machine: MachineClient, query: PlanQuery) -> list[StoredPlan]:
        began, size = self._clock(), 0
        try:
            found = await machine.find_plans(query)
            size = sum(len(candidate.plan.poses) for candidate in found)
        except PPaaSError as error:
            # Log it once: planning goes on without stored plans, and would fail here for every plan.
            logger.log(
                logging.DEBUG if self._refused else logging.WARNING,
                "stored plans cannot be queried; planning goes on without them: %s",
                error,
            )
            self._refused = True
            return []
        finally:
            self._times.link.note(size, self._clock() - began)
        self._refused = False
        return [stored_plan(candidate) for candidate in found]


class PlanningNotes:
    """Collects the outcomes of planning requests from any thread, and ends of goals, and reports them to the machine.

    Parameters
    ----------
    times : Times
        Measured times, initialised from the machine's history.
    """

    def __init__(self, times: Times) -> None:
        self._times = times
        self._rows: deque[PlannerHistory] = deque()
        self._counts: Counter[str] = Counter()
        self._link = ""
        self._reported = 0

    def __call__(self, row: PlannerHistory) -> None:
        """Record the outcome of a request; cheap, since a client waits: rows are summed up in ``tell``."""
        self._rows.append(row)

    def goal_ended(self, status: Status) -> None:
        """Count a goal of a client of the robot that has ended with this status."""
        self._counts[ENDED[status]] += 1

    async def begin(self, machine: MachineClient) -> None:
        """Initialise the measured times from the machine's history; without it, start with no measurements."""
        try:
            known = await machine.history()
        except PPaaSError as error:
            logger.warning("the planning history of this map is not available: %s", error)
            return
        self._link = known.link
        self._times.computation.add(known.rows)
        if known.measured is not None:
            self._times.link.start_from(known.measured)
        self._reported = self._times.link.answers

    def tell(self, machine: MachineClient) -> None:
        """Report to the machine what was recorded since the last call."""
        rows: dict[tuple[str, str, str, int], PlannerHistory] = {}
        while self._rows:
            row = self._rows.popleft()
            self._counts += plan_counts(row)
            known = rows.get(row.key)
            rows[row.key] = row if known is None else known.plus(row)
        link = self._times.link
        news = self._link and link.answers > self._reported
        self._reported = link.answers
        if rows or news or self._counts:
            counts, self._counts = self._counts, Counter()
            machine.note_history(list(rows.values()), link.history(self._link, epoch()) if news else None, counts)
