"""Selection of the checkpoint that a container continues from."""

from collections.abc import Mapping

import msgspec

from engine.specs.containers import (
    LINK_STATE,
    LOG_STATE,
    MOVED_STATE,
    ORIGIN_STATE,
    SESSION_STATE,
    SESSIONS_STATE,
    ContainerSpec,
    MapVersion,
    RobotConfig,
)
from engine.specs.robot_stops import stops_of_robot, stored_stops
from ppaas.clock import Clock, epoch
from ppaas.decoding import from_json
from ppaas.errors import NotFound
from storage.ports import Store
from storage.records import CloneCheckpoint, CloneLogChange


class CheckpointOrigin(msgspec.Struct, frozen=True):
    """Origin of a checkpoint: cloud process, map version, robot and container."""

    instance: str
    map: MapVersion
    robot: RobotConfig | None
    container: str = ""


def marks(spec: ContainerSpec, instance: str) -> dict[str, bytes]:
    """Return the entries that each checkpoint of a container has beside the states of its nodes."""
    origin = CheckpointOrigin(instance, spec.map, _without_urdf(spec.robot), spec.id)
    begun = {SESSION_STATE: spec.session.encode(), ORIGIN_STATE: msgspec.json.encode(origin)}
    return begun | ({LOG_STATE: spec.checkpoint[LOG_STATE]} if LOG_STATE in spec.checkpoint else {})


def log_name(spec: ContainerSpec, node: str) -> str:
    """Return the name of the log of a node in the store: of the session, or of the one that it continues."""
    return f"{spec.checkpoint.get(LOG_STATE, spec.session.encode()).decode()}/{node}"


def of_session(spec: ContainerSpec, change: CloneLogChange) -> CloneLogChange:
    """Return the change of the log of a node, by the name of the log in the store."""
    return msgspec.structs.replace(change, log=log_name(spec, change.log))


class CheckpointSelection:
    """Selects the checkpoint of each new container. All methods may block.

    A container that replaces another continues from its checkpoint. The first container of a session starts from the
    robot's configuration, with two exceptions: the robot lost its place because it was idle; or the cloud process that
    served it has died, and the robot is back as soon as after a lost connection. Both continue from the last
    checkpoint, if the robot and its map are unchanged; the versions of map and masks may be others, as while it drives.

    A robot that has moved to another map meanwhile continues at the pose of its configuration, without what belongs to
    the map before.

    The nodes of groups always continue from the last checkpoint of their group: people coordinators, so that no
    identity is used twice, and traffic nodes, so that no epoch is. Coordinators get the settings that are stored when
    they start, and robots their stops.

    Parameters
    ----------
    store : Store
        Store of the checkpoints.
    instance : str
        Instance name of this cloud process.
    within : float
        Time for which a checkpoint of a dead cloud process is valid [s].
    clock : callable
        Time [s since the epoch].
    """

    def __init__(self, store: Store, instance: str = "", within: float = 0.0, clock: Clock = epoch) -> None:
        self._store = store
        self._instance = instance
        self._within = within
        self._clock = clock
        self._parked: set[tuple[str, str]] = set()

    @property
    def instance(self) -> str:
        """Instance name of this cloud process."""
        return self._instance

    def park(self, user: str, robot: str) -> None:
        """Make the next session of a robot continue from the last checkpoint of this one."""
        self._parked.add((user, robot))

    def with_checkpoint(self, spec: ContainerSpec) -> ContainerSpec:
        """Return the spec of a container with its checkpoint, if there is one to continue from."""
        name = spec.checkpoint_name
        if not name:
            return spec
        if spec.people is not None:
            settings = self._store.map_people(spec.user, spec.map.id).settings
            spec = msgspec.structs.replace(spec, people=settings)
        if spec.robot is not None:
            stops = stops_of_robot(stored_stops(self._store, spec.user), spec.robot.id, spec.map.id)
            spec = msgspec.structs.replace(spec, stops=stops)
        lasting = spec.group_node != "" or (spec.user, name) in self._parked
        idle = (spec.user, name) in self._parked
        self._parked.discard((spec.user, name))
        try:
            checkpoint = self._store.clone(spec.user, name)
        except NotFound:
            return spec
        if spec.id != spec.session:
            # The last container of an earlier session may have stored one, if it exited late.
            same = checkpoint.nodes.get(SESSION_STATE) == spec.session.encode()
            return _with(spec, self._moved(checkpoint, spec)) if same else spec
        if not (self._is_for(checkpoint, spec) and (lasting or self._was_cut_off(checkpoint))):
            self._store.remove_clone(spec.user, name)
            return spec
        # The sequence numbers of a new session start again.
        nodes = _on_map_of(spec, checkpoint) | marks(spec, self._instance) | {LINK_STATE: b"0"}
        if idle:
            nodes.pop(SESSIONS_STATE, None)  # their clients were disconnected
        nodes[LOG_STATE] = checkpoint.nodes.get(LOG_STATE, checkpoint.nodes.get(SESSION_STATE, b""))
        self._store.save_clone(msgspec.structs.replace(checkpoint, nodes=nodes))
        return _with(spec, nodes)

    def _moved(self, checkpoint: CloneCheckpoint, spec: ContainerSpec) -> dict[str, bytes]:
        """Return the states of a checkpoint of this session; if its robot has moved since, that is stored first.

        So a container that is lost before it has stored anything is followed by one that knows of the move.
        """
        nodes = _on_map_of(spec, checkpoint)
        if MOVED_STATE in nodes and MOVED_STATE not in checkpoint.nodes:
            nodes |= marks(spec, self._instance)
            self._store.save_clone(msgspec.structs.replace(checkpoint, nodes=nodes))
        return nodes

    def runs_on(self, spec: ContainerSpec) -> bool:
        """Return whether a container of another cloud process is still the current one of its robot or group.

        It is if it stored the last checkpoint: a container that has replaced it would have stored a later one.
        """
        if not spec.checkpoint_name:
            return False
        try:
            checkpoint = self._store.clone(spec.user, spec.checkpoint_name)
        except NotFound:
            return False
        origin = _origin_of(checkpoint)
        # A master that kept running has replaced what it lost, so it takes nothing back.
        if origin is None or origin.instance == self._instance or origin.container != spec.id:
            return False
        same = origin.map.id == spec.map.id and checkpoint.nodes.get(SESSION_STATE) == spec.session.encode()
        return same and self._is_for(checkpoint, spec)

    @staticmethod
    def _is_for(checkpoint: CloneCheckpoint, spec: ContainerSpec) -> bool:
        origin = _origin_of(checkpoint)
        if origin is None or _lasting(origin.robot) != _lasting(spec.robot):
            return False
        # A robot on a published map may have moved to another one, whatever its version.
        return origin.map.id == spec.map.id or (spec.robot is not None and not spec.robot.new_map)

    def _was_cut_off(self, checkpoint: CloneCheckpoint) -> bool:
        origin = _origin_of(checkpoint)
        elsewhere = origin is not None and origin.instance != self._instance
        return elsewhere and 0.0 <= self._clock() - checkpoint.saved <= self._within


def _without_urdf(robot: RobotConfig | None) -> RobotConfig | None:
    return None if robot is None else msgspec.structs.replace(robot, urdf_text=b"")


def _lasting(robot: RobotConfig | None) -> RobotConfig | None:
    """Return a configuration without the text of the URDF and without what depends on the map, or on its version."""
    if robot is None:
        return None
    continued = None if robot.continued is None else msgspec.structs.replace(robot.continued, version="")
    kept = msgspec.structs.replace(robot, urdf_text=b"", in_space=False, continued=continued, map_owner="")
    return kept if robot.new_map else kept.anywhere


def _on_map_of(spec: ContainerSpec, checkpoint: CloneCheckpoint) -> dict[str, bytes]:
    """Return the states of a checkpoint, marked if the robot has moved to another map or was put elsewhere since."""
    origin, robot = _origin_of(checkpoint), spec.robot
    if robot is None or origin is None or origin.robot is None or MOVED_STATE in checkpoint.nodes:
        return checkpoint.nodes
    stays = (origin.map.id, origin.robot.initial_pose) == (spec.map.id, robot.initial_pose)
    return checkpoint.nodes if stays else checkpoint.nodes | {MOVED_STATE: b"1"}


def _with(spec: ContainerSpec, nodes: Mapping[str, bytes]) -> ContainerSpec:
    return msgspec.structs.replace(spec, checkpoint=dict(nodes))


def _origin_of(checkpoint: CloneCheckpoint) -> CheckpointOrigin | None:
    try:
        return from_json(checkpoint.nodes.get(ORIGIN_STATE, b"null"), CheckpointOrigin | None)
    except msgspec.DecodeError:
        return None  # written by another release of this program
