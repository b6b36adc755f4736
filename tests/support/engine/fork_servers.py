"""End of the fork server of the standard library in a process that runs tests."""

from multiprocessing import forkserver


def stop_fork_server() -> None:
    """Stop the fork server of this process, if it runs, so that the next one starts with other modules or variables."""
    forkserver._forkserver._stop()  # type: ignore[attr-defined]
