"""From what checkpoint a container goes on, if from any."""

from collections.abc import Mapping

import msgspec

from engine.specs.containers import LINK_STATE, ORIGIN_STATE, SESSION_STATE, ContainerSpec, MapVersion, RobotConfig
from ppaas.clock import Clock, epoch
from ppaas.errors import NotFound
from storage.ports import Store
from storage.records import CloneCheckpoint


class Origin(msgspec.Struct, frozen=True):
    """What a checkpoint was made for, in which cloud process, and by which container."""

    instance: str
    map: MapVersion
    robot: RobotConfig | None
    container: str = ""


def marks(spec: ContainerSpec, instance: str) -> dict[str, bytes]:
    """Return what is kept with each checkpoint of a container, beside the state of its nodes."""
    origin = Origin(instance, spec.map, spec.robot, spec.id)
    return {SESSION_STATE: spec.session.encode(), ORIGIN_STATE: msgspec.json.encode(origin)}


class CheckpointSelection:
    """Gives containers the checkpoints of their clones. All of it may block.

    A container that replaces another goes on where that was. The first of a session begins as the robot's file says,
    but for two cases: the robot was let go because it was idle, or the cloud process that served it is gone and the
    robot is back as soon as if it had only lost its connection. Both go on from the last checkpoint, if robot and map
    are still what they were.

    Parameters
    ----------
    store : Store
        Has them.
    instance : str
        Name of this cloud process.
    within : float
        Seconds for which a checkpoint of a process that is gone is good.
    clock : callable
        Seconds since the epoch.
    """

    def __init__(self, store: Store, instance: str = "", within: float = 0.0, clock: Clock = epoch) -> None:
        self._store = store
        self._instance = instance
        self._within = within
        self._clock = clock
        self._parked: set[tuple[str, str]] = set()

    @property
    def instance(self) -> str:
        """Name of this cloud process."""
        return self._instance

    def park(self, user: str, robot: str) -> None:
        """Let the next session of a robot go on where this one ends."""
        self._parked.add((user, robot))

    def with_checkpoint(self, spec: ContainerSpec) -> ContainerSpec:
        """Return the spec of a container with the checkpoint that it goes on from."""
        if spec.robot is None:
            return spec
        parked = (spec.user, spec.robot.id) in self._parked
        self._parked.discard((spec.user, spec.robot.id))
        try:
            checkpoint = self._store.clone(spec.user, spec.robot.id)
        except NotFound:
            return spec
        if spec.id != spec.session:
            # One of a session before may still be kept by its last container, which ended late.
            same = checkpoint.nodes.get(SESSION_STATE) == spec.session.encode()
            return _with(spec, checkpoint.nodes) if same else spec
        if not (self._is_for(checkpoint, spec) and (parked or self._was_cut_off(checkpoint))):
            self._store.remove_clone(spec.user, spec.robot.id)
            return spec
        # The messages of this session are counted from the start.
        nodes = checkpoint.nodes | marks(spec, self._instance) | {LINK_STATE: b"0"}
        self._store.save_clone(msgspec.structs.replace(checkpoint, nodes=nodes))
        return _with(spec, nodes)

    def runs_on(self, spec: ContainerSpec) -> bool:
        """Tell whether a container that was started by another cloud process is the clone of its robot still.

        It is, if it kept the last checkpoint of the robot: what has taken its place since has kept one, too, and it
        had none to keep any more by then.
        """
        if spec.robot is None:
            return False
        try:
            checkpoint = self._store.clone(spec.user, spec.robot.id)
        except NotFound:
            return False
        origin = _origin_of(checkpoint)
        if origin is None or origin.instance == self._instance or origin.container != spec.id:
            return False
        return self._is_for(checkpoint, spec) and checkpoint.nodes.get(SESSION_STATE) == spec.session.encode()

    @staticmethod
    def _is_for(checkpoint: CloneCheckpoint, spec: ContainerSpec) -> bool:
        origin = _origin_of(checkpoint)
        return origin is not None and (origin.map, origin.robot) == (spec.map, spec.robot)

    def _was_cut_off(self, checkpoint: CloneCheckpoint) -> bool:
        origin = _origin_of(checkpoint)
        elsewhere = origin is not None and origin.instance != self._instance
        return elsewhere and 0.0 <= self._clock() - checkpoint.saved <= self._within


def _with(spec: ContainerSpec, nodes: Mapping[str, bytes]) -> ContainerSpec:
    return msgspec.structs.replace(spec, checkpoint=dict(nodes))


def _origin_of(checkpoint: CloneCheckpoint) -> Origin | None:
    try:
        return msgspec.json.decode(checkpoint.nodes.get(ORIGIN_STATE, b"null"), type=Origin | None)
    except msgspec.DecodeError:
        return None  # of a version of this program that wrote it otherwise
