"""Reads recordings: bags of ROS and logs, by the names of the files."""

from pathlib import Path

from robots.recordings.files import has_bag_name
from robots.recordings.recording import RecordedFrames, Recording


def is_bag(path: Path) -> bool:
    """Return whether a path is a ROS bag: a folder, or a file by its name or its first bytes."""
    from robots.recordings.bag import is_bag_file  # noqa: PLC0415 - logs need fewer packages

    return path.is_dir() or has_bag_name(path) or is_bag_file(path)


def read_recording(path: Path, frames: RecordedFrames | None = None) -> Recording:
    """Read a bag of ROS or a log; ``frames`` names the topic and the frames to read from a bag.

    Raises
    ------
    InvalidInput
        The file cannot be read.
    """
    if is_bag(path):
        from robots.recordings.ros_bags import read_bag  # noqa: PLC0415 - logs need fewer packages

        return read_bag(path, frames or RecordedFrames())
    from robots.recordings.text_logs import read_log  # noqa: PLC0415

    return read_log(path, None if frames is None else frames.scan_topic)
