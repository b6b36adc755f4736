"""operators-day.md: all of it is typed into one shell, on a clean data folder, and prints what the page shows."""

import os
import re
import signal
import socket
import subprocess
import sys
from contextlib import ExitStack, suppress
from pathlib import Path

import psutil
import pytest

from tests.support.documents import BLOCK, ELSEWHERE, text_of
from tests.support.sources import ROOT

PAGE = "docs/operators-day.md"

TIMEOUT = 240.0
TYPED_ELSEWHERE = (*(word for word in ELSEWHERE if word != "ppaas up"), "ppaas warm")
"""First words of lines that are not typed: the installation, and its kernels, are there."""

PORTS = ("8500", "8501", "9464", "9465", "9000")
"""Ports of the page; a test takes free ones."""

VARIES = re.compile(r"…|(?=[a-f]*\d)[0-9a-f]{6,}|\d[\d.,:-]*|\s+|-+")
"""Parts of a line that are others each time: what the page leaves out, ids and numbers, and the width of columns."""


def free_ports(count: int) -> list[str]:
    with ExitStack() as stack:
        found = [stack.enter_context(socket.create_server(("127.0.0.1", 0))) for _ in range(count)]
        return [str(each.getsockname()[1]) for each in found]


def pattern_of(line: str) -> re.Pattern[str]:
    """Return what a printed line must look like to be the line of the page."""

    def part(text: str) -> str:
        if text == "…":
            return ".*"
        if text.isspace():
            return r"\s+"
        return "-+" if set(text) == {"-"} else r"[\w.,:-]+"

    pieces, at = [], 0
    for found in VARIES.finditer(line.rstrip()):
        pieces += [re.escape(line[at : found.start()]), part(found[0])]
        at = found.end()
    return re.compile("".join([*pieces, re.escape(line.rstrip()[at:])]) + r"\s*")


def missing(shown: str, printed: str) -> list[str]:
    """Return the lines of the page that were not printed, in their order."""
    lines, absent, at = printed.splitlines(), list[str](), 0
    for line in shown.splitlines():
        if line.strip() == "…":
            continue
        pattern = pattern_of(line)
        found = next((number for number in range(at, len(lines)) if pattern.fullmatch(lines[number])), None)
        if found is None:
            absent.append(line)
        else:
            at = found + 1
    return absent


def steps() -> list[tuple[str, str]]:
    """Return what is typed, and what the page shows after it, which may be nothing."""
    found: list[tuple[str, str]] = []
    for language, code in BLOCK.findall(text_of(PAGE)):
        if language == "sh":
            typed = [line for line in code.splitlines() if not line.startswith(TYPED_ELSEWHERE)]
            found.append(("\n".join(typed), ""))
        elif language == "text":
            found[-1] = found[-1][0], found[-1][1] + code
    return found


def marker(number: int) -> str:
    return f"=== step {number} has ended ==="


def type_all(folder: Path) -> tuple[int, str]:
    """Type the page into one shell; return its exit status, and all that was printed."""
    (folder / "docs").symlink_to(ROOT / "docs")
    lines = ["set -euo pipefail", "exec 2>&1"]
    for number, (typed, _) in enumerate(steps()):
        lines += [typed, f"echo '{marker(number)}'"]
    code = "\n".join(lines)
    for port, free in zip(PORTS, free_ports(len(PORTS)), strict=True):
        code = re.sub(rf"(?<!\d){port}(?!\d)", free, code)
        if port == "8500":
            own = {"PPAAS_PORT": free, "PPAAS_URL": f"http://127.0.0.1:{free}"}
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    environment = os.environ | own | {"PATH": path, "PYTHONUNBUFFERED": "1", "COLUMNS": "160"}
    with (folder / "printed").open("wb") as output:
        shell = subprocess.Popen(
            ["bash", "-c", code], cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=output,
            start_new_session=True,
        )  # fmt: skip
        try:
            shell.wait(TIMEOUT)
        finally:
            end_session(shell.pid)
    return shell.returncode, (folder / "printed").read_text()


def end_session(session: int) -> None:
    """End what a failed step has left, in the order in which a cloud ends its own processes."""
    left = [process for process in psutil.process_iter() if _is_of(process, session)]
    for number in (signal.SIGTERM, signal.SIGKILL):
        for process in left:
            with suppress(psutil.NoSuchProcess):
                process.send_signal(number)
        _, left = psutil.wait_procs(left, 15.0)


def _is_of(process: psutil.Process, session: int) -> bool:
    try:
        return os.getsid(process.pid) == session
    except ProcessLookupError:
        return False


@pytest.mark.journey
def test_the_page_prints_what_it_shows(tmp_path: Path) -> None:
    status, printed = type_all(tmp_path)
    assert status == 0, printed[-6000:]
    parts = re.split(r"^=== step \d+ has ended ===\n", printed, flags=re.MULTILINE)
    for (typed, shown), found in zip(steps(), parts, strict=False):
        assert not (absent := missing(shown, found)), f"{typed}\nprinted\n{found}\nbut not\n" + "\n".join(absent)


@pytest.mark.parametrize(
    ("shown", "printed", "absent"),
    [
        ("tb1  online  97 %", "tb1   online  5 %", []),
        ("a\nb", "b\na", ["b"]),
        ("id wh-01\n…\nend", "id wh-7f\nx\nend", []),
        ("tb1  online", "tb1  offline", ["tb1  online"]),
    ],
)
def test_lines_are_compared_but_for_numbers(shown: str, printed: str, absent: list[str]) -> None:
    assert missing(shown, printed) == absent
