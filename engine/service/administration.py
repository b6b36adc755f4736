"""Administration of machines while a cloud runs: settings, removal and admission."""

from collections.abc import Callable
from pathlib import Path

import msgspec

from engine.master.events import MachineAdmitted, RemovalRequested, SettingsChanged, SettingsLoaded
from engine.master.master import Master
from engine.master.orders import Order
from engine.processes.disk_notes import write_note
from engine.service.view_building import machine_view, starting_view
from engine.service.views import MachineView
from engine.specs.machine_settings import MachineSettings, check_settings
from engine.specs.start_state import StartState
from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, PPaaSError, Unavailable


class _Kept(msgspec.Struct, frozen=True):
    settings: dict[str, MachineSettings]
    removed: list[str]


class Administration:
    """Applies and stores the decisions of administrators about machines; implements ``MachineCalls``.

    Parameters
    ----------
    master : Master
        Master that the decisions are applied to.
    execute : callable
        Executes the master's orders.
    cut_off : callable
        Removes a machine, as it is requested, and closes its link.
    check_started : callable
        Raises ``Starting`` for a machine that has not joined yet but is about to.
    start_of : callable
        Returns the kernels that machines compile.
    """

    def __init__(
        self,
        master: Master,
        execute: Callable[[list[Order]], None],
        cut_off: Callable[[RemovalRequested], None],
        check_started: Callable[[str], None],
        start_of: Callable[[], StartState],
    ) -> None:
        self._master = master
        self._check_started = check_started
        self._start_of = start_of
        self._execute = execute
        self._cut_off = cut_off
        self._file: Path | None = None

    def keep_in(self, file: Path) -> None:
        """Load settings and removals from a file, and store later changes there.

        Raises
        ------
        InvalidInput
            The file is not valid.
        """
        self._file = file
        if not file.exists():
            return
        try:
            kept = from_json(file.read_bytes(), _Kept)
            settings = {machine: check_settings(said) for machine, said in kept.settings.items()}
        except (OSError, msgspec.DecodeError, UnicodeDecodeError, PPaaSError) as error:
            raise InvalidInput(
                f"{file} is not a valid file of machine settings: correct or delete it: {error}"
            ) from error
        self._execute(self._master.handle(SettingsLoaded(settings, tuple(kept.removed))))

    def _keep(self) -> None:
        if self._file is None:
            return
        try:
            write_note(self._file, _Kept(dict(self._master.settings), sorted(self._master.removed)))
        except OSError as error:
            raise Unavailable(
                f"the change is in effect, but it was not saved and is lost when the cloud ends: {error}"
            ) from error

    async def views(self) -> list[MachineView]:
        """Return all machines, and those that are about to join."""
        joined, kernels = self._master.machines, self._start_of().machines
        views = [machine_view(machine, kernels.get(machine.id)) for machine in joined.values()]
        return [*views, *(starting_view(name, kernels[name]) for name in kernels if name not in joined)]

    async def settings(self, machine: str) -> MachineSettings:
        """Return the settings of a machine that has joined."""
        self._check_started(machine)
        return self._master.machine(machine).settings

    async def configure(self, machine: str, settings: MachineSettings) -> None:
        """Apply and store settings of a machine that has joined."""
        self._check_started(machine)
        self._execute(self._master.handle(SettingsChanged(machine, settings)))
        self._keep()

    async def remove(self, machine: str, force: bool = False) -> None:
        """Disconnect a machine and refuse it until it is admitted again."""
        self._check_started(machine)
        self._cut_off(RemovalRequested(machine, force))
        self._keep()

    def is_removed(self, machine: str) -> bool:
        """Return whether a machine was removed and not admitted since."""
        return machine in self._master.removed

    async def admit(self, machine: str) -> None:
        """Accept a removed machine again."""
        if machine in self._master.removed:
            self._execute(self._master.handle(MachineAdmitted(machine)))
            self._keep()
