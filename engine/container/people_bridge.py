"""People bridge: passes reports from clones to the coordinator of their group, and its state to the clones."""

import logging

from engine.container.executor import NodeExecutor
from engine.container.machine_client import MachineClient
from engine.protocols import machine_link
from engine.specs.containers import Launch
from ppaas.errors import NotPermitted, PPaaSError
from ppaas.messages import decode, encode
from ppaas.messages.people_coordination import PeopleReport, PeopleState
from ppaas.nodes.base import Payload
from ppaas.nodes.topics import PEOPLE_REPORT, PEOPLE_STATE

logger = logging.getLogger(__name__)

REPORT_PERIOD = 0.05
"""Smallest time between two reports of a robot [s]; more frequent ones are dropped."""


class PeopleBridge:
    """Bridge between the graph of a container and its machine link, for people.

    A clone shares its reports, unless its robot makes a new map, and receives the state. A coordinator receives the
    reports, and shares the state. The machine decides which containers receive what.

    Parameters
    ----------
    launch : Launch
        Specification of the container.
    home : NodeExecutor
        Executor of the graph, with its nodes.
    machine : MachineClient
        The machine link.
    """

    def __init__(self, launch: Launch, home: NodeExecutor, machine: MachineClient) -> None:
        spec = launch.spec
        self._home, self._graph, self._machine = home, home.graph, machine
        self._heard = PEOPLE_STATE if spec.people is None else PEOPLE_REPORT
        self._last_report = float("-inf")
        self._refused: set[str] = set()
        if spec.people is not None:
            self._graph.tap(PEOPLE_STATE.name, self._share_state)
        elif spec.robot is not None and not spec.maps and PEOPLE_REPORT.name in self._graph.topics:
            self._graph.tap(PEOPLE_REPORT.name, self._share_report)

    def _share_report(self, topic: str, report: Payload) -> None:
        now = self._graph.elapsed()
        if now - self._last_report >= REPORT_PERIOD and isinstance(report, PeopleReport):
            self._last_report = now
            self._machine.share(topic, encode(report))

    def _share_state(self, topic: str, state: Payload) -> None:
        if isinstance(state, PeopleState):
            self._machine.share(topic, encode(state))

    def shared(self, message: machine_link.Shared) -> None:
        """Take a report or a state; messages of other topics are ignored.

        A report that is not valid, or names another robot than the one that shared it, is dropped. So is a message
        that a node refuses. The first one of each robot is logged.
        """
        if message.topic != self._heard.name or self._heard.name not in self._graph.topics:
            return
        try:
            content = decode(self._heard.type, message.payload)
            if isinstance(content, PeopleReport) and content.robot != message.robot:
                raise NotPermitted(f"it names robot {content.robot[:64]!r}")
            self._graph.inject(message.topic, content)
        except PPaaSError as error:
            self._log(message, str(error))
        except Exception as error:
            logger.debug("a message on %s caused an internal error in a node", message.topic, exc_info=True)
            self._log(message, f"internal error: {type(error).__name__}: {error}")
        else:
            self._refused.discard(message.robot)
        self._home.attend()

    def _log(self, message: machine_link.Shared, reason: str) -> None:
        level = logging.DEBUG if message.robot in self._refused else logging.WARNING
        logger.log(level, "a message on %s of %s is refused: %s", message.topic, message.robot, reason)
        self._refused.add(message.robot)
