"""Topics of costmaps, the footprint and the local plan: published for subscribers, no more often than due."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from ppaas.errors import InvalidParameter, PPaaSError
from ppaas.geometry import Pose2D
from ppaas.messages import decode, encode
from ppaas.messages.geometry_msgs import PolygonStamped
from ppaas.messages.nav_msgs import OccupancyGrid, Path
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World, fill, walled_map

START = Pose2D(1.0, 1.0, 0.0)
GOAL = Pose2D(4.0, 3.0, 0.0)

GLOBAL = ["global_costmap/costmap", "move_base/global_costmap/costmap"]
LOCAL = ["local_costmap/costmap", "move_base/local_costmap/costmap"]
FOOTPRINT = ["local_costmap/published_footprint", "move_base/local_costmap/footprint"]


def loop(**options: Any) -> ClosedLoop:
    """Return a robot that is localized, and whose clone has nothing to do."""
    driving = ClosedLoop(World(walled_map(6, 4, []), START), **options)
    for _ in range(6):
        driving.step()
    return driving


def unseeing() -> ClosedLoop:
    """Return a robot without sensors, which therefore is not localized."""
    driving = ClosedLoop(World(walled_map(6, 4, []), START))
    driving.sensing = False
    return driving


@pytest.fixture
def driving() -> ClosedLoop:
    return loop()


def listen(driving: ClosedLoop, topic: str) -> tuple[list[Any], Callable[[], None]]:
    """Subscribe to a topic; return the list of its messages, and a function that unsubscribes."""
    messages: list[Any] = []
    return messages, driving.graph.tap(topic, lambda _, message: messages.append(message))


def cells_of(message: OccupancyGrid) -> np.ndarray[Any, Any]:
    read = decode(OccupancyGrid, encode(message))
    return np.array(read.data).reshape(read.info.height, read.info.width)


def put_box(driving: ClosedLoop) -> None:
    """Put a box in front of the robot that is not on the map."""
    cells = driving.world.grid.data.copy()
    fill(cells, driving.world.grid.info, (2.0, 0.5, 2.2, 1.5))
    driving.world.truth[:] = cells >= 50  # type: ignore[attr-defined]


def test_nothing_is_published_without_subscribers(driving: ClosedLoop) -> None:
    published: list[str] = []
    driving.graph.tap_published(lambda topic, _: published.append(topic))
    driving.send_goal(GOAL)
    driving.run(2.0)
    assert "cmd_vel" in published
    assert not {*GLOBAL, *LOCAL, *FOOTPRINT, "local_plan"} & set(published)


# -- global costmap ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("topic", GLOBAL)
def test_the_costs_of_the_whole_map_come_within_a_second(driving: ClosedLoop, topic: str) -> None:
    grids, _ = listen(driving, topic)
    driving.run(1.05)
    [message] = grids
    assert message.header.frame_id == "map"
    assert message.header.stamp.seconds() == pytest.approx(driving.clock(), abs=1.0)
    assert (message.info.width, message.info.height) == driving.world.grid.data.shape[::-1]
    cells, costs = cells_of(message), driving.layers.costmap.data
    assert set(np.unique(cells)) <= set(range(-1, 101))
    assert (cells[costs == 254] == 100).all()
    assert np.mean(cells[costs == 0] == 0) > 0.9


def test_a_global_costmap_that_does_not_change_is_sent_again_every_ten_seconds_only() -> None:
    driving = unseeing()
    grids, _ = listen(driving, GLOBAL[0])
    driving.run(9.0)
    assert len(grids) == 1
    driving.run(4.0)
    assert len(grids) == 2


def test_an_obstacle_changes_the_global_costmap_at_most_once_a_second(driving: ClosedLoop) -> None:
    grids, _ = listen(driving, GLOBAL[0])
    driving.run(1.05)
    put_box(driving)
    driving.run(3.0)
    assert 2 <= len(grids) <= 4
    seen = cells_of(grids[-1]) - cells_of(grids[0])
    row, column = driving.world.grid.info.to_cells((2.0, 1.0))
    assert seen[row, column] > 0


def test_the_map_alone_is_sent_while_the_pose_is_unknown() -> None:
    driving = unseeing()
    grids, _ = listen(driving, GLOBAL[0])
    windows, _ = listen(driving, LOCAL[0])
    driving.run(1.05)
    assert len(grids) == 1 and not windows
    assert ((cells_of(grids[0]) == 0) == (driving.layers.costmap.data == 0)).all()


@pytest.mark.parametrize("topics", [GLOBAL, GLOBAL[::-1], LOCAL])
def test_a_later_subscriber_gets_the_last_costmap_at_once(driving: ClosedLoop, topics: list[str]) -> None:
    first, _ = listen(driving, topics[0])
    driving.run(1.05)
    second, _ = listen(driving, topics[0])
    assert second == first != []


def test_a_later_subscriber_of_the_other_name_gets_it_within_a_second() -> None:
    driving = unseeing()
    grids, _ = listen(driving, GLOBAL[0])
    driving.run(1.05)
    others, _ = listen(driving, GLOBAL[1])
    driving.run(1.0)
    assert others == grids and len(grids) == 1


@pytest.mark.parametrize("topic", [GLOBAL[0], LOCAL[0], FOOTPRINT[0]])
def test_the_last_message_is_dropped_when_nobody_subscribes(driving: ClosedLoop, topic: str) -> None:
    _, leave = listen(driving, topic)
    driving.run(1.05)
    assert driving.graph.latched(topic) is not None
    leave()
    driving.run(1.05)
    assert driving.graph.latched(topic) is None
    again, _ = listen(driving, topic)
    assert again == []
    driving.run(1.05)
    assert len(again) == 1


def test_costmaps_are_dropped_when_move_base_leaves(driving: ClosedLoop) -> None:
    listen(driving, GLOBAL[0])
    driving.run(1.05)
    driving.graph.remove("move_base")
    assert listen(driving, GLOBAL[0])[0] == []


def test_no_costmap_is_begun_while_the_last_is_being_converted() -> None:
    jobs: list[tuple[Callable[..., Any], Callable[..., None]]] = []

    def worker(work: Callable[..., Any], cancelled: Callable[[], bool], done: Callable[[Any], None]) -> None:
        jobs.append((lambda: work(cancelled), done))

    driving = loop(worker=worker)
    grids, _ = listen(driving, GLOBAL[0])
    driving.run(3.0)
    [(work, done)] = jobs
    done(work())
    assert len(grids) == 1
    driving.run(1.05)
    assert len(jobs) == 2
    jobs[1][1](PPaaSError("no memory"))
    driving.run(1.05)
    assert len(jobs) == 3 and len(grids) == 1


# -- local costmap and footprint ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("topic", LOCAL)
def test_the_local_costmap_is_the_window_around_the_robot_once_a_second(driving: ClosedLoop, topic: str) -> None:
    windows, _ = listen(driving, topic)
    driving.run(3.05)
    assert len(windows) == 3
    info = windows[-1].info
    assert (info.width, info.height) == (120, 120)
    centre = info.origin.position.x + 3.0, info.origin.position.y + 3.0
    assert centre == pytest.approx(driving.world.pose[:2], abs=0.1)
    assert cells_of(windows[-1]).max() == 100


def test_the_local_costmap_shows_what_the_laser_sees_without_a_goal(driving: ClosedLoop) -> None:
    windows, _ = listen(driving, LOCAL[0])
    driving.run(1.05)
    put_box(driving)
    driving.run(2.0)
    assert (cells_of(windows[-1]) == 100).sum() > (cells_of(windows[0]) == 100).sum()


@pytest.mark.parametrize(("frequency", "count"), [(5.0, 10), (0.5, 1), (0, 0)])
def test_its_rate_is_a_parameter(frequency: float, count: int) -> None:
    driving = loop(parameters={"local_costmap": {"publish_frequency": frequency}})
    windows, _ = listen(driving, LOCAL[0])
    outlines, _ = listen(driving, FOOTPRINT[0])
    grids, _ = listen(driving, GLOBAL[0])
    driving.run(2.05)
    assert (len(windows), len(outlines), len(grids)) == (count, count, 2)


@pytest.mark.parametrize("frequency", [-1.0, 11.0, math.inf, math.nan])
def test_a_rate_out_of_range_is_refused(frequency: float) -> None:
    with pytest.raises(InvalidParameter, match="publish_frequency must be from 0 to 10 Hz"):
        loop(parameters={"local_costmap": {"publish_frequency": frequency}})


@pytest.mark.parametrize("topic", FOOTPRINT)
def test_the_footprint_of_a_disc_has_sixteen_corners_around_the_robot(driving: ClosedLoop, topic: str) -> None:
    outlines, _ = listen(driving, topic)
    driving.run(1.05)
    outline = decode(PolygonStamped, encode(outlines[0]))
    assert outline.header.frame_id == "map" and len(outline.polygon.points) == 16
    x, y, _ = driving.world.pose
    radii = [math.hypot(point.x - x, point.y - y) for point in outline.polygon.points]
    assert radii == pytest.approx([0.18] * 16, abs=0.05)


def test_a_footprint_is_turned_with_the_robot() -> None:
    corners = [[0.3, 0.1], [-0.2, 0.1], [-0.2, -0.1], [0.3, -0.1]]
    world = World(walled_map(6, 4, []), Pose2D(2.0, 2.0, math.pi / 2))
    driving = ClosedLoop(world, parameters={"global_costmap": {"footprint": corners}})
    outlines, _ = listen(driving, FOOTPRINT[0])
    driving.run(1.5)
    seen = [(point.x, point.y) for point in outlines[-1].polygon.points]
    assert np.array(seen) == pytest.approx(np.array([(1.9, 2.3), (1.9, 1.8), (2.1, 1.8), (2.1, 2.3)]), abs=0.05)


# -- local plan --------------------------------------------------------------------------------------------------------


def test_the_local_plan_is_the_arc_of_each_command(driving: ClosedLoop) -> None:
    plans, _ = listen(driving, "local_plan")
    driving.run(1.0)
    assert plans == []
    driving.send_goal(GOAL)
    driving.run(2.0)
    driving.graph.run_due()
    sent = len(driving.commands)
    assert 30 <= len(plans) <= sent
    path = decode(Path, encode(plans[-1]))
    assert path.header.frame_id == "map" and isinstance(path.poses, list)
    first, last = path.poses[0].pose.planar(), path.poses[-1].pose.planar()
    assert first[:2] == pytest.approx(driving.world.pose[:2], abs=0.1)
    assert 0.0 < first.distance_to(last) <= 1.7 * 0.7


def test_every_message_has_the_type_of_its_topic(driving: ClosedLoop) -> None:
    heard: dict[str, object] = {}
    for topic in (*GLOBAL, *LOCAL, *FOOTPRINT, "local_plan"):
        driving.graph.tap(topic, lambda name, message: heard.update({name: type(message)}))
    driving.send_goal(GOAL)
    driving.run(2.0)
    assert heard == {name: driving.graph.topic(name).type for name in heard} and len(heard) == 7
