"""``ppaas bench engine`` measures a real cloud, its containers and machines, and a real master."""

import json
from typing import Any

import pytest

from benchmarks.commands import engine
from benchmarks.engine import master, options, suite
from robots.cli.main import main

pytestmark = pytest.mark.journey


def figures(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, dict[str, Any]]:
    """Run the bench; return its figures by their names."""
    assert main(["bench", "engine", "--quick", "--json", *arguments]) == 0
    return {figure["name"]: figure for figure in json.loads(capsys.readouterr().out)["figures"]}


def test_containers_machines_and_messages_are_measured_with_baselines(
    capsys: pytest.CaptureFixture[str],
) -> None:
    parts = ("ready", "crowd", "crash", "lost", "messages")
    told = figures(capsys, "--containers", "2", *(word for part in parts for word in ("--only", part)))
    assert (told["container ready"]["limit"], told["robot served again"]["limit"]) == (100.0, 500.0)
    assert told["containers that answer"]["value"] == 2
    assert told["memory of each"]["value"] > 1.0
    assert told["machine killed"]["limit"] == 5000.0
    assert {name for name, figure in told.items() if figure.get("yardstick")} == {
        "python -c pass", "python -c pass, as many", "fork, answered", "a byte to a process and back",
    }  # fmt: skip
    assert {"in a container", "between containers of a machine", "between two machines"} <= set(told)


def test_a_master_places_is_killed_and_loses_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    told = figures(capsys, "--only", "master", "--placements", "100", "--machines", "8")
    assert told["placements by ppaas"]["limit"] == told["placements by first_fit"]["limit"] == 2000.0
    assert told["orders, without a master"]["yardstick"]
    assert 50 <= told["placements made anew"]["value"] == told["placements made anew"]["limit"]
    assert 1 <= told["checkpoints gone on from"]["value"] == told["checkpoints gone on from"]["limit"]
    assert told["settings of machines kept"]["value"] == told["settings of machines kept"]["limit"] == 4
    assert told["placed where none may be"]["value"] == 0


def test_every_part_and_runtime_that_can_be_named_is_known() -> None:
    assert set(engine.PARTS) == {*suite.PARTS, master.PART}
    assert set(engine.RUNTIMES) == set(options.RUNTIMES)


def test_what_cannot_be_asked_for_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    for arguments in (["--only", "weather"], ["--containers", "0"], ["--runtime", "none"], ["--machines", "-1"]):
        with pytest.raises(SystemExit):
            main(["bench", "engine", *arguments])
    assert "from 1 to" in capsys.readouterr().err
