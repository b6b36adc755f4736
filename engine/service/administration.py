"""What administrators do with machines while a cloud runs."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

import msgspec

from engine.master.master import Master
from engine.master.orders import Order
from engine.processes.disk_notes import write_note
from engine.specs.machine_settings import MachineSettings, check_settings
from ppaas.errors import InvalidInput, PPaaSError, Unavailable

Losing = Callable[[str], list[Order]]
"""Takes a machine out of the books; returns what is to be done about what it carried."""


class _Kept(msgspec.Struct, frozen=True):
    settings: dict[str, MachineSettings]
    removed: list[str]


class Administration:
    """Hands to the master what administrators say.

    Parameters
    ----------
    master : Master
        Decides.
    execute : callable
        Carries out what it orders.
    cut_off : callable
        Hangs up on a machine that is lost so.
    """

    def __init__(
        self, master: Master, execute: Callable[[list[Order]], None], cut_off: Callable[[str, Losing], None]
    ) -> None:
        self._master = master
        self._execute = execute
        self._cut_off = cut_off
        self._file: Path | None = None

    def keep_in(self, file: Path) -> None:
        """Go on with what a file has kept, and keep in it what is said from now on.

        Raises
        ------
        InvalidInput
            The file is not what was written.
        """
        self._file = file
        if not file.exists():
            return
        try:
            kept = msgspec.json.decode(file.read_bytes(), type=_Kept)
            settings = {machine: check_settings(said) for machine, said in kept.settings.items()}
        except (OSError, msgspec.DecodeError, UnicodeDecodeError, PPaaSError) as error:
            raise InvalidInput(f"{file} is not what was kept of machines: mend it, or remove it: {error}") from error
        self._master.settings.update(settings)
        self._master.removed.update(kept.removed)

    def _keep(self) -> None:
        if self._file is None:
            return
        try:
            write_note(self._file, _Kept(self._master.settings, sorted(self._master.removed)))
        except OSError as error:
            raise Unavailable(f"it is done, but will be forgotten when the cloud ends: {error}") from error

    def settings(self, machine: str) -> MachineSettings:
        """Return what an administrator says of a machine; ``NotFound`` if there is none."""
        return self._master.machine(machine).settings

    def configure(self, machine: str, settings: MachineSettings) -> None:
        """Take over what an administrator says of a machine.

        Raises
        ------
        InvalidParameter, NotFound
            As the master says.
        Unavailable
            It is done, but could not be kept.
        """
        self._execute(self._master.configure(machine, settings))
        self._keep()

    def remove(self, machine: str, *, force: bool = False) -> None:
        """Cut a machine off, and let it in no more until it is admitted.

        Raises
        ------
        Conflict, NotFound
            As the master says.
        Unavailable
            It is done, but could not be kept.
        """
        self._cut_off(machine, partial(self._master.remove, force=force))
        self._keep()

    def admit(self, machine: str) -> None:
        """Let a machine in again that was removed; its agent is started by whoever runs it."""
        if machine in self._master.removed:
            self._master.admit(machine)
            self._keep()
