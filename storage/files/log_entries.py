"""Entries of a map's log: their paths and content, and the record that follows from a publication."""

import zlib
from collections.abc import Iterable

import msgspec

from ppaas import __version__
from ppaas.decoding import from_json
from ppaas.errors import NotFound
from storage.encoding import Written
from storage.records import MapFile, MapRecord, MapReview, MapVersionRecord, Publication
from storage.staged_uploads import StagedUpload
from storage.store_errors import damaged, of_another_release
from storage.versions import ONLY_ZONES, but_zones, check_files, files_after, map_version


class MapLogEntry(msgspec.Struct, frozen=True):
    """One entry of the log: the map's metadata and current version; None for a map that was removed.

    ``removed`` are the numbers of publications whose entries and files are being removed. ``reviews`` are those that
    wait and the last closed ones, oldest first.
    """

    era: int
    owner: str = ""
    readers: tuple[str, ...] = ()
    description: str = ""
    present: MapVersionRecord | None = None
    removed: tuple[int, ...] = ()
    reviews: tuple[MapReview, ...] = ()
    traffic: bool = False

    @classmethod
    def of(
        cls, record: MapRecord, era: int, removed: Iterable[int] = (), reviews: tuple[MapReview, ...] = ()
    ) -> "MapLogEntry":
        """Return the entry for a record."""
        return cls(
            era, record.owner, record.readers, record.description, record.present, tuple(removed), reviews,
            record.traffic,
        )  # fmt: skip

    def record(self, map_id: str) -> MapRecord | None:
        """Return the record of the entry; None if the map was removed."""
        if self.present is None:
            return None
        return MapRecord(map_id, self.owner, self.present, self.readers, self.description, self.traffic)


_WRITTEN_BY = b'"release":' + msgspec.json.encode(__version__) + b","
_CRC = b'{"crc":"'
_CRC_END = len(_CRC) + 8


def encode_entry(entry: MapLogEntry) -> bytes:
    """Return an entry as JSON, after the CRC-32 of the rest and the release; earlier releases ignore these fields."""
    rest = _WRITTEN_BY + msgspec.json.encode(entry)[1:]
    return _CRC + f"{zlib.crc32(rest):08x}".encode() + b'",' + rest


def decode_entry(data: bytes, place: str) -> MapLogEntry:
    """Return the entry; one of an earlier release has no CRC.

    Raises
    ------
    Unavailable
        The data is damaged, or was written by another release that has other entries. Its cause is a ``MsgspecError``
        or a ``UnicodeDecodeError``.
    """
    has_crc = data.startswith(_CRC)
    try:
        if has_crc and f"{zlib.crc32(data[_CRC_END + 2 :]):08x}".encode() != data[len(_CRC) : _CRC_END]:
            raise msgspec.DecodeError("its checksum differs")
        return from_json(data, MapLogEntry)
    except (msgspec.MsgspecError, UnicodeDecodeError) as error:
        if has_crc and isinstance(error, msgspec.ValidationError):
            raise of_another_release(place, from_json(data, Written).release, error) from error
        raise damaged(place, error) from error


class LatestEntry(msgspec.Struct, frozen=True):
    """The last entry of a log: its number, the number of the map's first entry (``era``), and the record.

    ``removed`` are the publications whose removal is not finished.
    """

    number: int
    era: int
    record: MapRecord | None
    removed: frozenset[int] = frozenset()
    reviews: tuple[MapReview, ...] = ()

    def head(self, map_id: str) -> MapRecord:
        """Return the record; ``NotFound`` if the map does not exist."""
        if self.record is None:
            raise NotFound("map", map_id)
        return self.record


def entry_path(map_id: str, number: int) -> str:
    """Return the path of an entry on the disk."""
    return f"{map_id}/log/{number:08d}"


def files_path(map_id: str, era: int) -> str:
    """Return the path of the folder with the files of all versions of a map."""
    return f"{map_id}/files-{era}"


def published(latest: LatestEntry, publication: Publication, upload: StagedUpload) -> MapRecord:
    """Return the record after a publication; files that are current already add no version, but keep its message."""
    before, files = latest.record, files_of(latest, publication.map, upload)
    version = map_version(files)
    if before is not None and before.version == version:
        message = publication.message or before.present.message
        return _with_present(before, publication, msgspec.structs.replace(before.present, message=message))
    return _with_present(before, publication, _version(latest, publication, version, files))


def files_of(latest: LatestEntry, map_id: str, upload: StagedUpload) -> dict[str, MapFile]:
    """Return the files of the version that an upload makes after the last entry.

    Raises
    ------
    NotFound
        The upload changes a map that does not exist.
    InvalidInput
        The files are not a map's.
    """
    before = latest.head(map_id) if upload.keeps - ONLY_ZONES else latest.record
    files = upload.files_after({} if before is None else before.present.files)
    check_files(files)
    return files


def followed(latest: LatestEntry, after: MapRecord) -> tuple[MapReview, ...]:
    """Return the reviews of a map once it has another version: those that keep its zones have the zones of that one.

    If the versions differ in nothing else, such a review is made from the new one.
    """
    if latest.record is None or latest.record.version == after.version:
        return latest.reviews
    old, new = latest.record.present.files, after.present.files
    only_zones = but_zones(old) == but_zones(new)

    def follow(review: MapReview) -> MapReview:
        files = files_after(but_zones(review.files), ONLY_ZONES, new)
        base = after.version if only_zones and review.base == latest.head(after.id).version else review.base
        return msgspec.structs.replace(review, files=files, version=map_version(files), base=base)

    return tuple(follow(one) if one.waits and one.keeps_zones else one for one in latest.reviews)


def rolled_back(latest: LatestEntry, publication: Publication, found: MapVersionRecord) -> MapRecord:
    """Return the record after a rollback to the version ``found``."""
    present = _version(latest, publication, found.version, found.files, restored=True)
    return _with_present(latest.record, publication, present)


def changed(
    record: MapRecord, readers: tuple[str, ...] | None, description: str | None, traffic: bool | None = None
) -> MapRecord:
    """Return the record with other metadata; None leaves a field unchanged."""
    return msgspec.structs.replace(
        record,
        readers=record.readers if readers is None else readers,
        description=record.description if description is None else description,
        traffic=record.traffic if traffic is None else traffic,
    )


def _version(
    latest: LatestEntry, publication: Publication, version: str, files: dict[str, MapFile], *, restored: bool = False
) -> MapVersionRecord:
    return MapVersionRecord(
        latest.number + 1, version, publication.created, publication.author, publication.message, restored, files
    )


def _with_present(before: MapRecord | None, publication: Publication, present: MapVersionRecord) -> MapRecord:
    record = MapRecord(publication.map, publication.owner or publication.author, present) if before is None else before
    return changed(msgspec.structs.replace(record, present=present), publication.readers, publication.description)
