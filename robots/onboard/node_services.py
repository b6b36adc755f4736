"""Services of local nodes, advertised by the robot's client while the nodes run on the robot."""

import logging

from ppaas.errors import Conflict
from ppaas.messages import Message, ServiceType, decode, encode, service_type
from robots.client.advertised_services import Handler
from robots.client.robot_client import RobotClient
from robots.onboard.executor import protocol
from robots.onboard.node_process import NodeProcess

logger = logging.getLogger(__name__)


class NodeServices:
    """Advertises the services of local nodes and forwards the calls to the executor process.

    In the cloud, a service of the clone takes precedence over one of a client. A node that continues there therefore
    serves at once, even before the robot has withdrawn the service.

    Parameters
    ----------
    client : RobotClient
        Client of the robot.
    """

    def __init__(self, client: RobotClient) -> None:
        self._client = client
        self._advertised: dict[str, list[str]] = {}

    async def open(self, added: protocol.Added, process: NodeProcess) -> None:
        """Advertise the services of a node.

        Raises
        ------
        PPaaSError
            The client has failed.
        """
        self._advertised[added.node] = []
        for service in added.services:
            kind = service_type(service.type)
            try:
                await self._client.advertise_service(service.name, kind, _forwarding(process, service.name, kind))
            except Conflict as error:  # the robot advertises a service of this name itself
                logger.warning("a service of %s is not available on the robot: %s", added.node, error)
            else:
                self._advertised[added.node].append(service.name)

    async def close(self, node: str) -> None:
        """Withdraw the services of a node.

        Raises
        ------
        PPaaSError
            The client has failed.
        """
        for service in self._advertised.pop(node, ()):
            await self._client.unadvertise_service(service)


def _forwarding(process: NodeProcess, service: str, kind: ServiceType) -> Handler:
    async def answer(request: Message) -> Message:
        return decode(kind.response, await process.call(service, encode(request)))

    return answer
