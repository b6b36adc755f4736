"""Maps that robots drive on or make, in the process of the master."""

from collections.abc import Sequence

from engine.service.group_places import GroupPlaces
from engine.service.master_driver import MasterDriver
from engine.service.views import LifelongRobot, MappingRobot
from engine.specs.containers import MapVersion
from engine.specs.continued_maps import is_lifelong
from storage.records import MapRecord
from storage.versions import OCTOMAP, YAML


class MapsInUse:
    """Moves robots to new versions of their maps, and knows those that make maps; implements ``MapCalls``.

    Parameters
    ----------
    driver : MasterDriver
        Driver of the master.
    groups : sequence of GroupPlaces
        Places of the nodes of groups.
    """

    def __init__(self, driver: MasterDriver, groups: Sequence[GroupPlaces]) -> None:
        self._driver = driver
        self._groups = groups

    async def changed(self, head: MapRecord) -> None:
        """Move the robots on a map, or with it as a mask, to its current version.

        A version without a grid is no map to drive on: they stay on the one before.
        """
        files = head.present.files
        if YAML in files:
            self._driver.map_changed(MapVersion(head.id, head.version), head.present.number, in_space=OCTOMAP in files)

    async def end_groups(self, map_id: str) -> None:
        """End the people coordinators and traffic nodes of a map."""
        for places in self._groups:
            await places.close_map(map_id)

    async def mapping_robots(self) -> list[MappingRobot]:
        """Return the robots with a running container that make new maps, except those that continue a published one."""
        return [
            MappingRobot(spec.user, robot.id, spec.joint_map)
            for spec, robot in self._driver.containers.running_robots()
            if spec.joint_map
        ]

    async def lifelong_robots(self) -> list[LifelongRobot]:
        """Return the robots with a running container that continue a published map for life."""
        return [
            LifelongRobot(spec.user, robot.id, robot.continued.id)
            for spec, robot in self._driver.containers.running_robots()
            if robot.continued is not None and is_lifelong(robot.parameters)
        ]
