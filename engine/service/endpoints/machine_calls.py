"""Calls of the master about machines, and about the containers and endpoints that run on them."""

from typing import Protocol

from engine.service.views import ContainerView, EndpointView, MachineView
from engine.specs.machine_settings import MachineSettings


class MachineCalls(Protocol):
    """Machines of the cloud."""

    async def views(self) -> list[MachineView]:
        """Return all machines, and those that are about to join."""
        ...

    async def settings(self, machine: str) -> MachineSettings:
        """Return the settings of a machine.

        Raises
        ------
        NotFound
            The machine does not exist.
        Starting
            It has not joined yet.
        """
        ...

    async def configure(self, machine: str, settings: MachineSettings) -> None:
        """Apply and store settings of a machine.

        Raises
        ------
        InvalidParameter
            The settings are invalid.
        NotFound, Starting
            As ``settings``.
        Unavailable
            The settings are in effect, but could not be stored.
        """
        ...

    async def remove(self, machine: str, force: bool = False) -> None:
        """Disconnect a machine and refuse it until it is admitted.

        Raises
        ------
        Conflict
            It runs containers and ``force`` is false.
        NotFound, Starting
            As ``settings``.
        Unavailable
            The machine is removed, but this could not be stored.
        """
        ...

    async def admit(self, machine: str) -> None:
        """Accept a removed machine again; its agent must be started on the machine itself."""
        ...


class ContainerCalls(Protocol):
    """Containers that run on machines."""

    async def views(self, user: str | None) -> list[ContainerView]:
        """Return the containers of a user, or all containers with None."""
        ...

    async def give_up(self, container: str) -> None:
        """End a container as if it had died: its place gets another one, and clients notice only a pause.

        Raises
        ------
        NotFound
            The container does not exist or has ended.
        Unavailable
            Its machine is disconnected.
        """
        ...

    async def resize(self, container: str, cores: float) -> None:
        """Resize a running container [cores]; its place keeps the size while it is open.

        Raises
        ------
        NotFound
            The container does not exist or has ended.
        InvalidParameter
            The size is invalid.
        QuotaExceeded
            The size exceeds the quota of its user.
        Unavailable
            Its machine has no capacity for this size now.
        """
        ...


class NeighbourCalls(Protocol):
    """Endpoints of the cloud."""

    async def views(self) -> list[EndpointView]:
        """Return all endpoints that are connected to the master."""
        ...
