"""``ppaas bench chaos``: options, output, and exit status."""

import json

import pytest
from rich.progress import Progress

from benchmarks.chaos import run as chaos
from benchmarks.chaos.report import ChaosReport
from robots.cli.main import main


@pytest.fixture
def runs(monkeypatch: pytest.MonkeyPatch) -> list[chaos.ChaosOptions]:
    """Return the options of runs; a run has an error only if its seed is 13."""
    seen: list[chaos.ChaosOptions] = []

    async def run(options: chaos.ChaosOptions, progress: Progress) -> ChaosReport:
        seen.append(options)
        return ChaosReport(
            seed=options.seed, robots=options.robots, operators=options.operators, machines=options.machines,
            standby=options.standby, seconds=options.seconds,
            faults={"web, killed": 2}, longest_gap_s={"web, killed": 4.5}, longest_silence_s={"web, killed": 3.5},
            goals={"sent": 3, "result": 2, "status": 0, "lost": 1}, statuses={"SUCCEEDED": 2}, not_reached={},
            paths={"path": 5},
            commands=100, sessions=2, cloud_starts=2, take_overs=1, log=[], silences=[],
            wrong=["3.0 s: a zombie"] if options.seed == 13 else [],
        )  # fmt: skip

    monkeypatch.setattr(chaos, "run", run)
    return seen


def test_defaults_are_ten_minutes_ten_robots_three_operators_three_machines_and_a_standby(
    runs: list[chaos.ChaosOptions], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["bench", "chaos"]) == 0
    assert main(["bench", "chaos", "--minutes", "0.5", "--robots", "2", "--machines", "1", "--every", "2",
                 "--operators", "0", "--no-standby"]) == 0  # fmt: skip
    assert runs == [
        chaos.ChaosOptions(600.0, 10, 3, 3, True, 5.0, 1),
        chaos.ChaosOptions(30.0, 2, 0, 1, False, 2.0, 1),
    ]
    heading, row, *_ = (line.split() for line in capsys.readouterr().out.splitlines())
    assert heading == ["fault", "times", "longest", "gap", "s", "served", "by", "nobody", "s"]
    assert row == ["web,", "killed", "2", "4.5", "3.5"]


def test_an_error_of_a_run_sets_the_exit_status(
    runs: list[chaos.ChaosOptions], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["bench", "chaos", "--seed", "13"]) == 1
    assert "WRONG: 3.0 s: a zombie" in capsys.readouterr().out
    assert main(["bench", "chaos", "--seed", "13", "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["wrong"] == ["3.0 s: a zombie"]


@pytest.mark.parametrize(
    "arguments",
    [
        ["--minutes", "0"], ["--minutes", "nan"], ["--minutes", "soon"], ["--fleet", "33"], ["--robots", "33"],
        ["--machines", "1.5"], ["--machines", "-1"], ["--every", "inf"], ["--seed", "x"],
    ],
)  # fmt: skip
def test_invalid_options_are_refused(arguments: list[str], runs: list[chaos.ChaosOptions]) -> None:
    with pytest.raises(SystemExit) as refused:
        main(["bench", "chaos", *arguments])
    assert refused.value.code == 2
    assert runs == []


def test_robots_may_all_be_in_traffic_but_there_must_be_some(
    runs: list[chaos.ChaosOptions], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["bench", "chaos", "--robots", "0", "--fleet", "4"]) == 0
    assert [(options.robots, options.fleet) for options in runs] == [(0, 4)]
    assert main(["bench", "chaos", "--robots", "0"]) != 0
    assert "at least one robot" in capsys.readouterr().err
