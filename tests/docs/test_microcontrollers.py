"""The page for microcontrollers: its program runs, and its figures are those of the client."""

import asyncio
import re
import shutil
import subprocess
from asyncio.subprocess import PIPE
from pathlib import Path

import pytest

from tests.support.cloud.board_robot import ARDUINO, CLIENT, HEAP, STRICT, compile_for_board, micropython
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


SKETCH = """
#include <stddef.h>
#include <stdint.h>
struct WiFiClient {
  int connect(const char *, uint16_t) { return 0; }
  size_t write(const uint8_t *, size_t size) { return size; }
  int available() { return 0; }
  int read(uint8_t *, size_t) { return -1; }
  uint8_t connected() { return 0; }
  void stop() {}
};
struct { void begin(const char *, const char *) {} } WiFi;
unsigned long millis() { return 1; }
void delay(int) {}
void drive_wheels(float, float) {}
void read_wheels(float &x, float &y, float &yaw, float &speed, float &turn) { x = y = yaw = speed = turn = 0; }
void read_laser(uint16_t *ranges) { ranges[359] = 1; }
"""


@pytest.mark.skipif(shutil.which("g++") is None, reason="g++ is not installed")
def test_the_sketch_of_the_page_compiles_and_has_the_size_that_it_says(tmp_path: Path) -> None:
    [sketch] = blocks(PAGE, "cpp")
    (tmp_path / "WiFi.h").write_text("")
    (tmp_path / "my_robot.h").write_text(SKETCH)
    (tmp_path / "main.cpp").write_text(
        f"{sketch}\nstatic_assert(sizeof robot <= 2300);\nint main() {{ setup(); loop(); }}\n"
    )
    command = [
        "g++",
        *STRICT,
        "-I",
        str(ARDUINO),
        "-I",
        str(tmp_path),
        "-o",
        str(tmp_path / "main"),
        str(tmp_path / "main.cpp"),
    ]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    subprocess.run([tmp_path / "main"], check=True)


@pytest.mark.parametrize(
    ("constant", "words"),
    [("STALE = 500", "no velocity came for 0.5 s"), ("SILENT = 20000", "silent for 20 s"),
     ("inbox=1024", "`inbox` (1024 bytes)"), ('session="board"', "named `board` by default")],
)  # fmt: skip
def test_figures_are_those_of_the_client(constant: str, words: str) -> None:
    assert constant in CLIENT.read_text(encoding="utf-8")
    assert words in re.sub(r"\s+", " ", text_of(PAGE))
