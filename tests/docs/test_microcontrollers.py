"""The page for microcontrollers: its program runs, and its figures are those of the client."""

import asyncio
import re
from asyncio.subprocess import PIPE
from pathlib import Path

import pytest

from tests.support.cloud.board_robot import CLIENT, HEAP, compile_for_board, micropython
from tests.support.documents import blocks, text_of

PAGE = "docs/microcontrollers.md"

MY_ROBOT = """
calls = [0]
def drive_wheels(left, right):
    pass
def read_wheels():
    calls[0] += 1
    return 0.01 * calls[0], 0.012 * calls[0]
def read_laser(ranges):
    ranges[len(ranges) - 1] = 65535
    if calls[0] > 8:
        print("read", len(ranges))
        raise SystemExit
"""


@pytest.mark.skipif(micropython() is None, reason="MicroPython is not installed: it has wheels for Linux only")
async def test_the_program_of_the_page_runs_in_its_heap(tmp_path: Path) -> None:
    [program] = blocks(PAGE, "python")
    await compile_for_board(tmp_path)
    (tmp_path / "my_robot.py").write_text(MY_ROBOT)
    (tmp_path / "main.py").write_text(program.replace("192.168.1.10", "127.0.0.1").replace("8500", "1"))
    board = await asyncio.create_subprocess_exec(
        str(micropython()), "-X", f"heapsize={HEAP}", "main.py", cwd=tmp_path, stdout=PIPE
    )
    output, _ = await board.communicate()
    assert output == b"read 360\n"


@pytest.mark.parametrize(
    ("constant", "words"),
    [("STALE = 500", "no velocity came for 0.5 s"), ("SILENT = 20000", "silent for 20 s"),
     ("inbox=1024", "`inbox` (1024 bytes)"), ('session="board"', "named `board` by default")],
)  # fmt: skip
def test_figures_are_those_of_the_client(constant: str, words: str) -> None:
    assert constant in CLIENT.read_text(encoding="utf-8")
    assert words in re.sub(r"\s+", " ", text_of(PAGE))
