"""Runs: metrics of tracking, the file of results, and mirrors in the world."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.people.runs.job import append_result, check_results, key_of, read_results
from benchmarks.people.runs.run import TrackRecord
from benchmarks.people.runs.scene import GAP, hang_mirrors
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from robots.demo.people_score import ScoredFrame
from robots.sim.shortest_paths import ShortestPaths
from robots.sim.world import World
from tests.support.world.rooms import room
from tests.unit.benchmarks.people.runs.results import JOB, RESULT

AT = np.array([[0.0, 0.0], [5.0, 0.0]])


def frame(identities: dict[int, int], *, edge: tuple[int, ...] = ()) -> ScoredFrame:
    at_edge = np.isin(np.arange(2), edge)
    positions = AT[list(identities.values())].reshape(-1, 2)
    return ScoredFrame(~at_edge, at_edge, list(identities), positions, dict(identities))


def test_right_tracks_have_metrics_of_one() -> None:
    record = TrackRecord()
    for _ in range(10):
        record.take(frame({7: 0, 9: 1}), AT)
    assert record.metrics() == pytest.approx((1.0, 1.0))


def test_switched_identities_and_missed_people_make_both_smaller() -> None:
    record = TrackRecord()
    for tick in range(10):
        record.take(frame({7: 0, 9: 1} if tick < 5 else {9: 0}), AT)
    hota, mota = record.metrics()
    assert mota == pytest.approx((20 - 5 - 1) / 20)
    assert 0.4 < hota < 0.8


def test_people_at_the_edge_count_neither_way() -> None:
    record = TrackRecord()
    for tick in range(10):
        record.take(frame({7: 0, 9: 1} if tick % 2 else {7: 0}, edge=(1,)), AT)
    assert record.metrics() == pytest.approx((1.0, 1.0))


def test_nobody_to_track_and_nobody_tracked_is_right() -> None:
    assert TrackRecord().metrics() == (1.0, 1.0)


def test_a_stored_result_is_found_by_the_settings_of_its_run(tmp_path: Path) -> None:
    path = tmp_path / "runs.jsonl"
    assert read_results(path) == {}
    append_result(path, JOB, RESULT)
    append_result(path, replace(JOB, seed=1), RESULT)
    known = read_results(path)
    assert known[key_of(JOB)] == RESULT
    assert key_of(replace(JOB, policy="single")) not in known


def test_a_file_of_something_else_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("no result\n")
    with pytest.raises(InvalidInput, match="name another file"):
        read_results(path)


def test_a_file_that_cannot_be_written_is_refused_before_the_first_run(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=r"cannot write results to .*: No such file or directory"):
        check_results(tmp_path / "missing" / "runs.jsonl")
    check_results(tmp_path / "runs.jsonl")
    assert read_results(tmp_path / "runs.jsonl") == {}


def test_mirrors_hang_on_straight_walls_and_face_the_room() -> None:
    grid = room(5.0, 4.0, origin=Pose2D(1.0, -2.0, 0.3))
    world = World(grid)
    assert hang_mirrors(world, ShortestPaths(grid, 0.35, np.random.default_rng(1)), 4) == 4
    for piece in world.furniture:
        x, y, theta = grid.info.origin.inverse() @ piece.pose
        wall = {0: x - 0.05, 1: y - 0.05, 2: 4.95 - x, 3: 3.95 - y}[round(theta / (0.5 * np.pi)) % 4]
        assert wall == pytest.approx(GAP, abs=1e-3)
        assert min(x, 5.0 - x) + min(y, 4.0 - y) >= 0.6


def test_no_mirror_hangs_where_no_wall_is_near() -> None:
    grid = room(30.0, 30.0)
    world = World(grid)
    middle = ShortestPaths(grid, 10.0, np.random.default_rng(1))
    assert hang_mirrors(world, middle, 1) == 0
    assert world.furniture == []
