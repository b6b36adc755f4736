"""What administrators do with machines while a cloud runs."""

from collections.abc import Callable
from functools import partial

from engine.machine_settings import MachineSettings
from engine.master import Master
from engine.orders import Order

Losing = Callable[[str], list[Order]]
"""Takes a machine out of the books; returns what is to be done about what it carried."""


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

    def settings(self, machine: str) -> MachineSettings:
        """Return what an administrator says of a machine; ``NotFound`` if there is none."""
        return self._master.machine(machine).settings

    def configure(self, machine: str, settings: MachineSettings) -> None:
        """Take over what an administrator says of a machine.

        Raises
        ------
        InvalidParameter, NotFound
            As the master says.
        """
        self._execute(self._master.configure(machine, settings))

    def remove(self, machine: str, *, force: bool = False) -> None:
        """Cut a machine off, and let it in no more until it is admitted.

        Raises
        ------
        Conflict, NotFound
            As the master says.
        """
        self._cut_off(machine, partial(self._master.remove, force=force))

    def admit(self, machine: str) -> None:
        """Let a machine in again that was removed; its agent is started by whoever runs it."""
        self._master.admit(machine)
