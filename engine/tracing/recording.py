"""Recording of the spans of a process for OpenTelemetry, if its environment has the URL of a receiver.

The environment is inherited, so all processes of a cloud agree. Without the URL, no package of the extra is loaded.
"""

import os
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING

from ppaas.distribution import check_versions, install_hint
from ppaas.errors import InvalidInput
from ppaas.tracing.context import context_of
from ppaas.tracing.spans import Sampling, SpanRecord, record_spans

if TYPE_CHECKING:
    from engine.tracing.export import SpanExport

TRACES = "PPAAS_TRACES"
"""Variable with the URL of the receiver."""

SAMPLER, SAMPLER_ARGUMENT = "OTEL_TRACES_SAMPLER", "OTEL_TRACES_SAMPLER_ARG"
"""Variables of OpenTelemetry that say which traces are recorded."""

FOLLOWS_PARENT = "parentbased_"
RATIO = "traceidratio"
RATIOS: Mapping[str, float | None] = {"always_on": 1.0, "always_off": 0.0, RATIO: None}
"""Samplers with their ratio; None if the argument has it."""

MACHINE, CONTAINER = "ppaas-machine", "ppaas-container"
"""Names of the services of agents and of containers."""

LATEST = 2.0**33
"""Time after which no span ends [s since the epoch], in the year 2242: receivers count nanoseconds by 64 bits."""

_export: "SpanExport | None" = None


def sampling_of(environment: Mapping[str, str]) -> Sampling:
    """Return which traces are recorded, as the variables of OpenTelemetry say; by default all that clients want.

    Raises
    ------
    InvalidInput
        There is no such sampler, or its argument is not from 0 to 1.
    """
    name = environment.get(SAMPLER, "").strip() or f"{FOLLOWS_PARENT}always_on"
    own = name.removeprefix(FOLLOWS_PARENT)
    if own not in RATIOS:
        known = ", ".join([*RATIOS, *(f"{FOLLOWS_PARENT}{each}" for each in RATIOS)])
        raise InvalidInput(f"{SAMPLER} must be one of {known}, not {name!r}")
    ratio = RATIOS[own]
    return Sampling(_argument(environment) if ratio is None else ratio, name != own)


def _argument(environment: Mapping[str, str]) -> float:
    text = environment.get(SAMPLER_ARGUMENT, "").strip() or "1"
    try:
        ratio = float(text)
    except ValueError:
        ratio = -1.0
    if not 0.0 <= ratio <= 1.0:
        raise InvalidInput(f"{SAMPLER_ARGUMENT} must be from 0 to 1, not {text!r}")
    return ratio


def check_traces(url: str) -> None:
    """Check that spans can be exported.

    Raises
    ------
    InvalidInput
        The extra is not installed, or a variable of OpenTelemetry is wrong.
    """
    if find_spec("opentelemetry") is None or find_spec("opentelemetry.exporter") is None:
        raise InvalidInput(f"--traces {url} needs the extra otel: {install_hint('cloud', 'otel')}")
    check_versions("otel")
    sampling_of(os.environ)


def begin_traces(service: str, process: str) -> None:
    """Record the spans of this process from now on, if its environment has the URL of a receiver.

    Parameters
    ----------
    service : str
        Kind of the process, by which receivers group spans.
    process : str
        Name of the process, as its log has it.
    """
    global _export  # noqa: PLW0603 - there is one for each process
    url = os.environ.get(TRACES, "")
    if not url:
        return
    check_traces(url)
    from engine.tracing.export import SpanExport  # noqa: PLC0415 - imports packages of an extra

    export = _export = SpanExport(url)
    record_spans(lambda span: export.add(span, service, process), sampling_of(os.environ))


def pass_on(container: str, spans: Sequence[SpanRecord], dropped: int) -> None:
    """Export spans of a container of this machine, and count those that it has dropped; without traces, do nothing.

    What is no span is dropped, too: a container may run plug-ins of others.
    """
    if _export is None:
        return
    for span in spans:
        if _is_sound(span):
            _export.add(span, CONTAINER, container)
        else:
            dropped += 1
    _export.drop(dropped)


def _is_sound(span: SpanRecord) -> bool:
    ids = [span.id, *([span.parent] if span.parent else [])]
    times = 0.0 <= span.began <= span.ended < LATEST
    return times and all(context_of(f"00-{span.trace}-{each}-01") for each in ids)


def end_traces() -> None:
    """Export the spans that wait, for a short time, and record no more."""
    global _export  # noqa: PLW0603 - see above
    record_spans(None)
    if _export is not None:
        _export.close()
    _export = None
