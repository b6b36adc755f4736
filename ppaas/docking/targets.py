"""Docks of a goal, each with the settings of its type and its detector."""

from collections.abc import Sequence
from dataclasses import dataclass

from ppaas.docking.approach import BodyOutline
from ppaas.docking.detection.base import DockDetector
from ppaas.docking.detection.registry import DOCK_DETECTORS
from ppaas.docking.dock import DockStance, MappedDock
from ppaas.docking.failures import DockTypeUnknown, DockUnknown, LoadCarried
from ppaas.docking.parameters import DockingParameters, DockType
from ppaas.errors import listed
from ppaas.geometry import Pose2D


@dataclass(frozen=True, slots=True)
class DockTarget:
    """A dock, and how the robot docks there."""

    dock: MappedDock
    type: DockType
    detector: DockDetector
    stance: DockStance

    @property
    def staging(self) -> Pose2D:
        """Pose before the dock in the frame of the map."""
        return self.dock.pose @ Pose2D(-self.stance.ahead * self.type.staging_distance, 0.0)


class DockTargets:
    """Finds the docks of goals.

    Parameters
    ----------
    parameters : DockingParameters
    body : BodyOutline

    Raises
    ------
    NotFound, InvalidParameter
        A type of docks names an unknown detector, or a wrong parameter of one.
    """

    def __init__(self, parameters: DockingParameters, body: BodyOutline) -> None:
        self._parameters, self._body = parameters, body
        self._detectors = {
            name: DOCK_DETECTORS.create(kind.detection, dict(kind.detector))
            for name, kind in parameters.dock_types.items()
        }

    def type_of(self, name: str) -> tuple[str, DockType]:
        """Return the name and the settings of a type of docks.

        A type that has no settings is the name of a detector, with its own defaults. An empty name means the only type
        that has settings, or docks with a flat face.

        Raises
        ------
        DockTypeUnknown
            There is neither; the text lists both.
        """
        known = self._parameters.dock_types
        if not name and len(known) == 1:
            [name] = known
        if name in known:
            return name, known[name]
        if not name and known:
            raise DockTypeUnknown(f"name a dock_type: the robot has settings for {listed(sorted(known))}")
        usual = DockType()
        detection = name or usual.detection
        if detection not in DOCK_DETECTORS:
            names = listed(sorted({*known, *DOCK_DETECTORS.names()}))
            raise DockTypeUnknown(f"there is no dock_type {name[:64]!r}; known: {names}")
        return detection, DockType(detection=detection)

    def target(self, dock: MappedDock) -> DockTarget:
        """Return a dock with the settings of its type; raises as `type_of`."""
        name, kind = self.type_of(dock.type)
        if name not in self._detectors:
            self._detectors[name] = DOCK_DETECTORS.create(kind.detection, {})
        if kind.load:
            dock = dock._replace(charges=False)
        return DockTarget(dock, kind, self._detectors[name], kind.stance(self._body))

    def named(
        self, name: str, docks: Sequence[MappedDock], robot: Pose2D | None, *, loaded: bool = False
    ) -> list[DockTarget]:
        """Return the dock of a name and those to try after it; without a name all, the nearest first.

        Those at which robots take up loads are none for a goal without a name.

        Parameters
        ----------
        name : str
        docks : sequence of MappedDock
            All docks of the map.
        robot : Pose2D, optional
            Pose of the robot in the frame of the map.
        loaded : bool
            Whether the robot carries a load.

        Raises
        ------
        DockUnknown
            There is no such dock, or none at all.
        DockTypeUnknown
            The type of one is unknown.
        LoadCarried
            It is a place to take up a load, and the robot carries one.
        """
        if not docks:
            raise DockUnknown("the map has no docks: draw zones of the kind 'dock', or give a dock_pose")
        found = self._chain(name, docks) if name else self._nearest(docks, robot)
        if loaded and any(target.type.load for target in found):
            raise LoadCarried("the robot carries a load already: undock it first, which sets the load down")
        return found

    def _nearest(self, docks: Sequence[MappedDock], robot: Pose2D | None) -> list[DockTarget]:
        near = sorted(docks, key=lambda dock: 0.0 if robot is None else dock.pose.distance_to(robot))
        found = [target for target in map(self.target, near) if not target.type.load]
        if not found:
            raise DockUnknown(f"name a dock, since all are places of loads: {listed([dock.name for dock in near])}")
        return found

    def _chain(self, name: str, docks: Sequence[MappedDock]) -> list[DockTarget]:
        by_name = {dock.name: dock for dock in docks}
        chain: list[str] = []
        while name and name not in chain:
            if name not in by_name:
                raise DockUnknown(f"the map has no dock {name[:64]!r}; its docks: {listed(sorted(by_name))}")
            chain.append(name)
            name = self._parameters.next_docks.get(name, "")
        return [self.target(by_name[each]) for each in chain]
