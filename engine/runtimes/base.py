"""What a runtime is."""

from abc import ABC, abstractmethod
from pathlib import Path
from typing import NamedTuple, Protocol

from engine.runtimes.entries import Entries
from engine.specs.containers import Launch


class Premises(NamedTuple):
    """What a runtime is told of the machine that it runs on.

    Parameters
    ----------
    instance : str
        Name of the cloud process whose machine this is; no other on this computer has it.
    run_dir : Path
        Folder of the machine's Unix sockets, which its user alone may enter.
    shared_memory : Path
        Folder in which the layers of maps lie.
    image : str
        Image that containers run from, for a runtime that has images.
    entries : Entries
        What runs in the processes that it starts.
    """

    instance: str
    run_dir: Path
    shared_memory: Path
    image: str = ""
    entries: Entries = Entries()


class ContainerProcess(Protocol):
    """The process, or whatever a runtime has in its place, of one container."""

    @property
    def pid(self) -> int:
        """Its process id on this machine."""
        ...

    def kill(self) -> None:
        """End it by force; nothing happens where it is gone."""
        ...

    def layers_grew(self) -> None:
        """Let it see what was put beside the layers of its map after it was launched; for most it is there already."""
        ...

    def endpoint_came(self) -> None:
        """Let it reach who listens anew under the name of its endpoint's socket; for most it is so already."""
        ...

    def resize(self, launch: Launch) -> None:
        """Hold it to another size from now on: that of this launch, on its CPUs; nothing happens where it is gone."""
        ...

    async def wait(self) -> int:
        """Return its exit status when it is gone, negative for the signal that killed it. May be asked by many."""
        ...


class Runtime(ABC):
    """Starts containers on this machine."""

    @classmethod
    @abstractmethod
    def on(cls, premises: Premises) -> "Runtime":
        """Return the runtime of a machine, not yet started.

        Raises
        ------
        Unavailable
            What it needs is not installed; the text says what to install.
        """

    @abstractmethod
    async def start(self) -> None:
        """Warm up, so that the first container starts as fast as the others.

        Raises
        ------
        Unavailable
            It cannot run here; the text says why.
        """

    @abstractmethod
    async def launch(self, launch: Launch) -> ContainerProcess:
        """Start a container; it is *ready* when it dials the robot link, not yet here.

        Raises
        ------
        Unavailable
            It could not be started now.
        """

    @abstractmethod
    async def close(self) -> None:
        """End all containers by force and let go of everything."""
