"""Options and result of a part of ``ppaas bench slam``."""

from dataclasses import dataclass
from pathlib import Path

from ppaas.errors import InvalidInput


@dataclass(frozen=True, slots=True)
class SlamOptions:
    """Options of all parts.

    Parameters
    ----------
    logs : tuple of Path
        Recorded logs to map.
    data : Path, optional
        Folder of recorded data: ``laser/raw`` has logs, ``depth`` has depth images.
    offices : int
        Number of simulated offices.
    worlds : bool
        Whether simulated worlds are mapped, too.
    equal_corridors : bool
        Whether corridors without open doors are mapped.
    graphs : tuple of Path
        Graphs in the format of g2o.
    false : int
        Number of false closures of a synthetic graph.
    all_pairs : bool
        Whether recorded logs are among the buildings that must not be merged.
    jobs : int
        Number of logs that are mapped at once.
    folder : Path
        Maps are written here for other parts, see `benchmarks.mapping.parts.mapped`.
    """

    logs: tuple[Path, ...] = ()
    data: Path | None = None
    offices: int = 1
    worlds: bool = True
    equal_corridors: bool = False
    graphs: tuple[Path, ...] = ()
    false: int = 60
    all_pairs: bool = False
    jobs: int = 1
    folder: Path = Path()

    def check(self) -> None:
        """Raise ``InvalidInput`` if a file or folder is missing."""
        missing = [str(file) for file in (*self.logs, *self.graphs) if not file.is_file()]
        if missing:
            raise InvalidInput(f"there is no file {missing[0]}")
        if self.data is not None and not self.recorded():
            raise InvalidInput(f"{self.data / 'laser' / 'raw'} has no log: no file *.clf or *.clf.bz2")

    def recorded(self) -> list[Path]:
        """Return the logs of the folder of data."""
        return [] if self.data is None else sorted((self.data / "laser" / "raw").glob("*.clf*"))

    def with_relations(self) -> list[Path]:
        """Return the logs, and those of the folder of data that have true relations beside them."""
        return [*self.logs, *(log for log in self.recorded() if relations_of(log).is_file())]


def name_of(log: Path) -> str:
    """Return the name of a log."""
    return log.name.partition(".")[0]


def relations_of(log: Path) -> Path:
    """Return the file of the true relations of a log, which need not exist."""
    return log.with_name(f"{name_of(log)}.relations")
