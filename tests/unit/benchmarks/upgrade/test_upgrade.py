"""``ppaas bench upgrade``: options, output, exit status, and what counts for a step."""

import json
import sys

import pytest
from rich.progress import Progress

from benchmarks.upgrade import run as upgrade
from benchmarks.upgrade.report import UpgradeReport, UpgradeStep
from ppaas.errors import Unavailable
from robots.cli.main import main


def report(lost: int = 0, silence: float = 0.0, wrong: tuple[str, ...] = ()) -> UpgradeReport:
    return UpgradeReport(
        before="0.2.0 /old", after="0.3.0 /new", robots=6, killed=False,
        steps=[UpgradeStep("before", 10.0, 0.0, 0.0), UpgradeStep("m2 upgraded", 8.0, 1.5, silence)],
        goals=12, lost=lost, commands=1000, releases={"m2": "0.3.0"}, wrong=list(wrong),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("told", "passed"),
    [(report(), True), (report(lost=1), False), (report(silence=2.1), False), (report(wrong=("a",)), False)],
)
def test_an_upgrade_passes_without_lost_goals_and_long_breaks(told: UpgradeReport, passed: bool) -> None:
    assert told.passed is passed


def test_options_and_status(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    seen: list[upgrade.UpgradeOptions] = []

    async def run(options: upgrade.UpgradeOptions, progress: Progress) -> UpgradeReport:
        seen.append(options)
        return report(lost=options.robots - 6)

    monkeypatch.setattr(upgrade, "run", run)
    assert main(["bench", "upgrade"]) == 0
    assert "m2 upgraded" in (printed := capsys.readouterr().out) and "12 goals, 0 lost" in printed
    typed = ["--from", "/a/python", "--to", "/b/python", "--robots", "7", "--settle", "2", "--kill", "--seed", "3"]
    assert main(["bench", "upgrade", *typed, "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["lost"] == 1
    assert seen == [
        upgrade.UpgradeOptions(sys.executable, sys.executable),
        upgrade.UpgradeOptions("/a/python", "/b/python", robots=7, kill=True, settle=2.0, seed=3),
    ]


async def test_the_release_of_an_environment_is_the_one_that_is_installed_there() -> None:
    assert (await upgrade.release_of(sys.executable)).startswith("0.")
    with pytest.raises(Unavailable, match="/bin/false has no release"):
        await upgrade.release_of("/bin/false")
