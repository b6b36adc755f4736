"""Current map of a container: layers and stored plans, replaced by another version's while the robot drives.

Indexes of planners for a map are made by the machine, and mapped by its containers.
"""

import asyncio
import logging
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import replace
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import msgspec

from engine.container.machine_client import MachineClient
from engine.container.monitor.setup import ContainerMonitor
from engine.protocols import machine_link
from engine.specs.containers import ContainerSpec, Launch
from engine.specs.layer_files import open_index, open_layers
from engine.specs.robot_layers import filters_of, layers_of, with_load
from ppaas.clock import epoch
from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import Unavailable
from ppaas.footprints import Footprint
from ppaas.maps.cell_rectangle import Rectangle
from ppaas.nodes.amcl.node import AmclNode
from ppaas.nodes.docking_server.node import DockingServerNode
from ppaas.nodes.footprint.node import FootprintNode, load_in
from ppaas.nodes.graph import Graph
from ppaas.nodes.map_server.node import MapServerNode
from ppaas.nodes.move_base.node import MoveBaseNode
from ppaas.nodes.planner_server.node import PlannerServerNode
from ppaas.people.names import FOLLOW_PERSON, LEG_DETECTOR, PEOPLE_COORDINATOR
from ppaas.plans.reuse.processor import Note
from ppaas.plans.reuse.setup import ReuseSetup
from ppaas.plans.reuse.time_estimates import Times
from ppaas.plans.stored import PlanLibrary
from ppaas.traffic.taking_part import TRAFFIC
from ppaas.zones.masks import closed_zones
from ppaas.zones.zone import Zone

logger = logging.getLogger(__name__)

SLICE = 0.005
"""Time between two checks whether the index is still needed [s]."""


class SharedIndexes:
    """Opens the indexes in a folder of layers, and makes the machine prepare missing ones.

    Planning threads call it, and block until the index is there; the event loop does not block.

    Parameters
    ----------
    folder : Path
        Folder with the layers.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._machine: tuple[MachineClient, asyncio.AbstractEventLoop] | None = None

    def ask(self, machine: MachineClient, loop: asyncio.AbstractEventLoop) -> None:
        """Request missing indexes from a machine, on its event loop, from now on."""
        self._machine = machine, loop

    def of(self, folder: Path) -> "SharedIndexes":
        """Return the indexes in another folder of layers, from the same machine."""
        other = SharedIndexes(folder)
        other._machine = self._machine
        return other

    def __call__(self, planner: str, check: Callable[[], None]) -> memoryview | None:
        """Return a planner's index of the map; None if the machine cannot make it now.

        Parameters
        ----------
        planner : str
            Name of the planner.
        check : callable
            Called while waiting; raises if the index is no longer needed.

        Raises
        ------
        InvalidPlanner
            The planner cannot prepare this map.
        """
        try:
            content = open_index(self._folder, planner)
            if content is None and self._machine is not None:
                machine, loop = self._machine
                _await(asyncio.run_coroutine_threadsafe(machine.prepare_index(planner), loop), check)
                content = open_index(self._folder, planner)
        except Unavailable as error:
            logger.warning("planner %s runs without a shared index: %s", planner, error)
            return None
        return content


def _await(asked: Future[None], check: Callable[[], None]) -> None:
    try:
        while True:
            check()
            try:
                return asked.result(SLICE)
            except TimeoutError:
                continue
    finally:
        asked.cancel()


ZONES = "zones"
"""Name among the conditions of plans of the keep-out zones that were closed."""

ON_LAYERS = (
    AmclNode.name,
    DockingServerNode.name,
    LEG_DETECTOR,
    FOLLOW_PERSON,
    PEOPLE_COORDINATOR,
    TRAFFIC,
    PlannerServerNode.name,
)
"""Nodes that use the layers of the map, beside Move Base and the map server; most containers lack some of them."""


@runtime_checkable
class OnLayers(Protocol):
    """Node that uses the layers of the map."""

    def use_layers(self, layers: MapLayers) -> None:
        """Go on with other layers."""
        ...


class CurrentMap:
    """Map version that a container uses now, with the keep-out zones with times that are in force.

    Layers with such zones are made here, in memory of the container's own; they are not shared.

    Parameters
    ----------
    launch : Launch
        Specification of the container, and the folder of its layers.
    library : PlanLibrary
        Source of stored plans.
    times : Times
        Measured times.
    note : callable
        Called with a history row for each request.

    Attributes
    ----------
    spec : ContainerSpec
        Spec of the container, with the current versions of map and masks.
    indexes : SharedIndexes
        Indexes of planners for the map.
    layers : MapLayers or None
        Layers of the map; None for a robot that makes a new map.
    reuse : ReuseSetup
        Access to the stored plans of the map version.
    load : Footprint
        Outline of what its robot carries; empty if nothing.

    Raises
    ------
    InvalidParameter
        The parameters of the robot's body are invalid.
    Unavailable
        The layers do not exist, or are incomplete.
    """

    def __init__(self, launch: Launch, library: PlanLibrary, times: Times, note: Note) -> None:
        self.load, self._launched = _load_of(launch.spec), launch.spec
        self.spec = with_load(launch.spec, launch.spec, self.load)
        self.indexes = SharedIndexes(Path(launch.layers))
        self._whole = None if self.spec.maps else _opened(Path(launch.layers), self.indexes)
        self._closed = _closed_in(self._whole)
        self.layers = None if self._whole is None else self._fitting(self._whole, self._closed, self.spec)
        self._filters = _filters_of(self.spec, self._closed)
        version = self.spec.map
        self.reuse = ReuseSetup(version.id, version.version, library, times, note, self._filters)

    @property
    def next_change(self) -> float:
        """First time at which other zones may be in force [s since the epoch]; infinite if never."""
        return float("inf") if self._whole is None else self._whole.zones.next_change(epoch())

    def follow_zones(self, graph: Graph, monitoring: ContainerMonitor | None) -> None:
        """Move the nodes to the zones that are in force now, if others are closed than before.

        Raises
        ------
        Unavailable
            As ``use`` raises it.
        """
        if self._whole is not None and _closed_in(self._whole) != self._closed:
            self._go_on(self.spec, self.indexes, self._whole, graph, monitoring)
            self._publish(graph, ())

    def use(self, frame: machine_link.UseLayers, graph: Graph, monitoring: ContainerMonitor | None) -> bool:
        """Move the nodes of a clone to other layers; the goal, the pose and seen obstacles stay.

        Nodes that run on the robot continue here, with the new map, until the robot takes them again.

        Parameters
        ----------
        frame : UseLayers
            Folder of the new layers, versions of map and masks, and the changed rectangles.
        graph : Graph
            Graph with the clone.
        monitoring : ContainerMonitor, optional
            Node monitor of the clone.

        Returns
        -------
        bool
            Whether only the changes of the map were published, and not the whole map.

        Raises
        ------
        Unavailable
            The layers are incomplete, or lack a mask; the nodes go on with those before.
        """
        folder = Path(frame.layers)
        indexes = self.indexes.of(folder)
        layers = _opened(folder, indexes)
        spec = self.spec.on_maps(frame.map, frame.masks, in_space=frame.in_space)
        self._go_on(spec, indexes, layers, graph, monitoring)
        return self._publish(graph, frame.changes)

    def _go_on(
        self,
        spec: ContainerSpec,
        indexes: SharedIndexes,
        whole: MapLayers,
        graph: Graph,
        monitoring: ContainerMonitor | None,
    ) -> None:
        """Move the nodes to layers, to which closed zones are added; on an error all is as before."""
        before, closed = dict(self._filters), _closed_in(whole)
        self._set_filters(_filters_of(spec, closed))  # Move Base makes its processor of stored plans with them
        try:
            layers = self._fitting(whole, closed, spec)
            move_base = graph.nodes.get(MoveBaseNode.name)
            if isinstance(move_base, MoveBaseNode):
                move_base.use_layers(layers, spec.map.version)
        except BaseException:
            self._set_filters(before)
            raise
        self.spec, self.indexes, self.layers = spec, indexes, layers
        self._whole, self._closed = whole, closed
        self.reuse = replace(self.reuse, version=spec.map.version)
        self._move_to(layers, graph)
        if monitoring is not None:
            monitoring.recall("its map was replaced")

    def carry(self, load: Footprint, graph: Graph) -> None:
        """Go on with the layers for a robot with a load, or without one; whatever uses them is built again."""
        self.load, self.spec = load, with_load(self.spec, self._launched, load)
        if self._whole is not None:
            self.layers = self._fitting(self._whole, self._closed, self.spec)
            self._move_to(self.layers, graph)

    def _fitting(self, whole: MapLayers, closed: list[Zone], spec: ContainerSpec) -> MapLayers:
        """Return layers as they are now: with closed zones, and for the robot with its load."""
        needed = layers_of(spec)
        if not closed and needed.robot_radius == layers_of(self._launched).robot_radius:
            return whole
        # Imported only here: most containers make no layers.
        from ppaas.costmap.build_layers import with_closed  # noqa: PLC0415

        return with_closed(whole, closed, needed.robot_radius, needed.costs)

    def _move_to(self, layers: MapLayers, graph: Graph) -> None:
        for name in ON_LAYERS:
            node: object = graph.nodes.get(name)
            if isinstance(node, OnLayers):
                node.use_layers(layers)

    def _publish(self, graph: Graph, changes: Sequence[tuple[int, int, int, int]] | None) -> bool:
        server = graph.nodes.get(MapServerNode.name)
        if self.layers is None or not isinstance(server, MapServerNode):
            return False
        return server.use_layers(self.layers, None if changes is None else [Rectangle(*one) for one in changes])

    def _set_filters(self, filters: dict[str, Any]) -> None:
        self._filters.clear()
        self._filters.update(filters)


def _closed_in(layers: MapLayers | None) -> list[Zone]:
    return [] if layers is None else closed_zones(layers.zones, epoch())


def _load_of(spec: ContainerSpec) -> Footprint:
    """Return what the robot of a spec carries; nothing if that cannot be read, as restoring its node reports."""
    try:
        return load_in(spec.checkpoint.get(FootprintNode.name))
    except (msgspec.MsgspecError, ValueError):
        return ()


def _filters_of(spec: ContainerSpec, closed: list[Zone]) -> dict[str, Any]:
    """Return the conditions of plans: zones that are only closed at times are among them."""
    names = {ZONES: sorted(zone.name for zone in closed)} if closed else {}
    return filters_of(layers_of(spec)) | names


def _opened(folder: Path, indexes: SharedIndexes) -> MapLayers:
    layers = open_layers(folder)
    return replace(layers, costmap=replace(layers.costmap, indexes=indexes))
