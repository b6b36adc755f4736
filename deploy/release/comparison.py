"""Differences between two builds: of files, members of archives, and layers of images."""

import hashlib
import json
import tarfile
import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import IO, Any, NamedTuple

SHOWN = 20
"""Differences of one archive that are listed; the others are counted."""


class Member(NamedTuple):
    """A member of an archive."""

    kind: str
    mode: int
    owner: str
    time: float | tuple[int, ...]
    target: str
    content: str


def members(file: Path) -> dict[str, Member]:
    """Return the members of a wheel or of a tar archive, compressed or not, by their names."""
    if zipfile.is_zipfile(file):
        with zipfile.ZipFile(file) as archive:
            return {
                info.filename: Member(
                    "file", info.external_attr >> 16, "", info.date_time, "", _hash(archive.open(info))
                )
                for info in archive.infolist()
            }
    with file.open("rb") as stream:
        return _of_tar(stream)


def _of_tar(stream: IO[bytes]) -> dict[str, Member]:
    found = {}
    with tarfile.open(fileobj=stream, mode="r|*") as archive:
        for info in archive:
            content = archive.extractfile(info) if info.isreg() else None
            owner = f"{info.uid}:{info.gid} {info.uname}:{info.gname}"
            digest = "" if content is None else _hash(content)
            found[info.name] = Member(info.type.decode(), info.mode, owner, info.mtime, info.linkname, digest)
    return found


def _hash(stream: IO[bytes]) -> str:
    with stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()  # type: ignore[arg-type]


def member_differences(one: Mapping[str, Member], other: Mapping[str, Member]) -> list[str]:
    """Return how two archives differ: members that one lacks, and fields of members in both."""
    found = [f"{name}: in the first only" for name in one if name not in other]
    found += [f"{name}: in the second only" for name in other if name not in one]
    for name, member in one.items():
        fields = [
            field
            for field, before, after in zip(Member._fields, member, other.get(name, member), strict=True)
            if before != after
        ]
        if fields:
            found.append(f"{name}: {', '.join(fields)}")
    if not found and list(one) != list(other):
        found.append("the order of the members")
    return found


def folder_differences(one: Path, other: Path) -> Iterator[str]:
    """Yield how the files of two folders differ, with the members of archives."""
    names = sorted({path.name for folder in (one, other) for path in folder.iterdir()})
    for name in names:
        first, second = one / name, other / name
        if not (first.exists() and second.exists()):
            yield f"{name}: in the {'first' if first.exists() else 'second'} folder only"
        elif first.read_bytes() != second.read_bytes():
            yield from _listed(name, member_differences(members(first), members(second)))


def _listed(name: str, found: list[str]) -> Iterator[str]:
    """Yield the differences of an archive, which differs if they are none as well: by its compression."""
    yield f"{name}: {len(found)} members differ" if found else f"{name}: other bytes of the same members"
    yield from (f"  {text}" for text in found[:SHOWN])
    if len(found) > SHOWN:
        yield f"  and {len(found) - SHOWN} others"


# -- images ------------------------------------------------------------------------------------------------------------


class ImageArchive:
    """An image as a tar archive in the layout of the Open Container Initiative.

    Parameters
    ----------
    file : Path
        It has one image, of one platform.
    """

    def __init__(self, file: Path) -> None:
        self._archive = tarfile.open(file)  # noqa: SIM115  # closed by close
        [described] = self._json("index.json")["manifests"]
        self.digest: str = described["digest"]
        manifest = self._blob(self.digest)
        self.layers: list[str] = [layer["digest"] for layer in manifest["layers"]]
        self.config: dict[str, Any] = self._blob(manifest["config"]["digest"])

    def close(self) -> None:
        """Close the file."""
        self._archive.close()

    def __enter__(self) -> "ImageArchive":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def members(self, layer: str) -> dict[str, Member]:
        """Return the members of a layer, named by its digest."""
        return _of_tar(self._open(_path(layer)))

    def made_by(self, layer: str) -> str:
        """Return the instruction of the Dockerfile that made a layer, shortened."""
        making = [step["created_by"] for step in self.config.get("history", ()) if not step.get("empty_layer")]
        known = dict(zip(self.layers, making, strict=False))
        return " ".join(known.get(layer, "?").split())[:100]

    def _blob(self, digest: str) -> Any:
        return self._json(_path(digest))

    def _json(self, path: str) -> Any:
        with self._open(path) as stream:
            return json.load(stream)

    def _open(self, path: str) -> IO[bytes]:
        stream = self._archive.extractfile(path)
        assert stream is not None, "a file, not a folder"
        return stream


def _path(digest: str) -> str:
    return f"blobs/{digest.replace(':', '/')}"


def image_differences(one: Path, other: Path) -> Iterator[str]:
    """Yield how two images differ: by their settings, and the members of each layer that differs."""
    with ImageArchive(one) as first, ImageArchive(other) as second:
        if first.digest == second.digest:
            return
        for key in sorted({*first.config, *second.config} - {"rootfs"}):
            if first.config.get(key) != second.config.get(key):
                yield f"configuration: {key}"
        if len(first.layers) != len(second.layers):
            yield f"{len(first.layers)} and {len(second.layers)} layers"
        for number, (before, after) in enumerate(zip(first.layers, second.layers, strict=False), 1):
            if before != after:
                found = member_differences(first.members(before), second.members(after))
                yield from _listed(f"layer {number}, {first.made_by(before)}", found)
