"""Recordings by what their files are called."""

from pathlib import Path

from robots.bench.localize.recording import Recording

BAGS = (".bag", ".mcap", ".db3")


def read_recording(path: Path) -> Recording:
    """Read a bag of ROS or a log.

    Raises
    ------
    InvalidInput
        It cannot be read.
    """
    if path.is_dir() or path.suffix.lower() in BAGS:
        from robots.bench.localize.bags import read_bag  # noqa: PLC0415 - logs want less

        return read_bag(path)
    from robots.bench.localize.logs import read_log  # noqa: PLC0415

    return read_log(path)
