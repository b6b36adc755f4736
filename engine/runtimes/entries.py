"""What runs in new processes, by name: the process that starts them must not load it.

It is written out where the names are known, by the agent (``engine.agent.entries``): no runtime imports a container.
"""

from typing import NamedTuple


class Entry(NamedTuple):
    """A function that runs in a new process, and the modules that are loaded before.

    Parameters
    ----------
    function : str
        ``"module:function"``.
    preload : tuple of str
        Modules that are loaded first, in this order, by whatever is to become such a process.
    freeze : str
        Module that is loaded last where such processes are forked from what is loaded.
    """

    function: str
    preload: tuple[str, ...] = ()
    freeze: str = ""

    @property
    def of_fork_server(self) -> tuple[str, ...]:
        """The modules that a fork server loads, in order."""
        return (*self.preload, self.freeze) if self.freeze else self.preload


class Entries(NamedTuple):
    """What a machine runs in processes of their own.

    Parameters
    ----------
    container : Entry
        Takes a ``Launch``; its result is the exit status.
    maps : Entry
        Makes layers and indexes of maps, for a runtime whose containers are not forked on this machine.
    """

    container: Entry = Entry("")
    maps: Entry = Entry("")
