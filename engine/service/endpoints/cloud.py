"""The engine in the process of the master: the parts that do the work, by subject."""

from functools import partial

from engine.master.places import robot_key
from engine.master.quotas import Quotas
from engine.service.endpoints.control_plane import CountPaths
from engine.service.endpoints.group_calls import PeopleCalls, TaskCalls, TrafficCalls
from engine.service.endpoints.machine_calls import ContainerCalls, MachineCalls, NeighbourCalls
from engine.service.endpoints.map_calls import MapCalls
from engine.service.endpoints.maps_in_use import MapsInUse
from engine.service.endpoints.neighbours import Neighbours
from engine.service.endpoints.robot_calls import RobotCalls
from engine.service.endpoints.user_calls import UserCalls
from engine.service.endpoints.user_quotas import UserQuotas
from engine.service.links.place_link import PlaceLink
from engine.service.master_driver import MasterDriver
from engine.service.navigation_client import NavigationClient
from engine.service.news.news import News
from engine.service.news.robot_facts import FactSources
from engine.service.people_groups import PeopleGroups
from engine.service.planning.planning import Planning
from engine.service.planning_places import PlanningPlaces
from engine.service.robot_navigation import RobotNavigation
from engine.service.robot_nodes import RobotNodes
from engine.service.tasks.robots import TaskRobots
from engine.service.tasks.runner import TaskNews, TaskRunner
from engine.service.traffic_groups import TrafficGroups
from engine.specs.containers import MapVersion
from engine.specs.start_state import StartState
from storage.ports import Store


class Cloud:
    """Parts of the master for the endpoints, and for the jobs of this process; implements ``ControlPlane``.

    Parameters
    ----------
    driver : MasterDriver
        Driver of the master.
    quotas : Quotas
        Limits of the users.

    Attributes
    ----------
    neighbours : Neighbours
        The endpoints that are connected to this process.
    planning_places : PlanningPlaces
        Places of planning containers.
    news : News
        Changes of records in the stores.
    fact_sources : FactSources
        Processes that know facts about robots.
    master_silence : float
        Time since the master answered [s]; always 0, because the master is in this process.
    """

    master_silence = 0.0

    def __init__(self, driver: MasterDriver, quotas: Quotas) -> None:
        self.driver, self.quotas = driver, quotas
        self.news, self.fact_sources = News(), FactSources()
        self.neighbours = Neighbours()
        self.planning_places = PlanningPlaces(driver)
        self._navigation, self._task_news = RobotNavigation(driver), TaskNews()
        people, traffic = PeopleGroups(driver), TrafficGroups(driver)
        self._groups = people.places, traffic.places
        self._task_robots = TaskRobots(driver, partial(NavigationClient, goal_ended=self._task_news.wake.set))
        self.robots: RobotCalls = self._navigation
        self.maps: MapCalls = MapsInUse(driver, self._groups)
        self.people: PeopleCalls = people
        self.traffic: TrafficCalls = traffic
        self.tasks: TaskCalls = self._task_news
        self.machines: MachineCalls = driver.administration
        self.containers: ContainerCalls = driver.containers
        self.endpoints: NeighbourCalls = self.neighbours
        self.users: UserCalls = UserQuotas(driver, quotas)
        self.nodes = RobotNodes(self._place_of)
        self.planning = Planning(self._use, driver.start_state)
        self.count_paths: CountPaths = partial(self.users.take_paths, ahead=0)
        self.connected, self.set_limits = self.robots.connected, self.users.set_limits
        self.announce, self.facts = self.news.tell, self.fact_sources.ask

    @property
    def start(self) -> StartState:
        """Whether containers can start, and the kernels that machines compile."""
        return self.driver.start_state()

    def close(self) -> None:
        """Cancel all timers."""
        self.planning_places.close()
        for places in self._groups:
            places.close()
        self._navigation.close()

    def place_opened(self, key: str) -> None:
        """Give the robot of a place the nodes of its groups, and tasks; called for adopted places, too."""
        for places in self._groups:
            places.place_opened(key)
        self._task_robots.place_opened(key)

    def task_runner(self, store: Store) -> TaskRunner:
        """Return what leads the tasks of this cloud, which are in a store."""
        return TaskRunner(store, self._task_robots, self._task_news, self.planning.compute_costs)

    async def _place_of(self, user: str, robot: str) -> PlaceLink | None:
        return self.driver.place(robot_key(user, robot))

    async def _use(
        self, user: str, version: MapVersion, labels: dict[str, str], queue: bool
    ) -> tuple[PlaceLink, int | None]:
        place = self.planning_places.use(user, version, labels, queue=queue)
        return place, self.driver.position(place.key)
