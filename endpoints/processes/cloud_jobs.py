"""Jobs that a cloud has one of, however many endpoints it has: watches, and work that no request asks for."""

from endpoints.merging.coordinator import JointMapCoordinator
from endpoints.people.counting import PeopleCounting
from endpoints.processes.map_rights_watch import MapRightsWatch
from endpoints.proposals.change_watch import ChangeWatch
from endpoints.removal.users import RemovedUsers
from endpoints.services.disk_watch import DiskWatch
from endpoints.services.services import Services
from engine.processes.background import Background
from engine.service.robot_sessions import IdleWatch, RobotSessions
from engine.service.tasks.runner import TaskRunner


class CloudJobs:
    """Runs the jobs in the process of the master.

    Parameters
    ----------
    services : Services
        Services of the cloud; the caller closes them.
    robots : RobotSessions
        Places of robots.
    idle : float
        Time without frames after which a robot is disconnected [s]; 0 disables this.
    tasks : TaskRunner
        Leads the tasks of robots.
    """

    def __init__(self, services: Services, robots: RobotSessions, idle: float, tasks: TaskRunner) -> None:
        self._jobs = (
            IdleWatch(robots, idle),
            MapRightsWatch(robots, services),
            DiskWatch.of(services.disk, services.store),
            ChangeWatch(services),
            RemovedUsers(services),
            PeopleCounting(services),
            JointMapCoordinator(services),
            tasks,
        )
        self._background = Background()

    def start(self) -> None:
        """Start all jobs."""
        for job in self._jobs:
            self._background.run(job.run())

    async def close(self) -> None:
        """Cancel all jobs."""
        await self._background.cancel()
