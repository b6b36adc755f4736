"""The units of systemd are valid, hardened, and call commands and options that exist."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.deploy import under_filter
from tests.support.sources import ROOT

UNITS = ROOT / "deploy" / "systemd"
SERVICES = sorted(UNITS.glob("*.service"))
EXPOSURE = 40
"""Limit of the exposure that ``systemd-analyze security`` computes, in tenths."""

pytestmark = pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="no systemd-analyze: install systemd")


@pytest.fixture
def units(tmp_path: Path) -> Path:
    """Return a folder with the units, which start the command of this environment."""
    command = Path(sys.executable).with_name("ppaas")
    for unit in UNITS.iterdir():
        (tmp_path / unit.name).write_text(unit.read_text().replace("/opt/ppaas/bin/ppaas", str(command)))
    return tmp_path


def test_the_units_are_valid(units: Path) -> None:
    done = subprocess.run(
        ["systemd-analyze", "verify", "--man=no", *sorted(units.glob("*.*"))],
        capture_output=True,
        text=True,
        check=False,
    )
    ours = [line for line in done.stderr.splitlines() if line.startswith("ppaas") or str(units) in line]
    assert ours == []


@pytest.mark.parametrize("service", SERVICES, ids=lambda service: service.stem)
def test_a_service_is_hardened(service: Path) -> None:
    command = ["systemd-analyze", "security", "--offline=yes", f"--threshold={EXPOSURE}", str(service)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("service", SERVICES, ids=lambda service: service.stem)
def test_a_service_calls_options_that_exist(service: Path) -> None:
    [start] = re.findall(r"^ExecStart=/opt/ppaas/bin/ppaas (.*)$", service.read_text(), re.MULTILINE)
    words = [word for word in start.split() if not word.startswith("$")]
    verbs = words[: next(number for number, word in enumerate(words) if word.startswith("--"))]
    shown = subprocess.run(
        [sys.executable, "-m", "robots.cli", *verbs, "--help"], capture_output=True, text=True, check=True
    ).stdout
    assert [word for word in words if word.startswith("--") and word not in shown] == []


@pytest.mark.journey
def test_a_robot_drives_under_the_system_calls_that_the_service_allows() -> None:
    demo = [sys.executable, "-m", "robots.cli", "demo", "--headless", "--robots", "1", "--goals", "1"]
    command = [sys.executable, "-m", under_filter.__name__, str(UNITS / "ppaas.service"), *demo]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=240, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "1 of 1 goals reached" in done.stdout
