"""Part ``push``: a changed map sent to the robots that drive on it, by a cloud that the bench starts."""

import msgspec
import uvloop
from rich.console import Console
from rich.progress import Progress

from benchmarks.harness.parts import PartResult
from benchmarks.mapping.parts.part import SlamOptions
from benchmarks.service import map_push, suite
from robots.cli import event_loop


def measure(_options: SlamOptions) -> PartResult:
    """Measure the part ``push`` of ``ppaas bench service``."""
    with Progress(console=Console(stderr=True, quiet=True), disable=True) as progress:
        options = suite.ServiceOptions((map_push.PART,))
        figures = event_loop.run(suite.measure(options, progress), uvloop.new_event_loop)
    return PartResult(figures, [], msgspec.to_builtins(figures))
