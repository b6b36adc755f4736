"""Watch over the disk of the data folder: it keeps the reserve, and logs when space runs out and when it is back."""

import asyncio
import logging
from collections.abc import Callable
from functools import partial

from engine.processes.background import repeat
from engine.processes.occasional_log import OccasionalLog
from storage.disk_space.reserve import DiskReserve, SpaceState
from storage.ports import Store

logger = logging.getLogger(__name__)

PERIOD = 1.0
"""Time between two checks [s]."""

LOW_TEXT = "the disk of the data folder has little space left (%d MiB): free space before it is full"
FULL_TEXT = (
    "the disk of the data folder is FULL (%d MiB left): nothing new is stored until there is space again; remove maps, "
    "plans or users, or free space otherwise"
)


class DiskWatch:
    """Watches the disk of a cloud.

    Parameters
    ----------
    reserve : DiskReserve, optional
        Reserve of the cloud's data folder, which this process owns; None to watch nothing.
    make_room : callable
        Called in a thread when the disk becomes full: frees space that the stores do not need.
    """

    def __init__(self, reserve: DiskReserve | None, make_room: Callable[[], None] = lambda: None) -> None:
        self._reserve = reserve
        self._make_room = make_room
        self._last: SpaceState = "ok"
        self._logs = {"low": OccasionalLog(logger, 24 * 3600.0), "full": OccasionalLog(logger)}

    @classmethod
    def of(cls, reserve: DiskReserve | None, store: Store) -> "DiskWatch":
        """Return the watch of a cloud, which empties the log of its store to make room if the store has one."""
        return cls(reserve, getattr(store, "shrink_log", lambda: None))

    async def run(self) -> None:
        """Check the disk until cancelled."""
        if self._reserve is not None:
            await repeat(partial(asyncio.to_thread, self.check), PERIOD)

    def check(self) -> SpaceState:
        """Check the disk once; return its state. Blocks."""
        if self._reserve is None:
            return self._last
        try:
            state = self._reserve.keep()
            free = self._reserve.space().free >> 20
        except OSError as error:
            self._logs["full"].warning("the disk of the data folder cannot be measured: %s", error)
            return self._last
        if state == "full" and self._last != "full":
            self._make_room()
        if state != "ok":
            self._logs[state].warning(FULL_TEXT if state == "full" else LOW_TEXT, free)
        for name in ("full", "low"):
            if state not in (name, "full"):
                self._logs[name].is_over(f"the disk of the data folder is not {name} any more")
        self._last = state
        return state
