"""Files of recordings: read as they were before they were compressed, and all of a folder in recorded order."""

import bz2
import gzip
import io
import lzma
import re
import zlib
from collections.abc import Callable
from pathlib import Path, PureWindowsPath
from typing import IO, Any, NamedTuple

from ppaas.distribution import install_hint
from ppaas.errors import InvalidInput

SUFFIXES = ("zst", "zstd", "gz", "bz2", "xz", "lz4")
"""Endings of compressed files; their first bytes count, whatever the name is."""


class UncompressedFile(io.RawIOBase):
    """Binary stream of a file, decompressed by what its first bytes are. It is read forwards only.

    Parameters
    ----------
    path : Path

    Attributes
    ----------
    compressed : bool
        Whether the file is compressed.
    cut : bool
        Whether the compressed file was found to end early, or to be damaged, as far as read.

    Raises
    ------
    InvalidInput
        The file cannot be read.
    """

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.cut = False
        self._path = path
        try:
            self._file = path.open("rb")
            head = self._file.peek(6)
        except OSError as error:
            raise unreadable(path, error) from error
        opened = next((opened for magic, opened in _OPENERS.items() if head.startswith(magic)), None)
        self.compressed = opened is not None
        self._stream: Any = self._file if opened is None else opened(self._file)

    def readable(self) -> bool:
        """Return true."""
        return True

    def readinto(self, buffer: Any) -> int:
        """Read bytes, none where the file ends or its compressed content is damaged; raises as the constructor."""
        data = self._read(len(buffer))
        buffer[: len(data)] = data
        return len(data)

    def close(self) -> None:
        """Close the file."""
        super().close()
        self._file.close()

    def _read(self, size: int) -> bytes:
        if self.cut:
            return b""
        try:
            return bytes(self._stream.read1(size))
        except OSError as error:
            if error.errno is not None:
                raise unreadable(self._path, error) from error
        except (EOFError, RuntimeError, zlib.error, lzma.LZMAError):
            pass
        except Exception as error:
            if type(error).__name__ != "ZstdError":  # of a package that may not be installed
                raise
        self.cut = True
        return b""


def unreadable(path: Path, error: OSError) -> InvalidInput:
    """Return the error for a file that the system does not let us read."""
    return InvalidInput(f"cannot read {path}: {(error.strerror or str(error)).lower()}")


def _zstd(file: IO[bytes]) -> Any:
    try:
        import zstandard  # noqa: PLC0415 - of the extras bags and recording
    except ModuleNotFoundError as error:
        raise InvalidInput(f"files compressed by zstd need the extra bags: {install_hint('bags')}") from error
    return zstandard.ZstdDecompressor(max_window_size=1 << 27).stream_reader(file, read_across_frames=True)


def _lz4(file: IO[bytes]) -> Any:
    try:
        import lz4.frame  # noqa: PLC0415 - likewise
    except ModuleNotFoundError as error:
        raise InvalidInput(f"files compressed by lz4 need the extra bags: {install_hint('bags')}") from error
    return lz4.frame.LZ4FrameFile(file)


_OPENERS: dict[bytes, Callable[[IO[bytes]], Any]] = {
    b"\x28\xb5\x2f\xfd": _zstd,
    b"\x1f\x8b": lambda file: gzip.GzipFile(fileobj=file),
    b"BZh": bz2.BZ2File,
    b"\xfd7zXZ\x00": lzma.LZMAFile,
    b"\x04\x22\x4d\x18": _lz4,
}
"""First bytes of compressed files, and what decompresses them."""


# -- files of a bag ----------------------------------------------------------------------------------------------------

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
