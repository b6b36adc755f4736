"""The client for Arduino as a program for ARM Cortex-M0+, by Debian's cross compiler (``make test-clients``)."""

import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.support.cloud.board_robot import ARDUINO, PROGRAMS, STRICT
from tests.support.sources import ROOT

TOOLS = ROOT / "build" / "arm" / "usr"
BOARD = ("-mcpu=cortex-m0plus", "-mthumb", "-Os", "-ffunction-sections", "-fdata-sections")
NEWLIB = TOOLS / "lib" / "arm-none-eabi" / "newlib" / "thumb" / "v6-m" / "nofp"
"""The C library for this core, which has no floating-point unit."""

MAX_RAM = 20_000
"""RAM of a small board [bytes]."""

pytestmark = [
    pytest.mark.clients,
    pytest.mark.skipif(not TOOLS.exists(), reason="there is no build/arm: run make test-clients"),
]


def run(tool: str, *arguments: str | Path, folder: Path) -> str:
    """Return the output of a tool of the compiler, which must not fail."""
    command = [str(TOOLS / "bin" / f"arm-none-eabi-{tool}"), *map(str, arguments)]
    result = subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder)
    assert result.returncode == 0, result.stderr
    return result.stdout


def test_a_sketch_for_a_cortex_m_fits_in_the_ram_of_a_small_board(
    tmp_path: Path, record_property: Callable[[str, object], None]
) -> None:
    for name in ("arduino_board", "arduino_hardware"):
        run(
            "g++", *STRICT, *BOARD, "-fstack-usage", "-isystem", TOOLS / "include" / "newlib", "-I", ARDUINO, "-c",
            "-o", f"{name}.o", PROGRAMS / f"{name}.cpp", folder=tmp_path,
        )  # fmt: skip
    needed = run("nm", "--undefined-only", "arduino_board.o", folder=tmp_path)
    assert not re.search(r"malloc|calloc|free|_Zn[wa]|_Zd[la]|__cxa_throw", needed), needed
    run(
        "gcc", *BOARD, f"-B{NEWLIB}/", f"-L{NEWLIB}", f"--specs={NEWLIB}/nano.specs", f"--specs={NEWLIB}/nosys.specs",
        "-Wl,--gc-sections", "-o", "board.elf", "arduino_board.o", "arduino_hardware.o", folder=tmp_path,
    )  # fmt: skip
    text, data, bss = map(int, run("size", "board.elf", folder=tmp_path).splitlines()[1].split()[:3])
    stack = sum(int(line.split("\t")[1]) for line in (tmp_path / "arduino_board.su").read_text().splitlines())
    for figure, size in (("flash", text + data), ("RAM", data + bss), ("stack of the header, at most", stack)):
        record_property(f"{figure} [bytes]", size)
    assert text > 4000, "the sketch is there"
    assert data + bss > 2000, "the scan is there"
    assert data + bss + stack <= MAX_RAM
