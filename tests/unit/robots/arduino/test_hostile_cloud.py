"""The client for Arduino reads what a hostile cloud sends within its own memory."""

import shutil
import subprocess
from collections.abc import Iterator

import pytest
from hypothesis import HealthCheck, example, given, settings

from tests.support.cloud.board_robot import ARDUINO, PROGRAMS, STRICT
from tests.support.cloud.hostile_cloud import HEADS, PIECE, STREAM, FedBoard, frame
from tests.support.fuzzing import EXAMPLES

pytestmark = pytest.mark.skipif(shutil.which("g++") is None, reason="g++ is not installed")

SANITIZED = ("-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")


@pytest.fixture(scope="module")
def board(tmp_path_factory: pytest.TempPathFactory) -> Iterator[FedBoard]:
    made = tmp_path_factory.mktemp("fuzz") / "fuzz"
    source = PROGRAMS / "arduino_fuzz.cpp"
    command = ["g++", *STRICT, *SANITIZED, "-I", str(ARDUINO), "-o", str(made), str(source)]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    with FedBoard([str(made)], str(made.parent), answer=1) as fed:
        yield fed


@settings(max_examples=EXAMPLES, suppress_health_check=list(HealthCheck))
@given(stream=STREAM, piece=PIECE)
@example(stream=HEADS[0] + frame(0x88, b"\x03\xf3" + b"r" * 600), piece=4096)
def test_the_client_for_arduino_reads_or_drops_what_a_hostile_cloud_sends(
    board: FedBoard, stream: bytes, piece: int
) -> None:
    assert board.feed(stream, piece) in "ABCDE"
