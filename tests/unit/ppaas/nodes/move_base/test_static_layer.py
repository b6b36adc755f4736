"""Static layer: the map of Move Base comes from topics, grows and moves."""

import msgspec
import numpy as np
import pytest

from ppaas.clock import ManualClock
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.map_layers import MapLayers
from ppaas.geometry import Pose2D
from ppaas.maps.grid import OCCUPIED, UNKNOWN, GridInfo, GridMap
from ppaas.maps.occupancy import GridMapMessage, GridUpdate, to_message, to_update
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.nodes.base import Context, Node, Payload
from ppaas.nodes.graph import Graph
from ppaas.nodes.move_base.static_layer import MARGIN, StaticLayer, applied, covering, extended

INFO = GridInfo(0.1, 40, 30, Pose2D(-1.0, -2.0, 0.0))
FREE = GridMap(np.zeros(INFO.shape, np.int8), INFO)
TURNED = GridInfo(0.1, 40, 30, Pose2D(-1.0, -2.0, 0.5))


class Heard(Node):
    """A node with a static layer."""

    name = "heard"
    subscribes = StaticLayer.subscribes

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.goals: list[Pose2D] = []
        self.used: list[tuple[float, MapLayers]] = []
        self.layer = StaticLayer(context, build_layers, self.use, lambda: self.goals)

    def use(self, layers: MapLayers) -> None:
        self.used.append((self.context.elapsed(), layers))

    def on_message(self, topic: str, message: Payload) -> None:
        assert self.layer.take(message)


class Listening:
    """A graph with such a node, on a manual clock."""

    def __init__(self) -> None:
        self.clock = ManualClock(100.0)
        self.graph = Graph(clock=self.clock)
        self.node = self.graph.add(Heard)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.05)):
            self.clock.advance(0.05)
            self.graph.run_due()

    def send(self, message: Payload) -> None:
        self.graph.inject("map" if hasattr(message, "info") or hasattr(message, "grid") else "map_updates", message)

    @property
    def grid(self) -> GridMap:
        return self.node.used[-1][1].grid


@pytest.fixture
def listening() -> Listening:
    return Listening()


def change(row: int, column: int, value: int = OCCUPIED, size: int = 2) -> GridUpdate:
    return GridUpdate(np.full((size, size), value, np.int8), row, column, Time())


def test_a_map_is_built_at_once(listening: Listening) -> None:
    assert listening.node.layer.waits() == "no map yet: no message has come on 'map'"
    listening.send(GridMapMessage(FREE))
    listening.run(0.2)
    [(_, layers)] = listening.node.used
    assert layers.grid is FREE and listening.node.layer.waits() == ""


def test_changes_are_built_together_at_most_once_a_second(listening: Listening) -> None:
    listening.send(GridMapMessage(FREE))
    for step in range(30):
        listening.run(0.1)
        listening.send(change(step % 28, 5))
        listening.send(change(step % 28, 20))
    times = [at for at, _ in listening.node.used]
    assert 3 <= len(times) <= 4
    assert np.diff(times).min() >= 0.9 - 1e-6
    listening.run(1.0)
    assert (listening.grid.data == OCCUPIED).sum() == 2 * 2 * 29
    assert listening.node.used[-1][1].costmap.data[0, 5] == 254
    assert not FREE.data.any(), "the published grid is not modified"


def test_messages_of_the_wire_are_the_same_as_those_passed_by_reference() -> None:
    sent = [to_message(FREE), to_update(np.full((2, 3), 70, np.int8), 4, 5, Header(frame_id="map"))]
    by_wire = [msgspec.json.decode(msgspec.json.encode(each), type=type(each)) for each in sent]
    grid = applied(None, by_wire)
    assert grid is not None and grid.info == INFO
    assert (grid.data[4:6, 5:8] == 70).all() and (grid.data == 70).sum() == 6


def test_nothing_is_built_when_nothing_has_changed(listening: Listening) -> None:
    for _ in range(3):
        listening.send(GridMapMessage(FREE))
        listening.run(1.0)
    assert len(listening.node.used) == 1


def test_a_whole_map_replaces_changes_before_it(listening: Listening) -> None:
    listening.send(GridMapMessage(FREE))
    listening.send(change(1, 1))
    moved = GridMap(np.full((50, 60), UNKNOWN, np.int8), GridInfo(0.1, 60, 50, Pose2D(-2.0, -3.0)))
    listening.send(GridMapMessage(moved))
    listening.run(0.2)
    assert listening.grid is moved


@pytest.mark.parametrize(("row", "column"), [(29, 5), (-1, 5), (5, 39), (5, -2)])
def test_an_update_outside_the_map_is_left_out(row: int, column: int) -> None:
    grid = applied(FREE, [change(row, column), change(3, 3)])
    assert grid is not None
    assert (grid.data == OCCUPIED).sum() == 4 and not FREE.data.any()


def test_an_update_before_the_first_map_has_no_effect(listening: Listening) -> None:
    listening.send(change(1, 1))
    listening.run(2.0)
    assert not listening.node.used and not listening.node.layer.has_map


def test_updates_with_bad_cells_are_left_out() -> None:
    good = to_update(np.full((2, 2), 70, np.int8), 4, 5, Header(frame_id="map"))
    bad = [
        msgspec.structs.replace(good, width=3),
        msgspec.structs.replace(good, data=[1, 2, 3, 101]),
        msgspec.structs.replace(good, width=0, data=[]),
        msgspec.structs.replace(to_message(FREE), data=[0]),
    ]
    assert applied(FREE, bad) is not None
    assert not applied(FREE, bad).data.any()  # type: ignore[union-attr]


@pytest.mark.parametrize("built", [True, False])
def test_a_map_that_was_cleared_is_forgotten(listening: Listening, built: bool) -> None:
    listening.send(GridMapMessage(FREE))
    listening.run(0.2 if built else 0.0)
    listening.node.layer.forget()
    assert listening.node.layer.waits() == "no map yet: no message has come on 'map'"
    listening.send(change(1, 1))
    listening.run(2.0)
    assert len(listening.node.used) == built
    other = GridMap(np.zeros((5, 5), np.int8), GridInfo(0.1, 5, 5))
    listening.send(GridMapMessage(other))
    listening.run(1.0)
    assert listening.grid is other and listening.node.layer.waits() == ""


# -- goals outside the map ---------------------------------------------------------------------------------------------


def test_the_map_is_extended_to_a_goal_outside_it_and_back(listening: Listening) -> None:
    listening.send(GridMapMessage(FREE))
    listening.run(1.0)
    goal = Pose2D(8.0, 1.0, 0.0)
    listening.node.goals = [goal]
    assert listening.node.layer.waits() == "the map is being extended to the goal"
    listening.run(1.0)
    assert listening.node.layer.waits() == ""
    cell = listening.grid.info.cell_of(goal.x, goal.y)
    assert cell is not None and listening.grid.data[cell] == UNKNOWN
    assert listening.grid.info.cell_of(goal.x + MARGIN - 0.1, goal.y) is not None
    assert (listening.grid.data == 0).sum() == FREE.data.size
    listening.node.goals = []
    listening.send(change(0, 0))
    listening.run(1.0)
    assert listening.grid.info == INFO


@pytest.mark.parametrize("info", [INFO, TURNED])
def test_extension_keeps_cells_in_place(info: GridInfo) -> None:
    random = np.random.default_rng(3)
    grid = GridMap(random.integers(-1, 101, info.shape).astype(np.int8), info)
    wide = covering(info, [Pose2D(-5.0, 2.0), Pose2D(6.0, -7.0)])
    over = extended(grid, wide)
    cells = np.argwhere(np.ones(info.shape, np.bool_))
    placed = wide.to_cells(info.to_world(cells))
    assert (over.data[tuple(placed.T)] == grid.data.ravel()).all()
    assert all(wide.cell_of(x, y) is not None for x, y in ((-5.0, 2.0), (6.0, -7.0)))


def test_the_map_is_not_extended_to_goals_that_are_too_far_away(listening: Listening) -> None:
    far, near = Pose2D(1e7, 0.0), Pose2D(5.0, 0.0)
    assert covering(INFO, [far]) is INFO
    assert covering(INFO, [far, near]) == covering(INFO, [near])
    listening.send(GridMapMessage(FREE))
    listening.run(0.2)
    listening.node.goals = [far]
    assert listening.node.layer.waits() == "", "planning then fails, with its own words"


def test_the_map_of_another_frame_is_waited_for(listening: Listening) -> None:
    listening.send(GridMapMessage(FREE))
    listening.run(0.2)
    other = GridMap(FREE.data.copy(), TURNED)
    listening.send(GridMapMessage(other))
    listening.node.layer.expect()
    assert listening.node.layer.waits().startswith("the map is in another frame")
    listening.run(0.15)
    assert listening.grid is other
    assert listening.node.layer.waits() == ""
    listening.node.layer.expect()
    listening.run(0.15)
    assert listening.node.layer.waits() == "", "the map came before the frame"
