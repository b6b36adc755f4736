"""What a runtime is."""

from typing import Protocol

from engine.model import Launch


class ContainerProcess(Protocol):
    """The process, or whatever a runtime has in its place, of one container."""

    @property
    def pid(self) -> int:
        """Its process id on this machine."""
        ...

    def kill(self) -> None:
        """End it by force; nothing happens where it is gone."""
        ...

    async def wait(self) -> int:
        """Return its exit status when it is gone, negative for the signal that killed it. May be asked by many."""
        ...


class Runtime(Protocol):
    """Starts containers on this machine."""

    async def start(self) -> None:
        """Warm up, so that the first container starts as fast as the others.

        Raises
        ------
        Unavailable
            It cannot run here; the text says why.
        """
        ...

    async def launch(self, launch: Launch) -> ContainerProcess:
        """Start a container; it is *ready* when it dials the robot link, not yet here.

        Raises
        ------
        Unavailable
            It could not be started now.
        """
        ...

    async def close(self) -> None:
        """End all containers by force and let go of everything."""
        ...
