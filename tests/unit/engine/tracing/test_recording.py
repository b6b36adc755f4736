"""Where spans go, as the environment says: nowhere by default, and then nothing of the extra is loaded."""

import json
import subprocess
import sys

import msgspec
import pytest

from engine.tracing.recording import (
    SAMPLER,
    SAMPLER_ARGUMENT,
    TRACES,
    begin_traces,
    check_traces,
    end_traces,
    pass_on,
    sampling_of,
)
from ppaas.errors import InvalidInput
from ppaas.tracing.spans import Sampling, SpanRecord, are_recorded, entry
from tests.support.network.trace_receiver import trace_receiver
from tests.support.waiting import until

LOADS = """
import json, sys
import endpoints.cloud_processes.server, endpoints.cloud_processes.endpoint_process
import engine.agent.agent, engine.container.entry
from engine.tracing.recording import begin_traces, end_traces
begin_traces("ppaas-endpoint", "endpoint-1")
end_traces()
extra = "opentelemetry.sdk", "opentelemetry.exporter", "opentelemetry.proto", "google.protobuf"
print(json.dumps([name for name in sys.modules if name.startswith(extra)]))
"""


def test_no_package_of_the_extra_is_loaded_unless_there_is_a_receiver(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(TRACES, raising=False)
    shown = subprocess.run([sys.executable, "-c", LOADS], capture_output=True, text=True, check=True).stdout
    assert json.loads(shown) == []


@pytest.mark.parametrize(
    ("sampler", "argument", "sampling"),
    [
        ("", "", Sampling(1.0, True)),
        ("always_on", "", Sampling(1.0, False)),
        ("always_off", "", Sampling(0.0, False)),
        ("parentbased_always_off", "", Sampling(0.0, True)),
        ("traceidratio", "0.25", Sampling(0.25, False)),
        ("parentbased_traceidratio", "0.1", Sampling(0.1, True)),
        ("parentbased_traceidratio", "", Sampling(1.0, True)),
        ("parentbased_always_on", "of another sampler", Sampling(1.0, True)),
    ],
)
def test_the_variables_of_opentelemetry_choose_the_traces(sampler: str, argument: str, sampling: Sampling) -> None:
    assert sampling_of({SAMPLER: sampler, SAMPLER_ARGUMENT: argument}) == sampling


@pytest.mark.parametrize(
    ("sampler", "argument", "told"),
    [
        ("jaeger_remote", "", "parentbased_traceidratio"),
        ("parentbased_", "", "parentbased_traceidratio"),
        ("traceidratio", "1.5", "from 0 to 1"),
        ("traceidratio", "half", "half"),
        ("traceidratio", "nan", "from 0 to 1"),
    ],
)
def test_a_sampler_that_does_not_exist_is_refused(
    monkeypatch: pytest.MonkeyPatch, sampler: str, argument: str, told: str
) -> None:
    monkeypatch.setenv(SAMPLER, sampler)
    monkeypatch.setenv(SAMPLER_ARGUMENT, argument)
    with pytest.raises(InvalidInput, match=told):
        check_traces("http://127.0.0.1:4318")


async def test_spans_of_the_process_and_of_its_containers_arrive(monkeypatch: pytest.MonkeyPatch) -> None:
    with trace_receiver() as receiver:
        monkeypatch.setenv(TRACES, receiver.url)
        begin_traces("ppaas-machine", "hall-2")
        with entry("goal", ""):
            pass
        pass_on("c7", [SpanRecord("plan", "internal", "a" * 32, "b" * 16, "", 1.0, 2.0)], 0)
        end_traces()
        await until(lambda: len(receiver.spans) == 2)
    assert {(span.service, span.process, span.name) for span in receiver.spans} == {
        ("ppaas-machine", "hall-2", "goal"),
        ("ppaas-container", "c7", "plan"),
    }
    assert not are_recorded()


def test_spans_of_containers_are_dropped_where_nothing_is_exported() -> None:
    pass_on("c7", [SpanRecord("plan", "internal", "a" * 32, "b" * 16, "", 1.0, 2.0)], 3)
    assert not are_recorded()


SOUND = SpanRecord("plan", "internal", "a" * 32, "b" * 16, "c" * 16, 1.0, 2.0)


@pytest.mark.parametrize(
    "changes",
    [
        {"trace": "a" * 31}, {"trace": "0" * 32}, {"id": "z" * 16}, {"parent": "-1"}, {"began": float("nan")},
        {"began": -1.0}, {"ended": 0.5}, {"ended": float("inf")},
    ],
)  # fmt: skip
async def test_what_is_no_span_is_dropped(monkeypatch: pytest.MonkeyPatch, changes: dict[str, float | str]) -> None:
    with trace_receiver() as receiver:
        monkeypatch.setenv(TRACES, receiver.url)
        begin_traces("ppaas-machine", "hall-2")
        pass_on("c7", [msgspec.structs.replace(SOUND, **changes), SOUND], 0)
        end_traces()
        await until(lambda: len(receiver.spans) == 1)
