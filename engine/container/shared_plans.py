"""The plans that are kept for a map, as the container that stands in it finds them, and what it tells of planning."""

import asyncio
import logging
import threading
from collections import deque
from collections.abc import Callable, Sequence

from engine.container.machine_client import MachineClient
from engine.protocols.plan_candidates import stored_plan
from ppaas.clock import Clock, epoch, monotonic
from ppaas.errors import PPaaSError
from ppaas.plans.history import PlannerHistory
from ppaas.plans.reuse.measured_times import Times
from ppaas.plans.stored import PlanQuery, StoredPlan

logger = logging.getLogger(__name__)


class SharedPlans:
    """A ``PlanLibrary`` behind the machine link. It is asked by the threads that plan; they wait, the loop does not.

    Parameters
    ----------
    times : Times
        Where it is noted how long answers took.
    elsewhere : callable
        Called on the loop's thread by a job that would have to wait there: it is begun again in another thread.
    clock : callable
        Monotonic seconds.
    """

    def __init__(self, times: Times, elsewhere: Callable[[], None], clock: Clock = monotonic) -> None:
        self._times = times
        self._elsewhere = elsewhere
        self._clock = clock
        self._machine: tuple[MachineClient, asyncio.AbstractEventLoop, int] | None = None
        self._refused = False

    def ask(self, machine: MachineClient) -> None:
        """Ask this machine from now on, on the loop that runs here."""
        self._machine = machine, asyncio.get_running_loop(), threading.get_ident()

    def may_wait(self) -> bool:
        """Tell whether this thread may wait; if not, its job is begun again in one that may."""
        if self._machine is None or self._machine[2] != threading.get_ident():
            return True
        self._elsewhere()
        return False

    def find(self, query: PlanQuery, within: float) -> Sequence[StoredPlan] | None:
        """Return plans worth a look, the best first; None if there is no answer within so many seconds."""
        if self._machine is None:
            return ()
        machine, loop, _ = self._machine
        # An answer that comes too late is not waited for, but it is measured.
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
            # Told once: who plans on without them would say so with every plan.
            logger.log(logging.DEBUG if self._refused else logging.WARNING, "no kept plans can be found: %s", error)
            self._refused = True
            return []
        finally:
            self._times.link.note(size, self._clock() - began)
        self._refused = False
        return [stored_plan(candidate) for candidate in found]


class PlanningNotes:
    """Gathers what became of requests, and tells the machine when it is time; notes may come from any thread.

    Parameters
    ----------
    times : Times
        Which begin with what the machine knows.
    """

    def __init__(self, times: Times) -> None:
        self._times = times
        self._rows: deque[PlannerHistory] = deque()
        self._link = ""
        self._told = 0

    def __call__(self, row: PlannerHistory) -> None:
        """Take note of what became of a request; somebody waits for its answer, so it is added up when it is told."""
        self._rows.append(row)

    async def begin(self, machine: MachineClient) -> None:
        """Begin with what the machine knows; without it, everything is measured anew."""
        try:
            known = await machine.history()
        except PPaaSError as error:
            logger.warning("what is known of planning on this map is not here: %s", error)
            return
        self._link = known.link
        self._times.computation.add(known.rows)
        if known.measured is not None:
            self._times.link.start_from(known.measured)
        self._told = self._times.link.answers

    def tell(self, machine: MachineClient) -> None:
        """Tell the machine what was noted since the last time."""
        rows: dict[tuple[str, str, str, int], PlannerHistory] = {}
        while self._rows:
            row = self._rows.popleft()
            known = rows.get(row.key)
            rows[row.key] = row if known is None else known.plus(row)
        link = self._times.link
        news = self._link and link.answers > self._told
        self._told = link.answers
        if rows or news:
            machine.note_history(list(rows.values()), link.history(self._link, epoch()) if news else None)
