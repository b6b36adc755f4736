"""Leadership of this process: takes and renews the lease of the master in the store, in a separate thread.

A mandate is the right to give orders, with the epoch that these orders are of. All processes that use one data folder
after each other have the same name as holders of the lease.
"""

import asyncio
import logging
import secrets
import socket
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Protocol, TypeVar

import msgspec

from engine.leadership.candidate import LeaseCandidate, LeaseTiming, Read, Request, Role
from engine.processes.private_files import write_private
from ppaas.clock import Clock, uptime
from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, Unavailable
from storage.ports import LeaseStore

logger = logging.getLogger(__name__)

T = TypeVar("T")


# -- mandate -----------------------------------------------------------------------------------------------------------


class Mandate(Protocol):
    """The right to give orders to machines."""

    @property
    def epoch(self) -> int:
        """Epoch of the orders: a later master has a later one."""
        ...

    def leads(self) -> bool:
        """Return whether orders may be given now."""
        ...

    def heard_of(self, epoch: int) -> None:
        """Take note of an epoch that a machine follows; a later one than this epoch means that another master leads."""
        ...


class SoleMaster:
    """Mandate of a master that shares its machines with no other, as in tests of parts of a cloud."""

    epoch = 0

    def leads(self) -> bool:
        """Return true."""
        return True

    def heard_of(self, epoch: int) -> None:
        """Do nothing."""


# -- lease -------------------------------------------------------------------------------------------------------------

MASTER = "master"
"""Name of the lease of the master."""

RELEASE_TIMEOUT = 2.0
"""Time that the store has to take the lease back at the end [s]; after that a standby waits for its patience."""

TIMING = LeaseTiming()
"""Periods of all masters of a cloud."""


class Leadership:
    """Candidacy of this process for the lease of the master; a ``Mandate``. Created within an event loop.

    Parameters
    ----------
    store : LeaseStore
        Store of the lease.
    holder : str
        Name of this process (``holder_of``).
    timing : LeaseTiming
        Periods.
    clock : callable
        Time [s], which advances while this process is stopped.

    Attributes
    ----------
    renewed : callable
        Called after each renewal: orders that waited for it may be given.
    """

    def __init__(self, store: LeaseStore, holder: str, timing: LeaseTiming = TIMING, clock: Clock = uptime) -> None:
        self._store = store
        self._clock = clock
        self._candidate = LeaseCandidate(MASTER, holder, clock(), timing)
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="lease")
        self._news = asyncio.Event()
        self._running: asyncio.Task[None] | None = None
        self._lapsed = False
        self.renewed: Callable[[], None] = lambda: None

    @property
    def epoch(self) -> int:
        """Epoch of this master."""
        return self._candidate.held.epoch

    @property
    def former(self) -> str:
        """Name of the holder from which the lease was taken without its consent; empty if there was none."""
        return self._candidate.former

    def leads(self) -> bool:
        """Return whether this process leads now; false also while the lease could not be renewed in time."""
        return self._candidate.leads(self._clock())

    def heard_of(self, epoch: int) -> None:
        """Take note of an epoch that a machine follows; a later one ends this leadership."""
        self._candidate.heard_of(epoch)
        self._news.set()

    async def acquire(self, *, standby: bool) -> None:
        """Return once this process leads; a standby waits for that as long as another one leads.

        Raises
        ------
        Unavailable
            Another process leads, and this one is no standby; or the store cannot be used.
        """
        self._running = asyncio.create_task(self._run(patient=standby))
        waiting = self._candidate
        while waiting.role is Role.WAITING and not self._running.done():
            if waiting.rival and not standby:
                raise Unavailable(
                    f"another cloud leads with this store, {waiting.rival}: stop it, choose another store with "
                    "--store, or start this one with --standby"
                )
            await self._wait_for_news(self._running)
        if self._running.done():
            await self._running

    async def lost(self) -> None:
        """Return once another process has replaced this one."""
        while self._running is not None and not self._running.done():
            await self._wait_for_news(self._running)
        if self._running is not None:
            await self._running

    async def release(self) -> None:
        """Lead no more, and let a standby lead at once."""
        try:
            async with asyncio.timeout(RELEASE_TIMEOUT):
                await self._give_back()
        except (Unavailable, TimeoutError) as error:
            logger.warning(
                "the lease was not released, so a standby waits: %s", str(error) or "the store did not answer"
            )
        finally:
            if self._running is not None:
                self._running.cancel()
                await asyncio.gather(self._running, return_exceptions=True)
            self._thread.shutdown(wait=False, cancel_futures=True)

    async def _give_back(self) -> None:
        while self._candidate.role is Role.LEADING:
            request = self._candidate.release()
            if request is not None:
                await self._in_thread(partial(self._store.change_lease, request.lease, instead_of=request.instead_of))
                return
            await self._wait_for_news(self._running)

    # -- requests ------------------------------------------------------------------------------------------------------

    async def _run(self, *, patient: bool) -> None:
        candidate = self._candidate
        while not candidate.is_over:
            request = candidate.next(self._clock())
            if request is None:
                await asyncio.sleep(max(0.0, candidate.due - self._clock()))
                continue
            try:
                await self._answer(request)
            except Unavailable as error:
                candidate.has_failed(self._clock())
                if candidate.role is Role.WAITING and not patient:
                    raise
                self._note_failure(error)
            else:
                self._note_renewal()
            self._news.set()

    async def _answer(self, request: Request) -> None:
        if isinstance(request, Read):
            lease = await self._in_thread(partial(self._store.lease, request.name))
            self._candidate.was_read(lease, self._clock())
        else:
            done = await self._in_thread(
                partial(self._store.change_lease, request.lease, instead_of=request.instead_of)
            )
            self._candidate.was_changed(self._clock(), done=done)

    async def _in_thread(self, call: Callable[[], T]) -> T:
        return await asyncio.get_running_loop().run_in_executor(self._thread, call)

    def _note_failure(self, error: Unavailable) -> None:
        if not self._lapsed:
            logger.error(
                "the lease of the master cannot be read or renewed, so that orders may have to wait: %s", error
            )
        self._lapsed = True

    def _note_renewal(self) -> None:
        if not self.leads():
            return
        if self._lapsed:
            logger.warning("the lease of the master is renewed: this process leads on, in epoch %d", self.epoch)
        self._lapsed = False
        self.renewed()

    async def _wait_for_news(self, running: asyncio.Task[None] | None) -> None:
        if running is None:
            return
        self._news.clear()
        waiting = asyncio.create_task(self._news.wait())
        await asyncio.wait((waiting, running), return_when=asyncio.FIRST_COMPLETED)
        waiting.cancel()


# -- name of the holder ------------------------------------------------------------------------------------------------

FILE = "lease-holder.json"
"""File in the data folder with its identity."""

LONGEST_HOST, LONGEST_FOLDER = 64, 128
"""Characters of host and folder in the name."""


class _Identity(msgspec.Struct, frozen=True):
    host: str
    folder: str
    id: str


def holder_of(data: Path) -> str:
    """Return the name of the process that owns a data folder.

    A copy of the folder, in another place or on another host, gets another identity, since the process that uses the
    original may still run.

    Raises
    ------
    InvalidInput
        The identity cannot be stored.
    """
    host, folder = socket.gethostname()[:LONGEST_HOST], str(data.resolve())
    known = _read(data / FILE)
    if known is None or (known.host, known.folder) != (host, folder):
        known = _Identity(host, folder, secrets.token_hex(4))
        try:
            write_private(data / FILE, msgspec.json.encode(known))
        except OSError as error:
            raise InvalidInput(f"cannot write the identity of the data folder: {error}") from error
    return f"{host}:{folder[-LONGEST_FOLDER:]}#{known.id}"


def _read(file: Path) -> _Identity | None:
    try:
        return from_json(file.read_bytes(), _Identity)
    except (OSError, msgspec.DecodeError):
        return None
