"""``ppaas bench localize``."""

import json
from pathlib import Path

import pytest

from robots.cli.main import main
from tests.support.world.drive_log import graph_log

RUN = ["bench", "localize", "--runs", "1", "--metres", "3", "--jobs", "1"]


def test_it_tells_what_all_runs_come_to(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*RUN, "--json", "--set", "laser_max_beams=30", "--set", "laser_model_type=likelihood_field_prob"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["map"], told["kind"], told["runs"], told["lost"]) == ("office", "track", 1, 0)
    assert 0.0 < told["error_cm"] < 10.0


def test_it_has_people_crowd_around_the_robot(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*RUN, "--json", "--jam", "10"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["kind"], told["runs"], told["lost"]) == ("jam", 1, 0)
    assert told["metres"] > 3.2  # it crept on among them


def test_it_tells_how_long_an_update_takes(capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["bench", "localize", "--update", "--particles", "100,200", "--threads", "1"]
    assert main([*asked, "--json"]) == 0
    updates = json.loads(capsys.readouterr().out)["updates"]
    assert [(row["particles"], row["threads"]) for row in updates] == [(100, 1), (200, 1)]
    assert all(row["update_ms"] > 0.0 for row in updates)
    assert main(asked) == 0
    assert "update_ms" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        (["--set", "max_beams=3"], "max_beams"),
        (["--set", "laser_model_type=sonar"], "laser_model_type"),
        (["--map", "nowhere.yaml"], "nowhere.yaml"),
    ],
)
def test_what_there_is_not_is_refused(capsys: pytest.CaptureFixture[str], wrong: list[str], told: str) -> None:
    assert main([*RUN, *wrong]) == 1
    assert told in capsys.readouterr().err


def test_it_plays_a_log_on_a_map_of_its_own_and_draws_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log, picture = tmp_path / "drive.log", tmp_path / "out.png"
    log.write_text(graph_log(40))
    assert main(["bench", "localize", str(log), "--drift", "0.02", "--plot", str(picture), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["recording"], told["map"], told["kind"], told["scans"]) == (str(log), "of the recording", "track", 20)
    assert told["lost"] is False
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("wrong", "told"),
    [(["--kidnap"], "--kidnap"), (["--jam", "3"], "--jam"), (["--update"], "--update"), (["--plot", "out.pdf"], "PNG")],
)
def test_what_a_recording_is_not_for_is_refused(
    capsys: pytest.CaptureFixture[str], wrong: list[str], told: str
) -> None:
    assert main(["bench", "localize", "drive.log", *wrong]) == 1
    assert told in capsys.readouterr().err


def test_a_picture_is_of_a_recording(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*RUN, "--plot", "out.png"]) == 1
    assert "only for a recording" in capsys.readouterr().err
