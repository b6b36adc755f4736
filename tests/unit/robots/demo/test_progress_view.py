import io

from rich.console import Console

from ppaas.geometry import Pose2D
from robots.demo.demonstration import progress_table
from robots.demo.mission import Mission
from robots.sim.courses import Course
from robots.sim.world import World
from tests.support.world.rooms import room


def test_the_table_shows_the_progress_of_each_robot() -> None:
    world = World(room(8.0, 4.0))
    world.add_robot(Pose2D(2.0, 2.0, 0.0))
    mission = Mission(world, 0, "tb1", Course(Pose2D(2.0, 2.0), (Pose2D(5.5, 2.0),), (3.5,)))
    mission.progress.goal, mission.progress.target = 1, Pose2D(5.5, 2.0)
    mission.progress.state = "failed: [red]no[/red]"
    console = Console(file=io.StringIO(), width=120)
    console.print(progress_table([mission]))
    text = console.file.getvalue()  # type: ignore[attr-defined]
    for shown in ("tb1", "1/1", "3.50", "to go (m)", "failed: [red]no[/red]"):
        assert shown in text
