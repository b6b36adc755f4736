"""Planners, parameters and numbers in local-planners.md are those of the code."""

import json
import math
import re

import numpy as np
import pytest

from benchmarks.navigation.barn.jackal import NOISE
from benchmarks.navigation.barn.run import summary
from benchmarks.navigation.goals import run
from benchmarks.navigation.goals.clone import PLANNING
from ppaas.clone.robot_body import VoxelLayerParameters, robot_heights
from ppaas.controllers.kernels.mppi import CLOSING
from ppaas.controllers.mppi_parameters import MppiParameters
from ppaas.controllers.pure_pursuit import PurePursuitParameters
from ppaas.controllers.registry import CONTROLLERS, controller_names
from ppaas.costmap.filter_masks import height_mask, raise_costs
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.maps.octomap import parse_octomap
from ppaas.navigation.blocked_path_memory import FIRST, LONGEST, WAIT
from ppaas.navigation.passive_safety import MARGIN, REACTION
from ppaas.nodes.map_server.costmap_filters import KeepoutFilterParameters, SpeedFilterParameters, filter_masks
from ppaas.nodes.move_base.people import SocialLayerParameters
from ppaas.nodes.move_base.speed_limits import SpeedFilter
from ppaas.perception.tracking import FASTEST, MOVED, SLOWEST
from ppaas.perception.unmapped_objects import LARGEST, WALL_MARGIN
from ppaas.plugins import parameters_in_use
from ppaas.robot_model.known_models import robot_model
from robots.cli.main import main
from robots.demo.contact_referee import MOVES
from robots.sim.pedestrian import PedestrianModel
from tests.support.documents import blocks
from tests.support.sources import ROOT

PAGE = (ROOT / "docs" / "local-planners.md").read_text(encoding="utf-8")


def rows(heading: str) -> list[list[str]]:
    """Return the cells of the table under a heading row that begins so."""
    after = PAGE[PAGE.index(f"| {heading} |") :].splitlines()[2:]
    count = next(index for index, line in enumerate([*after, ""]) if not line.startswith("|"))
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in after[:count]]


def names(cell: str) -> list[str]:
    return re.findall(r"`([^`]+)`", cell)


def test_the_installed_local_planners_are_listed_with_their_aliases() -> None:
    listed = {names(row[0])[0]: tuple(names(row[1])) for row in rows("plug-in")}
    assert listed == {name: CONTROLLERS.aliases(name) for name in controller_names()}


LIMITS = {"max_vel_x", "min_vel_x", "max_vel_theta", "acc_lim_x", "acc_lim_theta", "footprint", "robot_radius"}
OF_ALL = {"min_vel_trans", "min_vel_theta", "trans_stopped_vel", "rot_stopped_vel", "rotate_threshold"}
OF_MPPI = {"xy_goal_tolerance", "yaw_goal_tolerance", "allow_unknown"}


@pytest.mark.parametrize(
    ("heading", "parameters", "elsewhere"),
    [
        ("parameter", MppiParameters, LIMITS | OF_ALL),
        ("parameter of `pure_pursuit`", PurePursuitParameters, LIMITS | OF_ALL | OF_MPPI),
        ("parameter of `social_layer`", SocialLayerParameters, set()),
        ("parameter of `speed_filter`", SpeedFilterParameters, set()),
    ],
)
def test_parameters_and_defaults_are_those_of_the_code(heading, parameters, elsewhere) -> None:
    listed: dict[str, str] = {}
    for row in rows(heading):
        if row[1] != "the robot's":
            listed |= dict(zip(names(row[0]), row[1].split(", "), strict=True))
    known = parameters_in_use(parameters())
    for name, value in listed.items():
        default = known[name]
        if isinstance(default, bool | str):
            assert value == (str(default).lower() or "none"), name
        else:
            assert float(value) == default, name
    assert set(known) == set(listed) | elsewhere


def test_masks_are_named_and_scaled_as_described() -> None:
    [file] = [json.loads(code) for code in blocks("docs/local-planners.md", "json") if "keepout_filter" in code]
    assert filter_masks(file["parameters"]) == {"keepout_filter": "office_keepout", "speed_filter": "office_speeds"}
    assert set(parameters_in_use(KeepoutFilterParameters())) == set(names(rows("parameter of `speed_filter`")[0][0]))
    own = SpeedFilterParameters(**file["parameters"]["speed_filter"])
    every = GridMap(np.arange(101, dtype=np.int8)[None], GridInfo(1.0, 101, 1))
    parts = [SpeedFilter(every, own).at(Pose2D(value + 0.5, 0.5)).part for value in range(101)]
    assert parts == [1.0, *((own.base + own.multiplier * value) / 100.0 for value in range(1, 101))]
    costs = np.zeros((1, 101), np.uint8)
    raise_costs(costs, every.data)
    assert costs[0, 100] == 254
    assert np.abs(costs[0, 1:100] - 2.54 * np.arange(1, 100)).max() <= 0.5


def test_obstacle_heights_are_as_described() -> None:
    [file] = [json.loads(code) for code in blocks("docs/local-planners.md", "json") if "voxel_layer" in code]
    mast = robot_heights(robot_model("turtlebot2"), file["parameters"])
    assert mast == (None, 1.2), "from a voxel on, since nothing else is said"
    low = robot_heights(robot_model("turtlebot2"), {})
    table = parse_octomap((ROOT / "docs" / "examples" / "table.bt").read_bytes())
    over = GridInfo(0.05, 2, 2, Pose2D(1.95, 1.45))
    assert mast and low and low[1] == robot_model("turtlebot2").height
    found = [height_mask(table, over, lowest=heights[0], highest=heights[1]).data.max() for heights in (low, mast)]
    assert found == [0, 100]
    listed = {names(row[0])[0]: row[1] for row in rows("parameter of `voxel_layer`")}
    assert listed == {
        "enabled": "true",
        "min_obstacle_height": "one voxel",
        "max_obstacle_height": "height of the robot",
    }
    assert set(listed) == set(parameters_in_use(VoxelLayerParameters()))


def test_the_options_of_the_bench_are_listed(capsys) -> None:
    try:
        main(["bench", "barn", "--help"])
    except SystemExit:
        shown = set(re.findall(r"--\w+", capsys.readouterr().out))
    listed = {option for row in rows("option") for option in names(row[0])}
    assert listed | {"--json", "--help"} == shown


def test_the_noise_is_that_of_the_code() -> None:
    for name, sigma, _, bias, slip, delay, acceleration in rows("`--noise` | laser σ"):
        jackal = NOISE[names(name)[0]]
        assert sigma == f"{100 * jackal.laser.sigma:g} cm"
        assert bias == f"{jackal.odometry.gyro_bias:g} rad/s"
        assert slip == f"{100 * jackal.drive.slip_linear:g} %, {100 * jackal.drive.slip_angular:g} %"
        assert delay == f"{1000 * jackal.drive.delay:g} + {1000 * jackal.drive.lag:g} ms"
        assert acceleration == f"{jackal.drive.acc_linear:g} m/s², {jackal.drive.acc_angular:g} rad/s²"


def test_all_fields_of_the_result_are_described() -> None:
    from benchmarks.navigation.barn.run import BarnResult

    fields = summary([BarnResult(1, 0, "success", 5.0, 5.0, 0.2)])
    paragraph = PAGE[PAGE.index("The result contains") :].split("\n\n")[0]
    assert set(fields) == set(names(paragraph))


def test_numbers_of_moving_obstacles_and_blockages_are_those_of_the_code() -> None:
    text = re.sub(r"\s+", " ", PAGE)
    assert f"no longer than {LARGEST:g} m and no closer than {WALL_MARGIN:g} m to a wall" in text
    assert f"has moved {MOVED:g} m from" in text and f"travels at {SLOWEST:g} to {FASTEST:g} m/s" in text
    assert f"first waits: for {WAIT:g} s, or, if the detour is less than {WAIT:g} m longer" in text
    assert f"{REACTION:g} s to react, its acceleration to brake, and {MARGIN:g} m between them" in text
    assert f"stays blocked for {FIRST:g} s, and twice as long" in text and f"up to {LONGEST:g} s" in text
    assert CLOSING == 4.0 and "five times as much when driving towards it" in text


def test_numbers_of_the_goals_bench_are_those_of_the_code(capsys) -> None:
    text, people = re.sub(r"\s+", " ", PAGE), PedestrianModel()
    assert f"{2 * people.radius:g} m wide and walk at {people.slowest:g} to {people.fastest:g} m/s" in text
    assert f"stand for up to {people.longest_stay:g} s" in text and f"an arm's length ({people.reach:g} m)" in text
    assert f"after {people.patience:g} s without progress they go elsewhere" in text
    assert f"within {run.THERE:g} m and {math.degrees(run.TURNED):.0f}° of the goal" in text
    assert f"times out after {run.PATIENCE:g} s plus the time for its path at {run.SLOWEST:g} m/s" in text
    assert f"at more than {MOVES:g} m/s, whatever" in text and f"a plan takes {PLANNING:g} s" in text
    section = PAGE[PAGE.index("## Benchmark: goals among pedestrians") :]
    with pytest.raises(SystemExit):
        main(["bench", "goals", "--help"])
    assert set(re.findall(r"--\w+", section)) <= set(re.findall(r"--\w+", capsys.readouterr().out))
