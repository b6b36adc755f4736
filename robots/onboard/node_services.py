"""The services of local nodes, which the robot's client offers while they are on the robot."""

import logging

from ppaas.errors import Conflict
from ppaas.messages import Message, ServiceType, decode, encode, service_type
from robots.client.advertised_services import Handler
from robots.client.robot_client import RobotClient
from robots.onboard.executor import protocol
from robots.onboard.node_process import NodeProcess

logger = logging.getLogger(__name__)


class NodeServices:
    """Offers what local nodes can be asked, and lets their process answer.

    In the cloud a service of the clone goes before one of a client. So a node that goes on there serves at once, though
    the robot has not heard of it yet.

    Parameters
    ----------
    client : RobotClient
        Of the robot.
    """

    def __init__(self, client: RobotClient) -> None:
        self._client = client
        self._offered: dict[str, list[str]] = {}

    async def open(self, added: protocol.Added, process: NodeProcess) -> None:
        """Offer the services of a node.

        Raises
        ------
        PPaaSError
            The client has given up.
        """
        self._offered[added.node] = []
        for service in added.services:
            kind = service_type(service.type)
            try:
                await self._client.advertise_service(service.name, kind, _answering(process, service.name, kind))
            except Conflict as error:  # it is the robot's own, and not this node's
                logger.warning("%s cannot be asked on the robot: %s", added.node, error)
            else:
                self._offered[added.node].append(service.name)

    async def close(self, node: str) -> None:
        """Offer the services of a node no more.

        Raises
        ------
        PPaaSError
            The client has given up.
        """
        for service in self._offered.pop(node, ()):
            await self._client.unadvertise_service(service)


def _answering(process: NodeProcess, service: str, kind: ServiceType) -> Handler:
    async def answer(request: Message) -> Message:
        return decode(kind.response, await process.call(service, encode(request)))

    return answer
