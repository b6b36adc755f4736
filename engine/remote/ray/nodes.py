"""The nodes of a Ray cluster, as far as machines are made of them."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from engine.specs.machine_settings import MOST_LABELS
from storage.names import is_name

NODE_LABEL = "ray.io/node-id"

MACHINE_NAME = 10
"""Characters of a node's id that its machine is called by: sockets are named after it, so it is short."""


@dataclass(frozen=True, slots=True)
class ClusterNode:
    """A node that lives.

    Parameters
    ----------
    id : str
        Never given to another node, nor to the same host when it joins again.
    address : str
        Of its host.
    cores : int
        CPUs that it brought, whole ones.
    free : int
        Those that no work in Ray holds.
    labels : dict of str to str
        That it was started with, and those that Ray gives to all, as a machine can have them.
    """

    id: str
    address: str
    cores: int
    free: int
    labels: dict[str, str] = field(default_factory=dict)

    @property
    def machine(self) -> str:
        """Name of the machine that it is."""
        return self.id[:MACHINE_NAME]


def read_nodes(table: Iterable[Mapping[str, Any]], free: Mapping[str, Mapping[str, float]]) -> list[ClusterNode]:
    """Return the nodes that can be machines: those that live and brought a whole CPU.

    Parameters
    ----------
    table : iterable of mappings
        As ``ray.nodes()`` tells of nodes, dead ones as well.
    free : mapping of str to mapping of str to float
        By id of a node, what is left of each of its resources.
    """
    nodes = []
    for row in table:
        cores = int(row["Resources"].get("CPU", 0.0))
        if row["Alive"] and cores >= 1:
            left = int(free.get(row["NodeID"], {}).get("CPU", 0.0))
            labels = machine_labels(row["Labels"])
            nodes.append(ClusterNode(row["NodeID"], row["NodeManagerAddress"], cores, left, labels))
    return nodes


def machine_labels(labels: Mapping[str, str]) -> dict[str, str]:
    """Return the labels of a node that a machine can have, with ``.`` for ``/``, but not that by which Ray names it.

    Ray's may be as long as those of Kubernetes, and empty; what does not fit is left out.
    """
    named = {key.replace("/", "."): value for key, value in labels.items() if key != NODE_LABEL}
    fitting = sorted((key, value) for key, value in named.items() if is_name(key) and is_name(value))
    return dict(fitting[:MOST_LABELS])
