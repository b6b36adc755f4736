"""A local node manager as programs run it: it has nodes where they are wanted, and tells where each runs and why."""

from collections.abc import Callable, Mapping

from ppaas.errors import NotFound
from ppaas.messages.message import Empty
from ppaas.messages.ppaas_msgs import ListNodes, NodeHome, NodeHomes
from robots.client.robot_client import RobotClient
from robots.onboard.computer import Computer
from robots.onboard.node_manager import NODES, LocalNodes
from robots.onboard.task_group import together

AUTO = "auto"
"""In place of names: all nodes, each where it does best."""


def wanted_homes(text: str) -> dict[str, str]:
    """Return the home to ask for by node, empty for the best, from ``auto`` or names of nodes with commas between.

    Raises
    ------
    NotFound
        A node that no robot can run.
    """
    if text.strip() == AUTO:
        return dict.fromkeys(NODES, "")
    names = [name.strip() for name in text.split(",")]
    for name in names:
        if name not in NODES:
            raise NotFound("local node", name, [AUTO, *NODES])
    return dict.fromkeys(names, "robot")


class ToldHomes:
    """Tells where nodes run and why: of each once, and again whenever that changes.

    Parameters
    ----------
    tell : callable
        Takes each sentence.
    """

    def __init__(self, tell: Callable[[str], None]) -> None:
        self._tell = tell
        self._told: dict[str, str] = {}

    def note(self, home: NodeHome) -> None:
        """Take what is known of a node, which is of interest from now on."""
        text = sentence(home)
        if self._told.get(home.node) != text:
            self._told[home.node] = text
            self._tell(text)

    def changed(self, homes: NodeHomes) -> None:
        """Take what is known of all nodes."""
        for home in homes.nodes:
            if home.node in self._told:
                self.note(home)


def sentence(home: NodeHome) -> str:
    """Return where a node runs, or is about to, and why."""
    if home.home == home.wanted:
        what = "runs on the robot" if home.home == "robot" else "runs in the cloud"
    else:
        what = "goes to the robot" if home.wanted == "robot" else "goes back to the cloud"
    return f"{home.node} {what}: {'; '.join(home.reasons)}"


async def run_local_nodes(
    client: RobotClient, computer: Computer, wanted: Mapping[str, str], tell: Callable[[str], None]
) -> None:
    """Run nodes beside a client until cancelled; then all goes on in the cloud.

    Parameters
    ----------
    client : RobotClient
        Of the robot, open.
    computer : Computer
        What it has to run them on.
    wanted : mapping of str to str
        The nodes to ask for, and the home of each: ``robot``, or empty for where it does best.
    tell : callable
        Told in sentences where each runs and why.

    Raises
    ------
    PPaaSError
        The cloud has no node monitor for this robot, or the client has given up.
    """
    told, manager = ToldHomes(tell), LocalNodes(client, computer)
    await client.subscribe("node_monitor/homes", NodeHomes, told.changed)

    async def ask() -> None:
        await manager.ready.wait()
        listed = await client.call("node_monitor/list_nodes", ListNodes, Empty())
        assert isinstance(listed, NodeHomes)
        there = {known.node for known in listed.nodes}
        for node, home in wanted.items():
            if home or node in there:  # of all nodes that robots run, only those that this one's clone has
                told.note(await manager.ask(node, home))

    await together(manager.run(), ask())
