"""The picture of a drive among people."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from benchmarks.navigation.goals import picture, run
from benchmarks.navigation.goals.run import Job
from ppaas.errors import InvalidInput
from ppaas.maps.generate import office

JOB = Job("office", office(seed=1, width=12.0, height=10.0), 1, 1, "dwa", {}, seed=3, drive=0)


def test_it_shows_the_way_the_costs_the_particles_and_people(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "PATIENCE", 3.0)
    monkeypatch.setattr(run, "SLOWEST", 10.0)
    path = tmp_path / "out.png"
    picture.write_picture(path, JOB)
    colours = {tuple(colour) for colour in np.array(Image.open(path)).reshape(-1, 3)[::3].tolist()}
    wanted = {picture.WALL, picture.FLOOR, picture.WAY, picture.PARTICLE, picture.PERSON, picture.SEEN, picture.NEAR}
    assert wanted <= colours
    with pytest.raises(InvalidInput, match="picture"):
        picture.write_picture(tmp_path / "nowhere" / "out.png", JOB)
