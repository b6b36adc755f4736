"""The client for MicroPython raises nothing but ``Refused``, whatever a cloud sends."""

import asyncio
import shutil
from collections.abc import Iterator

import pytest
from hypothesis import HealthCheck, example, given, settings

from tests.support.cloud.board_robot import HEAP, PROGRAMS, compile_for_board, micropython
from tests.support.cloud.hostile_cloud import HEADS, MESSAGES, PIECE, STREAM, FedBoard, frame
from tests.support.fuzzing import EXAMPLES

pytestmark = pytest.mark.skipif(
    micropython() is None, reason="MicroPython is not installed: it has wheels for Linux only"
)


@pytest.fixture(scope="module")
def board(tmp_path_factory: pytest.TempPathFactory) -> Iterator[FedBoard]:
    folder = tmp_path_factory.mktemp("fuzz")
    asyncio.run(compile_for_board(folder))
    shutil.copy(PROGRAMS / "micropython_fuzz.py", folder / "fuzz.py")
    with FedBoard([str(micropython()), "-X", f"heapsize={HEAP}", "fuzz.py"], str(folder), answer=0) as fed:
        yield fed


@settings(max_examples=EXAMPLES, suppress_health_check=list(HealthCheck))
@given(stream=STREAM, piece=PIECE)
@example(stream=HEADS[0] + frame(0x88, b"\x03\xf3\xff\xfe"), piece=4096)
@example(stream=HEADS[0] + b"".join(frame(0x81, text) for text in MESSAGES), piece=4096)
@example(stream=b"SSH-2.0-x\r\n", piece=4096)
def test_the_client_for_micropython_reads_or_drops_what_a_hostile_cloud_sends(
    board: FedBoard, stream: bytes, piece: int
) -> None:
    assert board.feed(stream, piece) == ""
