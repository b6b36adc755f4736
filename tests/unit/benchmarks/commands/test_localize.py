"""``ppaas bench localize``."""

import json
from pathlib import Path

import pytest

from robots.cli.main import main
from tests.support.world.drive_log import graph_log

RUN = ["bench", "localize", "--runs", "1", "--metres", "3", "--jobs", "1"]


def test_the_summary_of_all_runs_is_returned(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*RUN, "--json", "--set", "laser_max_beams=30", "--set", "laser_model_type=likelihood_field_prob"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert (result["map"], result["kind"], result["runs"], result["lost"]) == ("office", "track", 1, 0)
    assert 0.0 < result["error_cm"] < 10.0


def test_people_crowd_around_the_robot_with_jam(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*RUN, "--json", "--jam", "10"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert (result["kind"], result["runs"], result["lost"]) == ("jam", 1, 0)
    assert result["metres"] > 3.2  # it moved on slowly among them


@pytest.mark.parametrize(("option", "metres"), [("--stand", (0.0, 0.5)), ("--creep", (0.1, 1.0))])
def test_errors_of_a_robot_that_stands_or_creeps_are_measured(
    option: str, metres: tuple[float, float], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*RUN, "--json", option, "0.5"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert (result["kind"], result["runs"], result["lost"]) == (option.removeprefix("--"), 1, 0)
    assert metres[0] <= result["metres"] <= metres[1]
    assert result["worst_deg"] < 2.0


def test_update_times_are_measured(capsys: pytest.CaptureFixture[str]) -> None:
    command = ["bench", "localize", "--update", "--particles", "100,200", "--threads", "1"]
    assert main([*command, "--json"]) == 0
    updates = json.loads(capsys.readouterr().out)["updates"]
    assert [(row["particles"], row["threads"]) for row in updates] == [(100, 1), (200, 1)]
    assert all(row["update_ms"] > 0.0 for row in updates)
    assert main(command) == 0
    assert "update_ms" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("wrong", "error"),
    [
        (["--set", "max_beams=3"], "max_beams"),
        (["--set", "laser_model_type=sonar"], "laser_model_type"),
        (["--map", "nowhere.yaml"], "nowhere.yaml"),
    ],
)
def test_unknown_and_invalid_options_are_refused(
    capsys: pytest.CaptureFixture[str], wrong: list[str], error: str
) -> None:
    assert main([*RUN, *wrong]) == 1
    assert error in capsys.readouterr().err


def test_a_log_is_replayed_on_its_own_map_and_drawn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log, picture = tmp_path / "drive.log", tmp_path / "out.png"
    log.write_text(graph_log(40))
    assert main(["bench", "localize", str(log), "--drift", "0.02", "--plot", str(picture), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert (result["recording"], result["map"]) == (str(log), "of the recording")
    assert (result["kind"], result["scans"]) == ("track", 20)
    assert result["lost"] is False
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("wrong", "error"),
    [
        (["--kidnap"], "--kidnap"),
        (["--jam", "3"], "--jam"),
        (["--stand", "3"], "--stand"),
        (["--update"], "--update"),
        (["--plot", "out.pdf"], "PNG"),
    ],
)
def test_options_that_do_not_apply_to_a_recording_are_refused(
    capsys: pytest.CaptureFixture[str], wrong: list[str], error: str
) -> None:
    assert main(["bench", "localize", "drive.log", *wrong]) == 1
    assert error in capsys.readouterr().err


def test_a_plot_requires_a_recording(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*RUN, "--plot", "out.png"]) == 1
    assert "only for a recording" in capsys.readouterr().err
