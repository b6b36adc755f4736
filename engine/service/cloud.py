"""The cloud as the endpoints know it: what they ask, each handed to the part of the engine that answers it."""

from engine.master.quotas import Quotas
from engine.service.master_driver import CloudService
from engine.service.path_requests import CostAnswer, CostRequest, PathAnswer, PathRequest
from engine.service.plan_rate import PlanRate
from engine.service.planning import Planning
from engine.service.robot_nodes import RobotNodes
from engine.service.views import ContainerView, MachineView
from engine.specs.containers import MapVersion
from engine.specs.machine_settings import MachineSettings
from ppaas.messages.ppaas_msgs import NodeHome
from storage.records import User


class Cloud:
    """Answers what the endpoints ask; see ``endpoints.services.control_plane.ControlPlane``.

    Parameters
    ----------
    driver : CloudService
        Knows machines and containers.
    quotas : Quotas
        What each user may have.
    """

    def __init__(self, driver: CloudService, quotas: Quotas) -> None:
        self.quotas = quotas
        self.plan_rate = PlanRate(quotas)
        self._driver = driver
        self._planning = Planning(driver)
        self._nodes = RobotNodes(driver)

    def close(self) -> None:
        """Forget what was to be closed later."""
        self._planning.close()

    def machines(self) -> list[MachineView]:
        """Return all machines."""
        return self._driver.machines()

    def machine_settings(self, machine: str) -> MachineSettings:
        """Return what an administrator says of a machine."""
        return self._driver.administration.settings(machine)

    def configure_machine(self, machine: str, settings: MachineSettings) -> None:
        """Take over what an administrator says of a machine."""
        self._driver.administration.configure(machine, settings)

    def remove_machine(self, machine: str, *, force: bool = False) -> None:
        """Cut a machine off, and let it in no more until it is admitted."""
        self._driver.administration.remove(machine, force=force)

    def admit_machine(self, machine: str) -> None:
        """Let a machine in again that was removed."""
        self._driver.administration.admit(machine)

    def containers(self, user: str | None) -> list[ContainerView]:
        """Return the containers of a user, or all."""
        return self._driver.containers(user)

    def give_up_container(self, container: str) -> None:
        """Have a container ended; its place gets another."""
        self._driver.give_up_container(container)

    def quotas_changed(self) -> None:
        """Serve whoever waits for what users may have now."""
        self._driver.quotas_changed()

    def resize_container(self, container: str, cores: float) -> None:
        """Give a container another size while it runs."""
        self._driver.resize_container(container, cores)

    async def node_homes(self, user: str, robot: str) -> list[NodeHome]:
        """Return where each node of a robot runs, and why."""
        return await self._nodes.homes(user, robot)

    async def run_node(self, user: str, robot: str, node: str, home: str) -> NodeHome:
        """Have a node of a robot run in a home, or where it does best."""
        return await self._nodes.run(user, robot, node, home)

    async def compute_path(self, user: User, map: MapVersion, request: PathRequest) -> PathAnswer:  # noqa: A002
        """Have a container plan a path."""
        return await self._planning.compute_path(user.id, map, request)

    async def compute_costs(self, user: User, map: MapVersion, request: CostRequest) -> CostAnswer:  # noqa: A002
        """Have a container tell what it costs from each start to each goal."""
        return await self._planning.compute_costs(user.id, map, request)
