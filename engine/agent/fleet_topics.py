"""Fleet topics: the topics that robots on one map share, published and received for the containers of a machine."""

import asyncio
import itertools
from collections.abc import Callable, Sequence
from functools import partial
from typing import Protocol

from engine.fabric.keys import COORDINATOR, TRAFFIC_NODE, Scope, addressed_key, parse_shared, shared_by_user, shared_key
from engine.protocols import machine_link
from engine.protocols.framing import FrameStream, pack
from engine.specs.containers import ContainerSpec, RobotConfig
from ppaas.clock import monotonic
from ppaas.errors import MessageTooLarge, NotPermitted
from ppaas.nodes.topics import PEOPLE_REPORT, PEOPLE_STATE, TOPICS, TRAFFIC_GRANTS, TRAFFIC_REPORT
from ppaas.people.names import hears_coordinator
from ppaas.traffic.taking_part import takes_part

# -- positions, received once for the machine --------------------------------------------------------------------------

PERIOD = 0.1
"""Smallest time between two batches [s]; a robot shares its position at most five times a second."""

MAX_WAITING = 1 << 18
"""Bytes queued for a slow container above which shared messages to it are dropped."""

MAX_BATCH = 1 << 16
"""Size of all messages of a batch above which it is not delayed [bytes]."""

Stream = FrameStream[machine_link.FromContainer]


class FabricSubscription(Protocol):
    """Subscription to a key expression."""

    def close(self) -> None:
        """End it."""
        ...


Subscribe = Callable[[Callable[[str, bytes], None]], FabricSubscription]
"""Subscribes to a key expression, with a callback for key and payload."""


class SharedPositions:
    """Messages on one key expression, for all containers of this machine that receive them.

    The first message after a pause is passed on at once. Of several messages of a robot in one batch, the last is
    passed on. A batch is the same for all containers, so a robot finds its own message in it.

    Parameters
    ----------
    subscribe : callable
        Subscribes to the key expression, while a container receives it.
    """

    def __init__(self, subscribe: Subscribe) -> None:
        self._subscribe = subscribe
        self._subscription: FabricSubscription | None = None
        self._numbers = itertools.count()
        self._hearers: dict[int, tuple[Scope, Stream]] = {}
        self._waiting: dict[tuple[str, str], machine_link.Shared] = {}
        self._size = 0
        self._passed_at = float("-inf")
        self._timer: asyncio.TimerHandle | None = None

    def add(self, scope: Scope, stream: Stream) -> Callable[[], None]:
        """Pass messages on to a container; return a function that ends it."""
        number = next(self._numbers)
        self._hearers[number] = scope, stream
        if self._subscription is None:
            self._subscription = self._subscribe(self._heard)
        return lambda: self._drop(number)

    def _drop(self, number: int) -> None:
        self._hearers.pop(number, None)
        if not self._hearers and self._subscription is not None:
            self._subscription.close()
            self._subscription = None
            self._begin_batch()

    def _begin_batch(self) -> list[machine_link.Shared]:
        batch, self._size = [*self._waiting.values()], 0
        self._waiting.clear()
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        return batch

    def _heard(self, key: str, payload: bytes) -> None:
        other = parse_shared(key)
        self._waiting[other.user, other.robot] = machine_link.Shared(other.user, other.robot, other.topic, payload)
        self._size += len(payload)
        pause = self._passed_at + PERIOD - monotonic()
        if pause <= 0.0 or self._size > MAX_BATCH:
            self._pass_on()
        elif self._timer is None:
            self._timer = asyncio.get_running_loop().call_later(pause, self._pass_on)

    def _pass_on(self) -> None:
        batch, self._passed_at = self._begin_batch(), monotonic()
        ready = [(scope, stream) for scope, stream in self._hearers.values() if stream.waiting <= MAX_WAITING]
        if len(batch) > 1:
            frame = pack(machine_link.SharedBatch(batch))
            for _, stream in ready:
                stream.write_packed(frame)
            return
        for message in batch:
            for scope, stream in ready:
                if (message.user, message.robot) != (scope.user, scope.robot):
                    stream.write(message)


# -- topics ------------------------------------------------------------------------------------------------------------

SHARED_TOPICS = tuple(topic.name for topic in TOPICS.values() if topic.shared)
"""Names of the topics that the robots on a map receive from each other."""

_NAMES = {"people": COORDINATOR, "traffic": TRAFFIC_NODE}

_REPORTS = {"people": PEOPLE_REPORT.name, "traffic": TRAFFIC_REPORT.name}
"""Names of the nodes of groups in keys, and the topics that they receive."""

MAX_SHARED = 1 << 16
"""Largest shared message [bytes]; it is sent to every robot on the map."""

MAX_STATE = 1 << 20
"""Largest state of the people on a map [bytes], for a thousand people; it is sent to the robots of one user."""


class _Hearing:
    def __init__(self, end: Callable[[], None]) -> None:
        self._end = end

    def close(self) -> None:
        """End it."""
        self._end()


class TopicFabric(Protocol):
    """Part of the fabric's session that fleet topics need."""

    def publish(self, key: str, payload: bytes) -> None:
        """Publish a payload; it may be lost."""
        ...

    def subscribe(self, key: str, callback: Callable[[str, bytes], None]) -> FabricSubscription:
        """Call ``callback`` with key and payload of each publication that matches a key expression."""
        ...


class FleetTopics:
    """Publisher and subscriber of shared topics for the containers of one machine.

    Parameters
    ----------
    fabric : TopicFabric
        Session on the fabric.
    """

    def __init__(self, fabric: TopicFabric) -> None:
        self._fabric = fabric
        self._positions: dict[str, SharedPositions] = {}

    def share(self, scope: Scope | None, frame: machine_link.FabricPublish) -> None:
        """Publish what a container shares with other robots on its map.

        Raises
        ------
        NotPermitted
            The container only plans, or addresses a robot without being a traffic node's.
        MessageTooLarge
            The payload is over `MAX_SHARED` bytes, or `MAX_STATE` for the state of people.
        """
        self._fabric.publish(_shared_key(frame, scope), frame.payload)

    def hear_others(
        self, scope: Scope | None, heard_keys: Sequence[str], stream: FrameStream[machine_link.FromContainer]
    ) -> list[FabricSubscription]:
        """Forward what others share to a container, until the returned subscriptions are closed.

        Parameters
        ----------
        scope : Scope or None
            Its scope; a container without one receives nothing.
        heard_keys : sequence of str
            Key expressions of what it receives, by ``heard_by``.
        stream : FrameStream
            Its machine link.
        """
        if scope is None:
            return []

        def heard(key: str, payload: bytes) -> None:
            other = parse_shared(key)
            itself = (other.user, other.robot) == (scope.user, scope.robot)
            if not itself and stream.waiting <= MAX_WAITING:
                stream.write(machine_link.Shared(other.user, other.robot, other.topic_for(scope.robot), payload))

        positions = {scope.shared_pattern(topic) for topic in SHARED_TOPICS}
        return [
            _Hearing(self._positions_on(key).add(scope, stream))
            if key in positions
            else self._fabric.subscribe(key, heard)
            for key in heard_keys
        ]

    def _positions_on(self, key: str) -> SharedPositions:
        if key not in self._positions:
            self._positions[key] = SharedPositions(partial(self._fabric.subscribe, key))
        return self._positions[key]


def _shared_key(frame: machine_link.FabricPublish, scope: Scope | None) -> str:
    if scope is None:
        raise NotPermitted("a container that only plans has no topics to share")
    most = MAX_STATE if frame.topic == PEOPLE_STATE.name else MAX_SHARED
    if len(frame.payload) > most:
        raise MessageTooLarge(f"a shared message may have up to {most} bytes, not {len(frame.payload)}")
    return scope.addressed_key(frame.topic, frame.addressee) if frame.addressee else scope.shared_key(frame.topic)


def scope_of(spec: ContainerSpec) -> Scope | None:
    """Return the scope in which a container may publish and subscribe.

    A robot that continues a published map shares with the robots on that map; one that makes a map from nothing with
    those whose maps may be joined with it. The node of a group shares with the robots of its user on the map. None if
    the container only plans.
    """
    if spec.group_node:
        return Scope(spec.user, _NAMES[spec.group_node], spec.map.id)
    if spec.robot is None:
        return None
    on = spec.robot.continued if spec.maps else spec.map
    return Scope(spec.user, spec.robot.id, spec.joint_map if on is None else on.id)


def heard_by(spec: ContainerSpec) -> list[str]:
    """Return the key expressions of what a container receives from others.

    The clone of a robot receives the topics that all robots on its map share. On a published map, it also receives the
    state of its user's coordinator if it has nodes for people, and the grants of its user's traffic node for it if it
    takes part in the traffic. The node of a group receives the reports of its user's robots on the map, and nobody else
    does. A traffic node also receives what all robots on the map share, since some take no part, and the state of its
    user's people coordinator.
    """
    scope = scope_of(spec)
    if scope is None:
        return []
    shared = [scope.shared_pattern(topic) for topic in SHARED_TOPICS]
    if spec.group_node:
        reports = shared_by_user(scope.map, scope.user, _REPORTS[spec.group_node])
        return [reports, *shared, _people_on(scope)] if spec.traffic else [reports]
    return shared if spec.robot is None or spec.maps else shared + _of_groups(spec.robot, scope)


def _people_on(scope: Scope) -> str:
    return shared_key(scope.map, scope.user, COORDINATOR, PEOPLE_STATE.name)


def _of_groups(robot: RobotConfig, scope: Scope) -> list[str]:
    keys = []
    if hears_coordinator(robot.parameters):
        keys.append(_people_on(scope))
    if takes_part(robot.parameters):
        keys.append(addressed_key(scope.map, scope.user, TRAFFIC_GRANTS.name, scope.robot))
    return keys
