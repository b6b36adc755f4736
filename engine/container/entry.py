"""Entry of a container: runs a clone, planning on a map, or the node of a group, with its robot link and machine link.

The runtime calls ``main`` in the new process. It connects to the endpoint, opens the map's layers, builds the graph,
restores the checkpoint and connects to its machine. After its hello to the endpoint, the container handles frames.
"""

import asyncio
import logging
import os
from collections.abc import Callable, Coroutine, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import uvloop

from engine.container.container import Container, sessions_of
from engine.container.current_map import CurrentMap
from engine.container.endpoint_links import EndpointLink, Stream, dial
from engine.container.executor import NodeExecutor
from engine.container.fleet_bridge import FleetBridge, RobotIsHere
from engine.container.graph_building import Attendants, build_graph
from engine.container.group_bridges import GroupBridge, people_bridge, traffic_bridge
from engine.container.kernel_gate import CompileNotice, KernelGate, KernelsMissing, await_kernels
from engine.container.machine_client import MachineClient
from engine.container.monitor.setup import ContainerMonitor
from engine.container.shared_plans import PlanningNotes, SharedPlans
from engine.container.spans import hand_over_spans, keep_spans
from engine.protocols import machine_link, robot_link
from engine.protocols.refusals import refusal_of
from engine.runtimes.compilation.threading_layer import KernelThreads, use_threads
from engine.sessions.host import SessionHost
from engine.specs.containers import MOVED_STATE, Launch
from engine.specs.start_state import KERNEL_PATIENCE
from ppaas.clock import epoch
from ppaas.errors import InvalidInput, PPaaSError
from ppaas.listener_faults import ListenerFaults
from ppaas.log_lines import log_fields, log_lines
from ppaas.nodes.base import Checkpoint
from ppaas.nodes.graph import Graph
from ppaas.plans.reuse.time_estimates import Times
from ppaas.plugins import permit_only

logger = logging.getLogger(__name__)

LOOK = 10.0
"""Longest time between two looks at the zones of the map, which a new version may have changed [s]."""


@dataclass(frozen=True, slots=True)
class MapFollower:
    """Handler of ``UseLayers`` frames: all parts of a container that know its map version change together."""

    current: CurrentMap
    home: NodeExecutor
    container: Container
    machine: MachineClient
    outside: FleetBridge
    notes: PlanningNotes
    monitoring: ContainerMonitor | None

    async def attend_zones(self) -> None:
        """Move the nodes to other zones of the map whenever others come into force."""
        while True:
            await asyncio.sleep(max(min(self.current.next_change - epoch(), LOOK), 0.01))
            try:
                self.current.follow_zones(self.home.graph, self.monitoring)
            except PPaaSError as error:
                logger.error("the zones of map %r are not changed: %s", self.current.spec.map.id, error)
            self.home.attend()

    def __call__(self, frame: machine_link.UseLayers) -> None:
        """Use the layers; what was sent before the answer is of the version before."""
        self.notes.tell(self.machine)
        try:
            if self.current.use(frame, self.home.graph, self.monitoring):
                self.container.map_replaced()
        except PPaaSError as error:
            self.machine.map_in_use(frame.map, error)
        else:
            self.outside.use_spec(self.current.spec)
            self.machine.map_in_use(frame.map)
        self.home.attend()

    def load_changed(self) -> None:
        """Go on with the robot as it is with its load, or without one."""
        self.outside.use_spec(self.current.spec)
        self.home.attend()


_faults = ListenerFaults(logger)


async def run(launch: Launch) -> None:
    """Run the container until the machine disconnects or the endpoint sends a shutdown."""
    stream, threads = await dial(launch.link), KernelThreads(launch.threads)
    patience = KERNEL_PATIENCE if launch.spec.robot is None else None
    gate = KernelGate(None if launch.compiled else partial(await_kernels, launch), patience=patience)
    waits = partial(stream.write, robot_link.KernelsAwaited(launch.spec.id, launch.secret))
    try:
        home, current, plans, notes, attendants = await _built(launch, threads, gate, waits)
    except PPaaSError as error:
        await _refuse(stream, launch, error)
        return
    await gate.for_start(waits)
    machine = await MachineClient.connect(launch)
    current.indexes.ask(machine, asyncio.get_running_loop())
    plans.ask(machine)
    monitoring = None if attendants is None else attendants.monitoring
    endpoint = EndpointLink(launch.link, stream)
    sessions = None if launch.spec.robot is None else sessions_of(launch.spec, launch.spec.robot)
    container = Container(launch, home, endpoint, machine, notes, attendants=attendants, sessions=sessions)
    outside, groups = _bridges(launch, home, machine, _presence_of(sessions))
    follow = MapFollower(current, home, container, machine, outside, notes, monitoring)
    told = _connected(attendants, machine)
    if attendants is not None:
        attendants.fitting.fitted = follow.load_changed
        outside.use_spec(current.spec)
    listening = asyncio.create_task(
        machine.serve(partial(_shared, outside, groups), partial(_resize, threads), endpoint.came, follow, told)
    )
    await notes.begin(machine)
    try:
        await container.restore_logs()
        if sessions is not None:
            sessions.begin(container, endpoint)
        endpoint.write(container.hello(os.getpid()))
        home.attend()
        works = [container.serve(), container.keep_checkpoints(), container.beat(), follow.attend_zones()]
        if launch.traces is not None:
            works.append(hand_over_spans(machine))
        await _until_first(*works, _end_of(listening), *(() if sessions is None else (sessions.attend(),)))
    finally:
        home.close()
        await _closed(container, endpoint, machine)


class _Built(NamedTuple):
    """Graph of a container in its executor, with its map, plans and attendants."""

    home: NodeExecutor
    current: CurrentMap
    plans: SharedPlans
    notes: PlanningNotes
    attendants: Attendants | None


async def _built(launch: Launch, threads: KernelThreads, gate: KernelGate, waits: Callable[[], None]) -> _Built:
    """Build and restore the graph; build it again if it calls kernels that are missing, once they are compiled.

    Raises
    ------
    PPaaSError
        The container cannot be what it was asked to be.
    """
    while True:
        times = Times()
        home = NodeExecutor(lambda: use_threads(threads.count), gate)
        plans, notes = SharedPlans(times, home.elsewhere), PlanningNotes(times)
        try:
            with gate.only_compiled():
                current = CurrentMap(launch, plans, times, notes)
                attendants = build_graph(home.graph, launch, threads, current)
                _restore(home.graph, launch)
        except KernelsMissing:
            home.close()
            await gate.for_start(waits)
        except PPaaSError:
            home.close()
            raise
        else:
            return _Built(home, current, plans, notes, attendants)


async def _refuse(stream: Stream, launch: Launch, error: PPaaSError) -> None:
    await stream.send(robot_link.ContainerFailed(launch.spec.id, launch.secret, refusal_of(error)))
    await stream.close()


async def _closed(container: Container, endpoint: EndpointLink, machine: MachineClient) -> None:
    await container.endpoints.close()
    await endpoint.close()
    await machine.close()


def _restore(graph: Graph, launch: Launch) -> None:
    try:
        checkpoint = launch.spec.checkpoint
        graph.restore(
            [Checkpoint(name, state) for name, state in checkpoint.items()], of_other_map=MOVED_STATE in checkpoint
        )
    except InvalidInput as error:
        if launch.spec.group_node:
            # Its group has no session that clients could begin again.
            logger.warning("the %s node of map %r begins anew: %s", launch.spec.group_node, launch.spec.map.id, error)
            return
        raise InvalidInput(f"{error}; connect again to start a new session without it") from error


def _connected(attendants: Attendants | None, machine: MachineClient) -> Callable[[machine_link.RecorderTold], None]:
    """Connect the recorder of a clone with its machine; return the function that passes on its answers."""
    if attendants is None:
        return lambda _: None
    attendants.recording.connect(machine)
    return attendants.recording.told


def _presence_of(sessions: SessionHost | None) -> RobotIsHere:
    return lambda: sessions is not None and sessions.robot_is_here


def _bridges(
    launch: Launch, home: NodeExecutor, machine: MachineClient, here: RobotIsHere
) -> tuple[FleetBridge, list[GroupBridge]]:
    groups = [make(launch, home, machine, here) for make in (people_bridge, traffic_bridge)]
    return FleetBridge(launch, home.graph, machine, here), groups


def _shared(outside: FleetBridge, groups: Sequence[GroupBridge], *messages: machine_link.Shared) -> None:
    _faults.call("the fleet bridge", outside.shared, *messages)
    for message in messages:
        for bridge in groups:
            if bridge.hears(message.topic):
                _faults.call(f"the bridge of a group on {message.topic}", bridge.shared, message)


def _resize(threads: KernelThreads, count: int) -> None:
    threads.count = count
    threads()  # for kernels that run on the loop's own thread


async def _end_of(task: asyncio.Task[None]) -> None:
    await task


async def _until_first(*works: Coroutine[Any, Any, None]) -> None:
    tasks = [asyncio.create_task(work) for work in works]
    try:
        done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        for task in done:
            task.result()
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


def main(launch: Launch) -> None:
    """Run a container in this process until it ends."""
    permit_only(launch.allowed)
    spec = launch.spec
    log_lines(f"%(levelname)s {spec.id} %(name)s: %(message)s", process=spec.id)
    if launch.traces is not None:
        keep_spans(launch.traces)
    CompileNotice(launch).register()
    robot = {} if spec.robot is None else {"robot": f"{spec.user}:{spec.robot.id}"}
    with log_fields(**robot):
        uvloop.run(run(launch))
