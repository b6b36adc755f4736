"""Maps of other programs in files, of formats that are read from memory or, as E57, from files alone."""

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from ppaas.distribution import install_hint
from ppaas.errors import InvalidInput
from ppaas.imports.maps.clouds.e57 import MAGIC, damaged, read_e57
from ppaas.imports.maps.common.imported_map import ImportedMap, MapOptions
from ppaas.imports.maps.importing import import_cloud, import_map
from ppaas.imports.report import ImportReport

if TYPE_CHECKING:
    from ppaas.imports.maps.clouds.point_cloud import PointCloud


def import_foreign_map(
    content: bytes, name: str, options: MapOptions | None = None
) -> tuple[ImportedMap, ImportReport]:
    """Import a map of any known format; parameters and errors as `import_map`."""
    if content.startswith(MAGIC):
        return import_cloud(content, name, options or MapOptions(), _read_e57)
    return import_map(content, name, options)


def _read_e57(content: bytes, report: ImportReport) -> "PointCloud":
    try:
        import pye57  # noqa: PLC0415 - needed for these files alone
    except ImportError as error:
        raise InvalidInput(f"E57 files need pye57: {install_hint('clouds')}") from error
    with tempfile.TemporaryDirectory(prefix="ppaas-e57-") as folder:
        file = Path(folder) / "scans.e57"
        file.write_bytes(content)
        try:
            opened = pye57.E57(str(file))
        # libE57 raises an error of C++ of a kind that it does not export.
        except Exception as error:
            raise damaged(error) from error
        with opened:
            return read_e57(opened, len(content), report)
