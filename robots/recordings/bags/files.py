"""Files of a bag: one file, or all files of a folder in the order in which they were recorded."""

import re
from pathlib import Path, PureWindowsPath
from typing import Any, NamedTuple

from ppaas.errors import InvalidInput
from robots.recordings.bags.uncompressed import SUFFIXES, unreadable

METADATA = "metadata.yaml"

_NAME = re.compile(rf"(?P<stem>.+)\.(?P<kind>bag|mcap|db3)(?:\.active)?(?:\.(?:{'|'.join(SUFFIXES)}))?", re.IGNORECASE)
_SPLIT = re.compile(r"(?:[-_]\d{4}-\d\d-\d\d-\d\d-\d\d-\d\d)?(?:_\d+)?$")
"""End of the name of a split file: its time, which ``rosbag record`` writes, and its number."""


class BagFiles(NamedTuple):
    """Files of a bag.

    Parameters
    ----------
    paths : tuple of Path
        In the order of recording; at least one.
    notes : tuple of str
        What is missing.
    """

    paths: tuple[Path, ...]
    notes: tuple[str, ...] = ()


def has_bag_name(path: Path) -> bool:
    """Return whether the name of a file is a bag's, compressed or not."""
    return _NAME.fullmatch(path.name) is not None


def files_of(path: Path) -> BagFiles:
    """Return the files of a bag.

    In a folder, those are the files that its ``metadata.yaml`` lists, and later ones of the same recording; without it,
    as a recorder that was killed leaves a folder, or if all files were renamed, all files of one recording.

    Raises
    ------
    InvalidInput
        There is no such file, or the folder has no bag, or several.
    """
    try:
        if not path.is_dir():
            path.stat()
            return BagFiles((path,))
        found = sorted(
            (file for file in path.iterdir() if has_bag_name(file) and not file.name.startswith(".")), key=_order
        )
        listed = _listed(path / METADATA)
    except OSError as error:
        raise unreadable(path, error) from error
    if not listed:
        return BagFiles(_of_one_recording(found, path))
    present = {name: file for name in listed if (file := _present(path / name)) is not None}
    missing = [name for name in listed if name not in present]
    known = {_recording(file) for file in present.values()}
    later = [file for file in found if file not in present.values() and _recording(file) in known]
    if not present and not found:
        raise InvalidInput(f"cannot read the bag {path}: {METADATA} lists {listed[0]}, which is not there")
    if not present:
        return BagFiles(_of_one_recording(found, path), (f"{METADATA} of {path} lists other files: it is not used",))
    notes = (
        f"{METADATA} of {path} lists {', '.join(missing)}, which {'is' if len(missing) == 1 else 'are'} not there",
    )
    return BagFiles((*present.values(), *later), notes if missing else ())


def _listed(metadata: Path) -> list[str]:
    """Return the names of the files that a ``metadata.yaml`` lists; none if it is not there, or was not finished.

    Raises
    ------
    InvalidInput
        Its messages are compressed in a way that is not known.
    """
    import yaml  # noqa: PLC0415 - of the extra plan

    if not metadata.is_file():
        return []
    try:
        content = yaml.safe_load(metadata.read_text("utf-8"))
        about: dict[str, Any] = content["rosbag2_bagfile_information"]
        names = [PureWindowsPath(name).name for name in about["relative_file_paths"]]
        by, what = about.get("compression_format") or "zstd", about.get("compression_mode") or ""
    except (yaml.YAMLError, UnicodeDecodeError, LookupError, TypeError, AttributeError):
        return []
    if by != "zstd" and what.lower() == "message":
        raise InvalidInput(
            f"the messages of {metadata.parent} are compressed by {by}, and only zstd is known: run ros2 bag convert"
        )
    return names


def _present(path: Path) -> Path | None:
    """Return a file, or itself compressed or decompressed since it was recorded; None if there is none of these."""
    bare = path.with_suffix("") if path.suffix.lstrip(".") in SUFFIXES else path
    names = (path, bare, *(bare.with_name(f"{bare.name}.{suffix}") for suffix in SUFFIXES))
    return next((name for name in names if name.is_file()), None)


def _of_one_recording(found: list[Path], folder: Path) -> tuple[Path, ...]:
    recordings = {_recording(file): file.name for file in found}
    if not found:
        raise InvalidInput(f"the folder {folder} has no bag: no file in it ends with .mcap, .db3 or .bag")
    if len(recordings) > 1:
        names = ", ".join(sorted(recordings.values())[:5])
        raise InvalidInput(
            f"the folder {folder} has several bags ({names}) and no {METADATA} of them: name one of the files"
        )
    return tuple(found)


def _recording(file: Path) -> tuple[str, str]:
    """Return what the names of the files of one recording have in common, and their kind."""
    match = _NAME.fullmatch(file.name)
    assert match is not None
    return _SPLIT.sub("", match["stem"]), match["kind"].lower()


def _order(file: Path) -> list[tuple[int, str]]:
    """Return a key by which numbers in names are ordered by value: 2 before 10."""
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in re.split(r"(\d+)", file.name) if part]
