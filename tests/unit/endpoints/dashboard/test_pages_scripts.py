"""Pure JavaScript modules of the dashboard, tested by node, which comes with Playwright."""

import subprocess
from pathlib import Path

import pytest
from playwright._impl._driver import compute_driver_executable

HERE = Path(__file__).parent
TESTS = sorted(HERE.glob("*.test.js"))


@pytest.mark.parametrize("file", TESTS, ids=lambda file: file.name.removesuffix(".test.js"))
def test_javascript_module_passes_its_tests(file: Path) -> None:
    node, _ = compute_driver_executable()
    command = [node, "--no-warnings", "--test-reporter=spec", str(file)]
    result = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    assert "tests 0" not in result.stdout
