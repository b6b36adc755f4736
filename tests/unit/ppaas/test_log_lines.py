"""Lines of the log, in which text from outside writes nothing of its own."""

import io
import json
import logging
import os
import re
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.log_lines import AS_JSON, VARIABLE, JsonFormatter, LineFormatter, escaped, log_fields, refusal
from ppaas.tracing.spans import entry, within
from tests.support.recorded_spans import recorded_spans
from tests.support.sources import ROOT

FORGED = "x\n17:00:00 INFO cloud: all is well\x1b[31m\r\x9b2J\u2028\u202e"


def logged(text: str, *arguments: object, error: Exception | None = None) -> str:
    """Return what is written to the log."""
    stream = io.StringIO()
    handler = logging.StreamHandler(stream)
    handler.setFormatter(LineFormatter("%(levelname)s %(name)s: %(message)s"))
    record = logging.LogRecord("name", logging.WARNING, "file", 1, text, arguments, None)
    if error is not None:
        record.exc_info = (type(error), error, error.__traceback__)
    handler.emit(record)
    return stream.getvalue()


def test_text_from_outside_writes_no_lines_and_no_codes() -> None:
    line = logged("unknown frame %s", FORGED)
    assert line == (
        "WARNING name: unknown frame x\\n17:00:00 INFO cloud: all is well\\x1b[31m\\r\\x9b2J\\u2028\\u202e\n"
    )


def test_a_traceback_is_indented_so_that_no_line_of_it_looks_like_a_record() -> None:
    try:
        raise ValueError(FORGED)
    except ValueError as error:
        lines = logged("failed", error=error).splitlines()
    assert lines[0] == "WARNING name: failed"
    assert lines[1] == "  Traceback (most recent call last):"
    assert all(line.startswith("  ") for line in lines[1:])
    assert not re.search(r"[^\x20-\x7e]", "".join(lines))


@given(st.text())
def test_any_text_takes_one_line_that_can_be_printed(text: str) -> None:
    line = logged("%s", text)
    assert line.endswith("\n") and line[:-1].isprintable()
    line.encode()  # also half a surrogate pair


def test_text_that_can_be_printed_is_unchanged() -> None:
    for text in ("", "unknown frame 'base link'", "Größe 1 m²", "目标"):
        assert escaped(text) == text


PROCESSES = [
    "engine/agent/agent.py", "engine/container/entry.py", "engine/recorder/main.py", "engine/remote/agent.py",
    "engine/remote/ray/agent.py", "engine/remote/ray/watcher.py", "endpoints/cloud_processes/server.py",
    "endpoints/cloud_processes/serving.py", "endpoints/robot_checks/check_program.py", "robots/bridges/cli/running.py",
    "robots/bridges/cli/vda5050.py", "robots/cli/commands/demo.py", "robots/cli/commands/simulate.py",
    "robots/onboard/executor/local_executor.py", "robots/mcp/command.py",
]  # fmt: skip


def test_all_processes_write_their_log_so() -> None:
    sources = {
        path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8")
        for room in ("ppaas", "storage", "engine", "endpoints", "robots")
        for path in (ROOT / room).rglob("*.py")
    }
    assert sorted(name for name, text in sources.items() if "log_lines(" in text and name != "ppaas/log_lines.py") == (
        sorted(PROCESSES)
    )
    assert [name for name, text in sources.items() if "basicConfig(" in text] == ["ppaas/log_lines.py"]
    assert [name for name, text in sources.items() if "Formatter(" in text and "logging" in text] == [
        "ppaas/log_lines.py"
    ]


def test_loggers_of_libraries_write_so_too() -> None:
    code = (
        "import logging; from ppaas.log_lines import log_lines; log_lines('%(levelname)s %(message)s');"
        "logging.getLogger('uvicorn.error').warning('from %s', 'a\\n\\x1b[1m')"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stderr == "WARNING from a\\n\\x1b[1m\n"


def test_a_command_prints_no_codes_of_an_error(capsys: pytest.CaptureFixture[str]) -> None:
    from robots.cli.output import printable_lines

    assert printable_lines("a\x1b[31m\nb") == "a\N{REPLACEMENT CHARACTER}[31m\nb"


# -- JSON --------------------------------------------------------------------------------------------------------------


def as_json(text: str, error: Exception | None = None, **extra: object) -> dict[str, str]:
    """Return the record that is written to the log as JSON."""
    record = logging.LogRecord("name", logging.WARNING, "file", 1, text, (), None)
    record.created, record.msecs = 1700000000.25, 250.0
    vars(record).update(extra)
    if error is not None:
        record.exc_info = (type(error), error, error.__traceback__)
    line = JsonFormatter("agent").format(record)
    assert line.isascii() and line.isprintable()
    found: dict[str, str] = json.loads(line)
    return found


def test_a_record_is_one_object_with_its_time_in_utc() -> None:
    assert as_json("all is well") == {
        "time": "2023-11-14T22:13:20.250Z",
        "level": "WARNING",
        "logger": "name",
        "process": "agent",
        "message": "all is well",
    }


@given(st.text())
def test_any_text_is_one_line_of_json(text: str) -> None:
    assert as_json(text.replace("%", ""))["message"] == text.replace("%", "")


def test_a_traceback_is_a_member() -> None:
    try:
        raise ValueError(FORGED)
    except ValueError as error:
        found = as_json("failed", error)
    assert found["exception"].startswith("Traceback") and found["exception"].endswith(FORGED)


def test_fields_are_those_of_the_task_and_of_the_record() -> None:
    with log_fields(robot="ann:tb1", request="r1"):
        with log_fields(request="r2"):
            inner = as_json("x", goal="g7", other="left out")
        outer = as_json("x")
    assert (inner["robot"], inner["request"], inner["goal"]) == ("ann:tb1", "r2", "g7")
    assert "other" not in inner
    assert (outer["request"], "request" in as_json("x")) == ("r1", False)


def test_a_record_names_the_trace_that_it_was_written_for() -> None:
    with within("00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"):
        assert "trace_id" not in as_json("traces are off")
    with recorded_spans() as recorded, entry("request", ""):
        found = as_json("x")
    [span] = recorded
    assert (found["trace_id"], found["span_id"]) == (span.trace, span.id)


@pytest.mark.parametrize(
    ("end", "logger"),
    [
        ("raise ValueError('a\\nb')", "ppaas.log_lines"),
        ("import warnings; warnings.warn('a\\nb')", "py.warnings"),
        ("import logging; logging.getLogger('uvicorn').error('a\\nb')", "uvicorn"),
    ],
)
def test_all_that_a_process_writes_is_json_if_the_environment_asks_for_it(end: str, logger: str) -> None:
    code = f"from ppaas.log_lines import log_lines; log_lines('%(message)s', process='p7')\n{end}"
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=ROOT, capture_output=True, text=True, check=False, env={**os.environ, VARIABLE: AS_JSON},
    )  # fmt: skip
    [found] = [json.loads(line) for line in done.stderr.splitlines()]
    assert (found["process"], found["logger"]) == ("p7", logger)
    assert "a\nb" in found["message"] + found.get("exception", "")


@pytest.mark.parametrize("form", [AS_JSON, "text"])
def test_a_refusal_is_a_line_of_the_same_format(form: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, form)
    line = refusal("conflict", "another cloud leads")
    if form == AS_JSON:
        assert json.loads(line)["message"] == "conflict: another cloud leads"
    else:
        assert line == "ppaas: conflict: another cloud leads\n"
