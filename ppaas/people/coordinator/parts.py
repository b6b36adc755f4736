"""Parts of a coordinator that its state is made of."""

from typing import Protocol

from ppaas.people.coordinator.follow_controller import FollowController
from ppaas.people.coordinator.parameters import CoordinatorParameters
from ppaas.people.coordinator.people_table import PeopleTable
from ppaas.people.coordinator.robots.group import Robots
from ppaas.people.coordinator.zone_counts import ZoneCounts
from ppaas.people.settings import PeopleSettings


class CoordinatorParts(Protocol):
    """A coordinator, as its checkpoint and its message see it; ``Coordinator`` describes the attributes."""

    parameters: CoordinatorParameters
    settings: PeopleSettings
    table: PeopleTable
    robots: Robots
    follow: FollowController
    zones: ZoneCounts
    at: float
    began: float
