"""Files of a data folder in a backup: recordings, and the keys by which machines know the cloud."""

import hashlib
import os
from collections.abc import Callable, Iterator
from pathlib import Path, PurePosixPath

from storage.backup.manifest import BackupManifest, StoredFile
from storage.backup.repository import Repository
from storage.migration.copying import MAX_NAMED, Compared, Copied
from storage.store_errors import damaged, disk_errors

KIND = "files"
"""Name of the kind, for reports."""

CHUNK = 4 << 20
"""Bytes of a file in a block."""

PRIVATE, PRIVATE_FOLDER = 0o600, 0o700


class FileWriter:
    """Writes files as blocks.

    Parameters
    ----------
    folder : Path
        Data folder.
    earlier : BackupManifest, optional
        The backup before: files that have changed since are read, others are not.
    put : callable
        Stores a block, and returns its name.
    """

    def __init__(self, folder: Path, earlier: BackupManifest | None, put: Callable[[bytes], str]) -> None:
        self._folder = folder
        self._earlier = {} if earlier is None else {file.name: file for file in earlier.files}
        self._put = put

    def write(self, name: str) -> StoredFile | None:
        """Write a file by its name in the data folder; return None if it was removed meanwhile.

        Raises
        ------
        Unavailable
            It cannot be read.
        """
        path = self._folder / name
        try:
            with disk_errors(path, but=FileNotFoundError), path.open("rb") as file:
                found = path.stat()
                earlier = self._earlier.get(name)
                if earlier is not None and (earlier.size, earlier.changed) == (found.st_size, found.st_mtime):
                    return earlier
                digest, blocks, size = hashlib.sha256(), [], 0
                while data := file.read(CHUNK):
                    digest.update(data)
                    blocks.append(self._put(data))
                    size += len(data)
        except FileNotFoundError:
            return None
        return StoredFile(name, digest.hexdigest(), size, found.st_mtime, tuple(blocks))


class FileReader:
    """Restores the files of a backup.

    Parameters
    ----------
    repository : Repository
    manifest : BackupManifest
        The backup.
    folder : Path
        Data folder, which is created if it does not exist.
    """

    def __init__(self, repository: Repository, manifest: BackupManifest, folder: Path) -> None:
        self._repository = repository
        self._manifest = manifest
        self._folder = folder

    def copy(self, *, overwrite: bool = False) -> Iterator[Copied]:
        """Write the files that the folder lacks, as ``copying.copy`` does with records.

        Raises
        ------
        Unavailable, Damaged
            Errors of the repository and of the disk; files that were written until then stay.
        """
        done = Copied(KIND)
        yield done
        for file in self._manifest.files:
            there = self._digest_of(file)
            wanted = there is None or (there != file.sha256 and overwrite)
            if wanted:
                self._write(file)
            done.records += 1
            done.copied += wanted
            done.different += there not in (None, file.sha256) and not wanted
            yield done

    def compare(self) -> Iterator[Compared]:
        """Read the files, and compare them with the backup, as ``copying.compare`` does with records."""
        done, digests = Compared(KIND), (hashlib.sha256(), hashlib.sha256())
        for file in self._manifest.files:
            there = self._digest_of(file)
            digests[0].update(file.sha256.encode())
            digests[1].update((there or "").encode())
            done.records += 1
            done.same += there == file.sha256
            done.missing += there is None
            done.different += there not in (None, file.sha256)
            if there != file.sha256 and len(done.named) < MAX_NAMED:
                done.named.append(file.name)
            yield done
        done.digest, done.digest_there = (digest.hexdigest() for digest in digests)
        yield done

    def _path(self, file: StoredFile) -> Path:
        parts = PurePosixPath(file.name).parts
        if not parts or parts[0] == "/" or ".." in parts:
            raise damaged(f"backup {self._manifest.id}", f"{file.name!r} is no file of a data folder")
        return self._folder.joinpath(*parts)

    def _digest_of(self, file: StoredFile) -> str | None:
        path = self._path(file)
        try:
            with disk_errors(path, but=FileNotFoundError), path.open("rb") as stored:
                return hashlib.file_digest(stored, "sha256").hexdigest()
        except FileNotFoundError:
            return None

    def _write(self, file: StoredFile) -> None:
        """Write a file beside its place, and move it there once it is complete: a killed restoration leaves no half."""
        path = self._path(file)
        partial = path.with_name(f"{path.name}.restoring")
        with disk_errors(path):
            path.parent.mkdir(mode=PRIVATE_FOLDER, parents=True, exist_ok=True)
            with os.fdopen(os.open(partial, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, PRIVATE), "wb") as target:
                digest = hashlib.sha256()
                for name in file.blocks:
                    data = self._repository.block(name)
                    digest.update(data)
                    target.write(data)
                target.flush()
                os.fsync(target.fileno())
            if digest.hexdigest() != file.sha256:
                partial.unlink()
                raise damaged(f"{file.name} in backup {self._manifest.id}", "its hash differs")
            os.utime(partial, (file.changed, file.changed))
            partial.replace(path)
