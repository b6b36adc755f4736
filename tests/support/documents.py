"""The documents as tests see them: their code, their tables, and a shell that runs what they tell readers to type."""

import os
import re
import subprocess
import sys
from pathlib import Path

from tests.support.cloud.cloud import ADMIN_PASSWORD, RunningCloud
from tests.support.sources import ROOT

BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
ROW = re.compile(r"^\|(.+)\|$", re.MULTILINE)
WRAPPED = re.compile(r"^[`*]+([^`*]+)[`*]+$")
ADDRESS = "http://127.0.0.1:8500"

ELSEWHERE = ("make ", "pip ", "python3 -m venv", "ppaas up")
"""What a test has done already, in its own way: the first words of lines that are not run."""


def text_of(document: str) -> str:
    """Return a document, by its path from the root."""
    return (ROOT / document).read_text(encoding="utf-8")


def blocks(document: str, language: str) -> list[str]:
    """Return the blocks of code in one language."""
    return [code for found, code in BLOCK.findall(text_of(document)) if found == language]


def table(document: str, *header: str) -> list[tuple[str, ...]]:
    """Return the rows of the table with this header; a cell that is all code or bold is its text."""
    found = (re.split(r"(?<!\\)\|", row) for row in ROW.findall(text_of(document)))
    rows = [tuple(WRAPPED.sub(r"\1", cell.strip()) for cell in cells) for cells in found]
    start = rows.index(header) + 2
    ends = (
        i for i in range(start, len(rows)) if len(rows[i]) != len(header) or rows[i + 1 : i + 2] == [rows[start - 1]]
    )
    return rows[start : next(ends, len(rows))]


def script(document: str) -> str:
    """Return all that a document has its reader type into a shell, in order, as one script."""
    lines = [line for block in blocks(document, "sh") for line in block.splitlines()]
    return "\n".join(line for line in lines if not line.startswith(ELSEWHERE))


def run_shell(code: str, folder: Path, cloud: RunningCloud) -> str:
    """Run a script as a reader would who stands in a checkout, with the cloud of the test; return what it prints.

    Parameters
    ----------
    code : str
        Of a document.
    folder : Path
        To run it in; it is made to look like the checkout of somebody who started a cloud there.
    cloud : RunningCloud
        Takes the place of the one at the address that documents give.
    """
    (folder / "var").mkdir()
    (folder / "var" / "admin-password").write_text(ADMIN_PASSWORD + "\n")
    (folder / "docs").symlink_to(ROOT / "docs")
    environment = os.environ | {
        "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
        "PPAAS_URL": cloud.url,
        "PYTHONUNBUFFERED": "1",
    }
    command = ["bash", "-c", "set -euo pipefail\n" + code.replace(ADDRESS, cloud.url)]
    ended = subprocess.run(
        command, check=False, cwd=folder, env=environment, capture_output=True, text=True, timeout=150
    )
    assert ended.returncode == 0, f"{ended.stdout}\n{ended.stderr}"
    return ended.stdout
