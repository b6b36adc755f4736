"""Control cycles of local planners, timed on the way to the same goals."""

from itertools import count

import numpy as np
import pytest

from benchmarks.navigation import clone_cpu
from benchmarks.navigation.control_cycles import WINDOW, Cycles, Setup, measure, setups, summary, window
from ppaas.controllers.registry import controller_names
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import NotFound, PPaaSError
from ppaas.geometry import Pose2D
from ppaas.maps.generate import office
from ppaas.maps.grid import GridMap


@pytest.fixture(scope="module")
def grid() -> GridMap:
    return office(seed=1, width=12.0, height=10.0)


def test_all_local_planners_and_dwa_with_ros_settings_are_measured() -> None:
    assert [setup.name for setup in setups()][:-1] == list(controller_names())
    assert setups()[-1].parameters["vx_samples"] == 20
    assert [setup.planner for setup in setups(("nav2_mppi_controller/MPPIController",))] == ["mppi"]
    with pytest.raises(NotFound, match="hands"):
        setups(("hands",))


def test_every_planner_drives_to_all_goals_and_each_cycle_is_timed(grid: GridMap) -> None:
    readings, drives = count(), []
    measured = measure(
        grid, setups(("pure_pursuit",)), 2, seed=3, clock=lambda: 0.001 * next(readings), done=lambda: drives.append(1)
    )
    [row] = summary(measured)
    assert (row["arrived"], row["goals"], len(drives)) == (2, 2, 2)
    assert (row["median_ms"], row["longest_ms"]) == (1.0, 1.0), "the clock is read twice per cycle"
    assert row["cycles"] > 100


def test_the_window_is_centred_at_the_robot_and_unknown_off_the_map(grid: GridMap) -> None:
    costmap = build_layers(grid, robot_radius=0.18).costmap
    inside, corner = Pose2D(6.0, 5.0, 1.0), Pose2D(0.5, 9.5, 0.0)
    for pose in (inside, corner):
        seen = window(costmap, pose)
        assert seen.data.shape == (WINDOW, WINDOW)
        rows, columns = np.mgrid[0:WINDOW:7, 0:WINDOW:7].reshape(2, -1)
        for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
            x, y = seen.info.to_world((row, column))
            cell = costmap.info.cell_of(float(x), float(y))
            assert seen.data[row, column] == (255 if cell is None else costmap.data[cell])
    assert (window(costmap, corner).data == 255).any()


def test_a_planner_without_a_cycle_is_an_error() -> None:
    with pytest.raises(PPaaSError, match="hands started at each of its goals"):
        summary([Cycles(Setup("hands", "hands"))])


def test_a_clone_is_measured_while_its_robot_drives() -> None:
    laps: list[None] = []
    spent = clone_cpu.measure(1, 3, done=lambda: laps.append(None))
    assert spent.commands >= 15 and len(spent.frames) == 30 and laps
    told = {str(row["work"]): float(str(row["ms"])) for row in clone_cpu.rows(spent)}
    causes = [told[cause] for cause in clone_cpu.CAUSES]
    assert min(causes) > 0.0 and abs(told["in all"] - sum(causes)) < 0.1
    parts = [ms for work, ms in told.items() if work.startswith(("node ", "links"))]
    assert abs(told["in all"] - sum(parts)) < 0.5
    assert told["json, the same frames"] > 0.0
