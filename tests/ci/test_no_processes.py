"""``make unit`` leaves out tests that start processes, and refuses those that are not left out."""

import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

from tests.support.sources import ROOT

TESTS = """
import asyncio, os, subprocess, sys
import pytest

START = [sys.executable, "-c", ""]

@pytest.fixture
def started():
    subprocess.run(START)

async def child():
    await (await asyncio.create_subprocess_exec(*START)).wait()

def fork():
    if not (pid := os.fork()):
        os._exit(0)
    os.waitpid(pid, 0)

def test_starts(): subprocess.run(START)
def test_forks(): fork()
def test_awaits(): asyncio.run(child())
def test_has_a_fixture_that_starts(started): pass
def test_starts_nothing(): pass
"""


def test_a_test_that_starts_a_process_fails_with_advice(tmp_path: Path) -> None:
    (tmp_path / "test_it.py").write_text(TESTS)
    (tmp_path / "pytest.ini").write_text("[pytest]\naddopts = -p tests.ci.no_processes\n")
    command = [sys.executable, "-m", "pytest", f"--junit-xml={tmp_path}/report.xml", str(tmp_path)]
    subprocess.run(command, cwd=tmp_path, env={"PYTHONPATH": str(ROOT)}, capture_output=True, check=False)
    cases = [*ET.parse(tmp_path / "report.xml").iter("testcase")]
    faults = {case.get("name"): "".join(fault.get("message", "") for fault in case) for case in cases}
    assert faults.pop("test_starts_nothing") == ""
    assert len(faults) == 4
    assert all("add the file to tests/ci/not_unit" in fault for fault in faults.values()), faults


def test_files_that_are_left_out_exist_in_order() -> None:
    files = (ROOT / "tests" / "ci" / "not_unit").read_text().splitlines()
    assert files == sorted(set(files))
    assert [file for file in files if not (ROOT / file).is_file()] == []
