"""Clone service of a machine: stores the checkpoints and logs of clones for its containers.

A container only reaches the checkpoint of its own clone.
"""

from engine.protocols import machine_link
from engine.specs.checkpoints import log_name, marks, of_session
from engine.specs.containers import ContainerSpec
from ppaas.clock import epoch
from ppaas.errors import NotPermitted
from storage.ports import Store
from storage.records import CloneCheckpoint

LOG_PAGE = 16
"""Number of entries of a log that are read from the store at once."""

LOG_BYTES = 8 << 20
"""Size of an answer with entries of a log, about [bytes]."""


class CloneService:
    """Executes the clone requests of containers; its methods may block.

    Parameters
    ----------
    store : Store
        Store of checkpoints and logs.
    """

    def __init__(self, store: Store) -> None:
        self._store = store

    def save(self, spec: ContainerSpec, frame: machine_link.SaveClone, cloud: str) -> None:
        """Store a checkpoint, with changes of logs; ``cloud`` names the cloud process of the machine.

        Raises
        ------
        NotPermitted
            The container has no clone.
        """
        name = _checkpoint_name(spec)
        checkpoint = CloneCheckpoint(spec.user, name, frame.nodes | marks(spec, cloud), epoch())
        if not frame.changes:
            self._store.save_clone(checkpoint)
        for change in frame.changes:
            self._store.save_clone(checkpoint, of_session(spec, change))

    def log(self, spec: ContainerSpec, asked: machine_link.ReadLog) -> machine_link.LogRead:
        """Return entries of a node's log, about `LOG_BYTES` of them.

        Raises
        ------
        NotPermitted
            The container has no clone.
        """
        clone, name, entries = _checkpoint_name(spec), log_name(spec, asked.node), list[tuple[int, bytes]]()
        while sum(len(data) for _, data in entries) < LOG_BYTES:
            after = entries[-1][0] if entries else asked.after
            found = self._store.clone_log(spec.user, clone, name, after=after, limit=LOG_PAGE)
            entries += found
            if len(found) < LOG_PAGE:
                break
        return machine_link.LogRead(asked.request, entries)


def _checkpoint_name(spec: ContainerSpec) -> str:
    if not spec.checkpoint_name:
        raise NotPermitted("a planning container has no clone, so neither a checkpoint nor a log")
    return spec.checkpoint_name
