"""Examples that are called without their arguments print how they are called, and no traceback."""

import subprocess
import sys

import pytest

from tests.support.sources import ROOT

SCRIPTS = (
    "drive_by_hand", "people_robot", "plot_recording", "rapyuta_check", "roslibpy_operator", "send_goal",
    "webhook_target",
)  # fmt: skip


def stopped(name: str, *arguments: str) -> str:
    """Run an example that cannot do its work, and return what it says."""
    command = [sys.executable, str(ROOT / "docs" / "examples" / f"{name}.py"), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 1
    return done.stderr


@pytest.mark.parametrize("name", SCRIPTS)
def test_an_example_without_arguments_prints_how_it_is_called(name: str) -> None:
    text = stopped(name)
    assert "Traceback" not in text
    assert f"{name}.py" in text


def test_a_recording_that_is_missing_is_named() -> None:
    assert stopped("plot_recording", "/nowhere.mcap", "x.png").startswith("there is no file /nowhere.mcap")
