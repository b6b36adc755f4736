"""Drives to goals among people: results, and reproducibility by seed."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from benchmarks.navigation.goals import picture, run
from benchmarks.navigation.goals.run import GoalsJob, GoalsResult, Trip, append, drive, key, measure, read, summary
from ppaas.errors import InvalidInput, NotFound
from ppaas.maps.generate import office

GRID = office(seed=1, width=12.0, height=10.0)
JOB = GoalsJob("small office", GRID, people=2, goals=1, controller="dwa", parameters={}, seed=3, drive=0)


@pytest.fixture
def short_goal_timeouts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Shorten the time limit of each goal to some seconds."""
    monkeypatch.setattr(run, "PATIENCE", 3.0)
    monkeypatch.setattr(run, "SLOWEST", 10.0)


def test_a_robot_reaches_its_goal() -> None:
    [result] = drive(JOB)
    assert result.reached
    assert result.metres > 3.0
    assert result.seconds < 60.0


@pytest.mark.usefixtures("short_goal_timeouts")
def test_drives_are_reproducible_by_seed_and_goals_time_out() -> None:
    job = dataclasses.replace(JOB, goals=2, told=True)
    one, other = (measure([job], 1, lambda: None) for _ in range(2))
    assert one == other
    assert [(result.outcome, 3.0 < result.seconds < 6.0) for result in one] == [("timeout", True)] * 2
    assert all(result.metres > 0.1 for result in one)


@pytest.mark.usefixtures("short_goal_timeouts")
def test_stored_results_are_reused_for_the_same_drive_only(tmp_path: Path) -> None:
    path, driven = tmp_path / "kept.jsonl", []
    first, second = JOB, dataclasses.replace(JOB, drive=1)
    one = measure([first], 1, lambda: driven.append(1), path)
    both = measure([first, second], 1, lambda: driven.append(2), path)
    assert (both[:1], [result.drive for result in both], driven) == (one, [0, 1], [1, 2, 2])
    lines = path.read_text().splitlines()
    assert len(lines) == 2
    assert measure([second, first], 1, lambda: None, path) == both[::-1]
    assert path.read_text().splitlines() == lines
    assert key(first) not in {key(dataclasses.replace(first, people=3)), key(dataclasses.replace(first, seed=4))}


def test_an_infinite_distance_to_people_is_stored(tmp_path: Path) -> None:
    result = GoalsResult("office", 0, 0, "reached", 30.0, 12.0, 0, walls=0, caused=0, suffered=0, nearest=float("inf"))
    append(tmp_path / "kept.jsonl", JOB, [result])
    assert read(tmp_path / "kept.jsonl") == {key(JOB): [result]}


@pytest.mark.parametrize("wrong", ["no JSON", "[]", '{"job": "a", "results": [{"map": "office"}]}'])
def test_a_file_of_something_else_is_refused(tmp_path: Path, wrong: str) -> None:
    (tmp_path / "kept.jsonl").write_text(wrong + "\n")
    with pytest.raises(InvalidInput, match="name another file"):
        measure([JOB], 1, lambda: None, tmp_path / "kept.jsonl")


def test_people_start_away_from_the_robot_and_plug_ins_are_checked() -> None:
    trip = Trip(dataclasses.replace(JOB, people=3))
    here = trip.robot.base.pose
    assert all(here.distance_to(here._replace(x=x, y=y)) >= 3.0 for x, y in trip.world.people().tolist())
    with pytest.raises(NotFound, match="hands"):
        Trip(dataclasses.replace(JOB, controller="hands"))


def test_the_summary_aggregates_all_goals() -> None:
    reached = GoalsResult("office", 0, 0, "reached", 30.0, 12.0, 1, walls=0, caused=0, suffered=2, nearest=-0.001)
    late = dataclasses.replace(reached, goal=1, outcome="timeout", walls=1, caused=2, suffered=0, nearest=0.3)
    totals = summary([reached, late])
    assert (totals["goals"], totals["reached"], totals["mean_seconds"], totals["metres"]) == (2, 1, 30.0, 24.0)
    assert (totals["collisions"], totals["caused"], totals["walls"], totals["touched_by_people"]) == (5, 3, 1, 2)
    assert (totals["recoveries"], totals["nearest_m"], totals["failures"]) == (2, -0.001, {"timeout": 1})
    alone = dataclasses.replace(late, nearest=float("inf"))
    assert (summary([alone])["nearest_m"], summary([alone])["mean_seconds"]) == (None, None)


PICTURED = GoalsJob("office", office(seed=1, width=12.0, height=10.0), 1, 1, "dwa", {}, seed=3, drive=0)


def test_the_picture_shows_path_costs_particles_and_people(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "PATIENCE", 3.0)
    monkeypatch.setattr(run, "SLOWEST", 10.0)
    encounter = picture.ClosestEncounter()
    run.drive(PICTURED, encounter.watch)
    [axes] = picture.draw(PICTURED.grid, encounter).axes
    lines = {line.get_label(): np.asarray(line.get_xydata()) for line in axes.lines}
    assert lines["path"].tolist() == [list(point) for point in encounter.path]
    assert len(lines["plan"]) > 1
    assert len(lines["particles"]) == len(encounter.particles) > 0
    person, robot = axes.patches
    assert (person.get_radius(), robot.get_radius()) == (picture.PERSON_RADIUS, picture.ROBOT_RADIUS)
    cells = np.asarray(axes.images[1].get_array()).reshape(-1, 4).tolist()
    assert list(picture.NEAR) in cells and list(picture.LETHAL) in cells


def test_an_unwritable_picture_is_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(picture, "drive", lambda job, watch: [])
    with pytest.raises(InvalidInput, match="picture"):
        picture.write_picture(tmp_path / "nowhere" / "out.png", PICTURED)
    picture.write_picture(tmp_path / "out.png", PICTURED)
    with Image.open(tmp_path / "out.png") as image:
        assert image.width > image.height
