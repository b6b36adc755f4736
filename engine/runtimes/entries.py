"""Entry points of new processes, by name: the process that starts them must not import them.

The agent writes out the names (``engine.agent.entries``), since no runtime imports a container.
"""

from typing import NamedTuple


class Entry(NamedTuple):
    """A function that runs in a new process, and the modules that are imported first.

    Parameters
    ----------
    function : str
        ``"module:function"``.
    preload : tuple of str
        Modules to import first, in this order.
    freeze : str
        Module to import last in a fork server.
    """

    function: str
    preload: tuple[str, ...] = ()
    freeze: str = ""

    @property
    def of_fork_server(self) -> tuple[str, ...]:
        """The modules that a fork server imports, in order."""
        return (*self.preload, self.freeze) if self.freeze else self.preload


class Entries(NamedTuple):
    """Entry points of all kinds of processes that a machine starts.

    Parameters
    ----------
    container : Entry
        Takes a ``Launch``; its result is the exit status.
    maps : Entry
        Builds layers and indexes of maps, for a runtime that does not fork its containers on this machine.
    """

    container: Entry = Entry("")
    maps: Entry = Entry("")
