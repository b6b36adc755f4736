"""Progress of a request, on a terminal."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

Report = Callable[[str, float], None]
"""Shows what is done now, and how much of all is done, from 0 to 1."""


@contextmanager
def progress_bar(name: str) -> Iterator[Report | None]:
    """Show the progress of a request until the end of the block; yield None without a terminal."""
    from rich.console import Console  # noqa: PLC0415 - a robot's install lacks rich
    from rich.progress import Progress  # noqa: PLC0415

    console = Console(stderr=True)
    if not console.is_terminal:
        yield None
        return
    with Progress(console=console, transient=True) as progress:
        task = progress.add_task(name, total=1.0)
        yield lambda text, done: progress.update(task, description=f"{name}: {text}", completed=done)
