"""Reads recordings: bags of ROS and logs, by the names of the files."""

from pathlib import Path

from benchmarks.localization.recording import RecordedFrames, Recording

BAGS = (".bag", ".mcap", ".db3")


def read_recording(path: Path, frames: RecordedFrames | None = None) -> Recording:
    """Read a bag of ROS or a log; ``frames`` names the topic and the frames to read from a bag.

    Raises
    ------
    InvalidInput
        The file cannot be read.
    """
    if path.is_dir() or path.suffix.lower() in BAGS:
        from benchmarks.localization.ros_bags import read_bag  # noqa: PLC0415 - logs need fewer packages

        return read_bag(path, frames or RecordedFrames())
    from benchmarks.localization.carmen_logs import read_log  # noqa: PLC0415

    return read_log(path)
