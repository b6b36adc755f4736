"""The picture of a drive among people."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from benchmarks.navigation.goals import picture, run
from benchmarks.navigation.goals.run import GoalsJob
from ppaas.errors import InvalidInput
from ppaas.maps.generate import office

JOB = GoalsJob("office", office(seed=1, width=12.0, height=10.0), 1, 1, "dwa", {}, seed=3, drive=0)


def test_the_picture_shows_path_costs_particles_and_people(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "PATIENCE", 3.0)
    monkeypatch.setattr(run, "SLOWEST", 10.0)
    encounter = picture.ClosestEncounter()
    run.drive(JOB, encounter.watch)
    [axes] = picture.draw(JOB.grid, encounter).axes
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
        picture.write_picture(tmp_path / "nowhere" / "out.png", JOB)
    picture.write_picture(tmp_path / "out.png", JOB)
    with Image.open(tmp_path / "out.png") as image:
        assert image.width > image.height
