"""Commands, names and numbers in traces.md are those of the code."""

import json
import re
import subprocess
import sys

import pytest

from engine.container.spans import MOST as MOST_IN_A_CONTAINER
from engine.tracing import export
from engine.tracing.recording import CONTAINER, MACHINE, RATIOS, TRACES, sampling_of
from ppaas.tracing.context import context_of
from ppaas.tracing.spans import LONGEST, Sampling
from ppaas.wire.operations import CallService, Publish, SendActionGoal
from ppaas.wire.rosbridge import decode_operation
from tests.support.documents import blocks, table, text_of

PAGE = "docs/traces.md"


@pytest.mark.parametrize("command", [("up",), ("machine", "join")])
def test_the_commands_have_the_option(command: tuple[str, ...]) -> None:
    called = [sys.executable, "-m", "robots.cli", *command, "--help"]
    assert "--traces URL" in subprocess.run(called, capture_output=True, text=True, check=True).stdout


def test_the_variables_of_the_example_choose_the_traces() -> None:
    [line] = [line for block in blocks(PAGE, "sh") for line in block.splitlines() if line.startswith("OTEL_")]
    variables = dict(re.findall(r"(OTEL_\w+)=(\S+)", line))
    assert sampling_of(variables) == Sampling(0.05, True)
    assert all(f"`{name}`" in text_of(PAGE) for name in RATIOS)


def test_the_goal_of_the_example_has_a_trace() -> None:
    [frame] = blocks(PAGE, "json")
    goal = decode_operation(json.dumps(json.loads(frame)))
    assert isinstance(goal, SendActionGoal)
    assert context_of(goal.traceparent or "") is not None
    with_trace = [kind for kind in (Publish, CallService, SendActionGoal) if "traceparent" in kind.__struct_fields__]
    assert all(f"`{kind.__struct_config__.tag}`" in text_of(PAGE) for kind in with_trace) and len(with_trace) == 3


def test_services_and_numbers_are_those_of_the_code() -> None:
    page = " ".join(text_of(PAGE).split())
    cells = " ".join(cell for _, cell, _ in table(PAGE, "span", "service", "what"))
    services = set(re.findall(r"ppaas-\w+", cells))
    assert services == {"ppaas-endpoint", "ppaas-master", MACHINE, CONTAINER}
    assert f"At most {export.MOST} spans wait in a process and {MOST_IN_A_CONTAINER} in a container" in page
    assert f"does not take within {export.TIMEOUT:g} s" in page
    assert f"cut after {LONGEST} characters" in page
    assert TRACES == "PPAAS_TRACES"
