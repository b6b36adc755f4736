"""Map programs: results, errors and limits."""

import subprocess
import sys
from typing import Any

import pytest

from endpoints.rest.maps import map_programs
from endpoints.rest.maps.map_programs import outcome_of, run_program
from ppaas.errors import Conflict, PPaaSError, QuotaExceeded, Unavailable

LARGE = QuotaExceeded("too large: map with fewer beams")


def raising(error: BaseException) -> Any:
    raise error


@pytest.fixture
def program(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return a function that runs Python text as a program."""
    execute = subprocess.run

    def run(text: str, seconds: float = 30.0) -> Any:
        def instead(_command: list[str], **options: Any) -> Any:
            return execute([sys.executable, "-c", text], **options)

        monkeypatch.setattr("endpoints.rest.maps.map_programs.subprocess.run", instead)
        return run_program("program", [], "the map could not be made", seconds)

    return run


def test_the_outcome_is_the_result_or_the_error() -> None:
    assert outcome_of(lambda: [1.0], LARGE) == {"result": [1.0]}
    assert outcome_of(lambda: raising(Conflict("no")), LARGE) == {"fault": ["conflict", "no"]}
    assert outcome_of(lambda: raising(MemoryError()), LARGE) == {"fault": ["quota-exceeded", str(LARGE)]}


def test_a_result_is_returned_and_an_error_raised(program: Any) -> None:
    assert program("print('{\"result\": [1]}')") == [1]
    with pytest.raises(Conflict, match=r"^no$"):
        program('print(\'{"fault": ["conflict", "no"]}\')')


def test_a_program_that_crashes_is_unavailable_and_its_output_logged(
    program: Any, caplog: pytest.LogCaptureFixture
) -> None:
    with pytest.raises(Unavailable, match=r"could not be made \(exit status 1\)"):
        program("raise OSError('broken')")
    assert "broken" in caplog.text


def test_a_program_out_of_time_is_ended(program: Any) -> None:
    with pytest.raises(Unavailable, match=r"could not be made within 0\.2 s"):
        program("import time; time.sleep(60)", 0.2)


def test_a_program_is_limited(program: Any) -> None:
    text = (
        "import resource, os; from endpoints.rest.maps.map_programs import be_program; from ppaas.errors import "
        "QuotaExceeded; nice = os.nice(0); be_program(lambda: [resource.getrlimit(resource.RLIMIT_AS)[0], os.nice(0) - "
        "nice], QuotaExceeded(''))"
    )
    assert program(text) == [map_programs.MEMORY, map_programs.NICE]
    with pytest.raises(PPaaSError, match=r"^large$"):
        program(text.replace("[resource", "[bytes(1 << 40), resource").replace("('')", "('large')"))
