"""Processes that collect a file's tests when they run them report what pytest reports otherwise."""

import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from tests.support.sources import ROOT

CONFTEST = """
import sys
import pytest
sys.path.insert(0, {root!r})
from tests.ci import whole_files

def pytest_configure(config):
    if {wanted} and whole_files.is_wanted(config):
        config.pluginmanager.register(whole_files)

@pytest.fixture(scope="session")
def log():
    return open({log!r}, "a", buffering=1)
"""

TOP = """
import pytest

@pytest.fixture(scope="module", autouse=True)
def _module(log):
    log.write(f"{__name__} begins\\n")
    yield
    log.write(f"{__name__} ends\\n")
"""

FILES = {
    "test_a.py": TOP + "def test_passes(): pass\ndef test_fails(): assert 1 == 2\n",
    "test_b.py": TOP + "@pytest.mark.parametrize('n', range(3))\ndef test_numbers(n): assert n < 2\n",
    "below/test_c.py": TOP + "class TestGroup:\n    def test_skips(self): pytest.skip('why')\n"
    "    @pytest.mark.slow\n    def test_slow(self): pass\n",
    "below/test_e.py": "import time, pytest\n@pytest.mark.timeout(0.2)\ndef test_hangs(): time.sleep(60)\n",
    "below/test_f.py": "import pytest\n@pytest.fixture\ndef bad(): raise OSError\ndef test_g(bad): pass\n",
}


def run(folder: Path, *arguments: str, wanted: bool = True) -> tuple[int, dict[str, str], list[str]]:
    """Run the files in two processes; return the status, what became of each test, and what modules logged."""
    (folder / "below").mkdir(parents=True, exist_ok=True)
    (folder / "pytest.ini").write_text("[pytest]\nmarkers = slow\naddopts = --import-mode=importlib\n")
    log = folder / "log"
    log.touch()
    (folder / "conftest.py").write_text(CONFTEST.format(root=str(ROOT), log=str(log), wanted=wanted))
    for name, text in FILES.items():
        (folder / name).write_text(text)
    command = [sys.executable, "-m", "pytest", "-n", "2", "--dist", "loadscope", "--junit-xml", "report.xml"]
    command += [f"-pno:{plugin}" for plugin in ("schemathesis", "hypothesispytest")]  # they take a second to import
    done = subprocess.run([*command, *arguments], cwd=folder, capture_output=True, text=True, timeout=300, check=False)
    assert (folder / "report.xml").exists(), done.stdout + done.stderr
    cases = ET.parse(folder / "report.xml").getroot().iter("testcase")
    found = {f"{case.get('classname')}::{case.get('name')}": " ".join(part.tag for part in case) for case in cases}
    return done.returncode, found, log.read_text().splitlines()


@pytest.mark.parametrize("arguments", [(), ("-m", "not slow", "-k", "numbers or TestGroup")])
def test_what_is_reported_is_what_pytest_reports_otherwise(tmp_path: Path, arguments: tuple[str, ...]) -> None:
    status, found, log = run(tmp_path / "whole", *arguments)
    usual_status, usual, usual_log = run(tmp_path / "usual", *arguments, wanted=False)
    assert found
    assert (status, found, sorted(log)) == (usual_status, usual, sorted(usual_log))


def test_files_that_cannot_be_imported_are_errors_beside_the_others(tmp_path: Path) -> None:
    (tmp_path / "below").mkdir()
    (tmp_path / "below" / "test_d.py").write_text("import nothing_of_this_name\n")
    status, found, _ = run(tmp_path, "-k", "passes")
    assert (status, found) == (1, {"::below.test_d": "error", "test_a::test_passes": ""})
