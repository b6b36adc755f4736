"""Local node manager for programs: requests the homes of nodes, and reports where each node runs and why."""

from collections.abc import Callable, Mapping

from ppaas.errors import NotFound
from ppaas.messages.base.message import Empty
from ppaas.messages.ppaas_msgs import ListNodes, NodeHome, NodeHomes
from robots.client.robot_client import RobotClient
from robots.onboard.computer import Computer
from robots.onboard.node_manager import NODES, LocalNodes
from robots.onboard.task_group import run_together

AUTO = "auto"
"""Value of ``--local-nodes`` for all nodes, each in the home where it performs best."""


def parse_wanted_homes(text: str) -> dict[str, str]:
    """Return the requested home of each node, given ``auto`` or a comma-separated list of nodes; empty means the best.

    Raises
    ------
    NotFound
        A node cannot run on a robot.
    """
    if text.strip() == AUTO:
        return dict.fromkeys(NODES, "")
    names = [name.strip() for name in text.split(",")]
    for name in names:
        if name not in NODES:
            raise NotFound("local node", name, [AUTO, *NODES])
    return dict.fromkeys(names, "robot")


class PlacementReporter:
    """Reports where nodes run and why, once per node and again after each change.

    Parameters
    ----------
    report : callable
        Called with each sentence.
    """

    def __init__(self, report: Callable[[str], None]) -> None:
        self._report = report
        self._reported: dict[str, str] = {}

    def note(self, home: NodeHome) -> None:
        """Report a node, and its later changes."""
        text = sentence(home)
        if self._reported.get(home.node) != text:
            self._reported[home.node] = text
            self._report(text)

    def changed(self, homes: NodeHomes) -> None:
        """Report the changes of the nodes that were passed to ``note``."""
        for home in homes.nodes:
            if home.node in self._reported:
                self.note(home)


def sentence(home: NodeHome) -> str:
    """Return a sentence that states where a node runs, or is moving to, and why."""
    if home.home == home.wanted:
        place = "runs on the robot" if home.home == "robot" else "runs in the cloud"
    else:
        place = "moves to the robot" if home.wanted == "robot" else "moves back to the cloud"
    return f"{home.node} {place}: {'; '.join(home.reasons)}"


async def run_local_nodes(
    client: RobotClient, computer: Computer, wanted: Mapping[str, str], report: Callable[[str], None]
) -> None:
    """Run local nodes beside a client until cancelled; they then continue in the cloud.

    Parameters
    ----------
    client : RobotClient
        Connected client of the robot.
    computer : Computer
        The robot's computer.
    wanted : mapping of str to str
        Requested home of each node: ``robot``, or empty for the home where it performs best.
    report : callable
        Called with sentences that state where each node runs and why.

    Raises
    ------
    PPaaSError
        The robot's clone has no node monitor, or the client has failed.
    """
    reporter, manager = PlacementReporter(report), LocalNodes(client, computer)
    await client.subscribe("node_monitor/homes", NodeHomes, reporter.changed)

    async def request_homes() -> None:
        await manager.ready.wait()
        listed = await client.call("node_monitor/list_nodes", ListNodes, Empty())
        assert isinstance(listed, NodeHomes)
        existing = {known.node for known in listed.nodes}
        for node, home in wanted.items():
            if home or node in existing:  # not every clone has every node
                reporter.note(await manager.ask(node, home))

    await run_together(manager.run(), request_homes())
