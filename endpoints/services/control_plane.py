"""Interface of the engine to the endpoints."""

from typing import Protocol

from engine.master.quotas import Quotas
from engine.service.path_requests import CostAnswer, CostRequest, PathAnswer, PathRequest
from engine.service.plan_rate import PlanRate
from engine.service.views import ContainerView, MachineView
from engine.specs.containers import MapVersion
from engine.specs.machine_settings import MachineSettings
from ppaas.messages.ppaas_msgs import NodeHome
from storage.records import User


class ControlPlane(Protocol):
    """What the endpoints ask of the engine. Its views are taken from memory and do not block."""

    @property
    def quotas(self) -> Quotas:
        """What each user may have."""
        ...

    @property
    def plan_rate(self) -> PlanRate:
        """How many paths each user may ask for."""
        ...

    def machines(self) -> list[MachineView]:
        """Return all machines."""
        ...

    def machine_settings(self, machine: str) -> MachineSettings:
        """Return what an administrator says of a machine; ``NotFound`` if there is none."""
        ...

    def configure_machine(self, machine: str, settings: MachineSettings) -> None:
        """Take over what an administrator says of a machine.

        Raises
        ------
        InvalidParameter
            It cannot be meant.
        NotFound
            There is no such machine.
        """
        ...

    def remove_machine(self, machine: str, *, force: bool = False) -> None:
        """Cut a machine off, and let it in no more until it is admitted.

        Raises
        ------
        Conflict
            It carries something, and it is not forced.
        NotFound
            There is no such machine.
        """
        ...

    def admit_machine(self, machine: str) -> None:
        """Let a machine in again that was removed."""
        ...

    def containers(self, user: str | None) -> list[ContainerView]:
        """Return the containers of a user, or all."""
        ...

    def give_up_container(self, container: str) -> None:
        """Have a container ended as if it had died: its place gets another.

        Raises
        ------
        NotFound
            There is no such container, or no longer.
        Unavailable
            Its machine is away.
        """
        ...

    def quotas_changed(self) -> None:
        """Serve whoever waits for what users may have now."""
        ...

    def resize_container(self, container: str, cores: float) -> None:
        """Give a container another size [cores] while it runs; its place keeps it while it is open.

        Raises
        ------
        NotFound
            There is no such container, or no longer.
        InvalidParameter, QuotaExceeded, Unavailable
            The size cannot be, its user may not have so much, or its machine has no room for it now.
        """
        ...

    async def node_homes(self, user: str, robot: str) -> list[NodeHome]:
        """Return where each node of a robot runs, and why; ``Unavailable`` where it has no container."""
        ...

    async def run_node(self, user: str, robot: str, node: str, home: str) -> NodeHome:
        """Have a node run in a home, or with none named where it does best.

        Raises
        ------
        NotFound
            The robot has no such node.
        Unavailable
            It has no container.
        """
        ...

    async def compute_path(self, user: User, map: MapVersion, request: PathRequest) -> PathAnswer:  # noqa: A002
        """Have a container plan a path.

        The caller has made sure that the user may read the map.

        Raises
        ------
        PlanningError
            There is no path; one of its subclasses.
        QuotaExceeded
            The user may not have another container.
        Unavailable
            No machine has room, or the container was lost.
        """
        ...

    async def compute_costs(self, user: User, map: MapVersion, request: CostRequest) -> CostAnswer:  # noqa: A002
        """Have a container tell what it costs from each start to each goal.

        Raises
        ------
        InvalidInput
            Too many starts or goals.
        PlanningError, QuotaExceeded, Unavailable
            As ``compute_path``.
        """
        ...
