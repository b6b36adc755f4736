"""Interface of runtimes, which start the containers of a machine."""

from abc import ABC, abstractmethod
from pathlib import Path
from typing import NamedTuple, Protocol

from engine.runtimes.entries import Entries
from engine.specs.containers import Launch


class Premises(NamedTuple):
    """The machine that a runtime runs on.

    Parameters
    ----------
    instance : str
        Name of the cloud process that this machine belongs to; unique on this computer.
    run_dir : Path
        Folder of the machine's Unix sockets; only its user may enter it.
    shared_memory : Path
        Folder of the map layers.
    image : str
        Image of the containers, for a runtime that uses images.
    entries : Entries
        Entry points of the processes that it starts.
    """

    instance: str
    run_dir: Path
    shared_memory: Path
    image: str = ""
    entries: Entries = Entries()


class ContainerProcess(Protocol):
    """The process of one container, or its equivalent in the runtime."""

    @property
    def pid(self) -> int:
        """Its process id on this machine."""
        ...

    def kill(self) -> None:
        """Kill it. Does nothing if it has exited."""
        ...

    def layers_grew(self) -> None:
        """Make files visible that were added to the layers of its map after the launch.

        Most runtimes have nothing to do here: their containers see the folder itself.
        """
        ...

    def endpoint_came(self) -> None:
        """Make the new socket visible that has replaced the one of its endpoint, under the same name.

        Most runtimes have nothing to do here: their containers find the socket by its name.
        """
        ...

    def resize(self, launch: Launch) -> None:
        """Limit it to the size and the CPUs of this launch from now on. Does nothing if it has exited."""
        ...

    async def wait(self) -> int:
        """Wait until it exits; return its exit status, negative for the signal that killed it.

        Several callers may wait at once.
        """
        ...


class Runtime(ABC):
    """Starts containers on this machine.

    Attributes
    ----------
    isolates : bool
        Whether a container sees no sockets of the machine but those that it is given.
    """

    isolates = False

    @classmethod
    @abstractmethod
    def on(cls, premises: Premises) -> "Runtime":
        """Return the runtime of a machine, not yet started.

        Raises
        ------
        Unavailable
            A dependency is not installed; the message says what to install.
        """

    @abstractmethod
    async def start(self) -> None:
        """Warm up, so that the first container starts as fast as the others.

        Raises
        ------
        Unavailable
            The runtime cannot run on this machine; the message says why.
        """

    @abstractmethod
    async def launch(self, launch: Launch) -> ContainerProcess:
        """Start a container. It is *ready* when it dials the robot link, which is later.

        Raises
        ------
        Unavailable
            The container could not be started now.
        """

    @abstractmethod
    async def close(self) -> None:
        """Kill all containers and release all resources."""
