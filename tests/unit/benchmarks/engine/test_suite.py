"""``ppaas bench engine`` measures a real cloud, its containers and machines, and a real master."""

import json
from typing import Any

import pytest

from benchmarks.commands.cloud import EngineBench
from benchmarks.engine import master, options, standby, suite
from robots.cli.main import main

pytestmark = pytest.mark.journey


def figures(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, dict[str, Any]]:
    """Run the bench; return its figures by their names."""
    assert main(["bench", "engine", "--quick", "--json", *arguments]) == 0
    return {figure["name"]: figure for figure in json.loads(capsys.readouterr().out)["figures"]}


def test_containers_machines_and_messages_are_measured_with_baselines(
    capsys: pytest.CaptureFixture[str],
) -> None:
    parts = ("ready", "crowd", "crash", "lost", "messages", "people")
    measured = figures(capsys, "--containers", "2", *(word for part in parts for word in ("--only", part)))
    assert (measured["container ready"]["limit"], measured["robot served again"]["limit"]) == (100.0, 500.0)
    assert measured["containers that answer"]["value"] == 2
    assert measured["memory of each"]["value"] > 1.0
    assert measured["machine killed"]["limit"] == 5000.0
    assert measured["report in a state"]["least"] > 0.0 and measured["states again"]["limit"] == 500.0
    assert {name for name, figure in measured.items() if figure.get("yardstick")} == {
        "python -c pass", "python -c pass, as many", "fork, answered", "a byte to a process and back",
    }  # fmt: skip
    assert {"in a container", "between containers of a machine", "between two machines"} <= set(measured)


def test_a_killed_master_loses_no_placement_or_setting(capsys: pytest.CaptureFixture[str]) -> None:
    measured = figures(capsys, "--only", "master", "--placements", "100", "--machines", "8")
    assert measured["placements by ppaas"]["limit"] == measured["placements by first_fit"]["limit"] == 2000.0
    assert measured["orders, without a master"]["yardstick"]
    assert 50 <= measured["placements made anew"]["value"] == measured["placements made anew"]["limit"]
    assert 1 <= measured["checkpoints gone on from"]["value"] == measured["checkpoints gone on from"]["limit"]
    assert measured["settings of machines kept"]["value"] == measured["settings of machines kept"]["limit"] == 4
    assert measured["placed where none may be"]["value"] == 0


def test_every_known_part_and_runtime_can_be_selected() -> None:
    assert set(EngineBench.PARTS) == {*suite.PARTS, standby.PART, master.PART}
    assert set(EngineBench.RUNTIMES) == set(options.RUNTIMES)


def test_invalid_options_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    for arguments in (["--only", "weather"], ["--containers", "0"], ["--runtime", "none"], ["--machines", "-1"]):
        with pytest.raises(SystemExit):
            main(["bench", "engine", *arguments])
    assert "from 1 to" in capsys.readouterr().err
