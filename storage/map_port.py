"""Port of map stores: the interface of all of them, by the rules of ``storage.ports``, and the maps that they open."""

from collections.abc import Collection
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from ppaas.errors import InvalidMap, NotFound
from ppaas.zones.reading import zones_of
from ppaas.zones.zone import NO_ZONES, ZoneSet
from storage.records import MapRecord, MapReview, MapVersionRecord, ProposedChange, Publication
from storage.staged_uploads import Buffer, StagedUpload
from storage.versions import IMAGE, PARTS, YAML, ZONES


@dataclass(frozen=True, slots=True)
class OpenMap:
    """A version of a map with its files, valid inside the ``with`` block of ``MapStore.open_map``.

    Parameters
    ----------
    record : MapRecord
        The map, with this version.
    paths, buffers : dict
        Path of each file on this machine, and its content; the keys are from ``storage.versions.PARTS``.
    """

    record: MapRecord
    paths: dict[str, Path] = field(default_factory=dict)
    buffers: dict[str, Buffer] = field(default_factory=dict)

    def buffer(self, part: str) -> Buffer:
        """Return the content of a file; ``NotFound`` if the map has no such file."""
        if part not in self.buffers:
            raise NotFound(f"file of map {self.record.id!r}:", part, sorted(self.buffers))
        return self.buffers[part]

    def grid(self) -> tuple[bytes, Buffer]:
        """Return the YAML and the image of a map; ``InvalidMap`` if it has no grid."""
        if YAML not in self.buffers:
            raise no_grid(self.record)
        return bytes(self.buffers[YAML]), self.buffers[IMAGE]

    def zones(self) -> ZoneSet:
        """Return the zones of a map; none if it has no file of them."""
        return zones_of(bytes(self.buffers[ZONES])) if ZONES in self.buffers else NO_ZONES


def no_grid(record: MapRecord) -> InvalidMap:
    """Return the error for a map that has an octomap only."""
    return InvalidMap(f"map {record.id!r} has an octomap and no grid: publish a YAML with its image as well")


class MapStore(Protocol):
    """Maps and their versions. Files may be large: they are written to staged uploads and read from opened maps."""

    def stage(self) -> AbstractContextManager[StagedUpload]:
        """Open an upload for the files of a version; unless published, they are removed at the end of the block."""
        ...

    def publish(self, upload: StagedUpload, publication: Publication) -> MapRecord:
        """Make the uploaded files the current version of a map, atomically; return its head.

        Metadata that the publication leaves at None is unchanged. Publishing the files of the current version again
        adds no version, so a publication may be retried; a message replaces the version's.

        Raises
        ------
        Conflict
            The map belongs to another user (of two users who publish under a new id at the same time, one gets it), or
            its current version is not ``if_match``.
        InvalidInput
            A name is not valid, or the files are not a map's.
        """
        ...

    def roll_back(self, version: str, publication: Publication) -> MapRecord:
        """Make an earlier version of a map current again; return its head.

        Raises
        ------
        NotFound
            The map does not exist, or never had that version.
        Conflict
            For the reasons of ``publish``.
        """
        ...

    def propose(
        self, upload: StagedUpload, publication: Publication, *, base: str, change: ProposedChange
    ) -> MapReview:
        """Store the uploaded files as a version that waits for a review; the current version stays.

        Proposing files again that wait already adds nothing, so a proposal may be retried.

        Parameters
        ----------
        upload : StagedUpload
            The files.
        publication : Publication
            Author, time and reason; readers and description are not used.
        base : str
            Version that the files were made from.
        change : ProposedChange
            Difference from it.

        Raises
        ------
        NotFound
            The map does not exist.
        Conflict
            For the reasons of ``publish``, or the files are the current version's.
        QuotaExceeded
            Too many versions of the map wait already, or they are too large.
        """
        ...

    def reviews(self, map_id: str) -> list[MapReview]:
        """Return the reviews of a map, newest first: all that wait, and the last that were closed.

        Raises
        ------
        NotFound
            The map does not exist.
        """
        ...

    def approve(self, number: int, publication: Publication, *, force: bool = False) -> MapRecord:
        """Make a version that waits the current one, atomically; return the map's head.

        The version is listed with the author and the message of its proposal; the publication says who approves it,
        when and why (``message``). An approval may be retried.

        Raises
        ------
        NotFound
            The map does not exist, or has no review of that number.
        Conflict
            For the reasons of ``publish``; the review was refused; or, without ``force``, the current version is
            another than the one that the proposal was made from.
        """
        ...

    def refuse(self, number: int, publication: Publication) -> MapReview:
        """Close a review without publishing, and remove the files that no version has; return it.

        The publication says who refuses it, when and why (``message``). A refusal may be retried.

        Raises
        ------
        NotFound
            The map does not exist, or has no review of that number.
        Conflict
            For the reasons of ``publish``, or the review was approved.
        """
        ...

    def open_map(
        self, map_id: str, version: str | None = None, *, only: Collection[str] = PARTS
    ) -> AbstractContextManager[OpenMap]:
        """Open a version of a map for reading: the current one by default, and all files or ``only`` some.

        A version that waits for its review can be opened too.

        Raises
        ------
        NotFound
            The map does not exist, or never had that version.
        Unavailable
            A file is damaged.
        """
        ...

    def map_head(self, map_id: str) -> MapRecord:
        """Return a map in its current version; ``NotFound`` if it does not exist."""
        ...

    def maps(self, visible_to: str | None = None, *, after: str = "", limit: int | None = None) -> list[MapRecord]:
        """Return the maps that a user may read, or all, sorted by id, in their current versions."""
        ...

    def versions(self, map_id: str, *, before: int | None = None, limit: int | None = None) -> list[MapVersionRecord]:
        """Return the publications of a map, newest first; ``NotFound`` if the map does not exist.

        The key is the number of a publication. A version that was restored is listed twice: as published and as
        restored.
        """
        ...

    def remove_versions(self, map_id: str, versions: Collection[str]) -> None:
        """Remove versions of a map, with the files that no other version has; their publications leave the list.

        Raises
        ------
        NotFound
            The map does not exist, or never had one of the versions.
        Conflict
            One of them is the current version.
        """
        ...

    def change_map(
        self,
        map_id: str,
        *,
        readers: tuple[str, ...] | None = None,
        description: str | None = None,
        traffic: bool | None = None,
    ) -> MapRecord:
        """Change the metadata of a map; return its head. ``NotFound`` if the map does not exist."""
        ...

    def remove_map(self, map_id: str) -> None:
        """Remove a map and its versions; ``NotFound`` if it does not exist."""
        ...
