"""Option ``--picture`` of ``ppaas map zones``: the map with zones, before or after they are published."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ppaas.errors import ZoneFault

if TYPE_CHECKING:
    from robots.client.rest import RestClient


def check_zones_picture(picture: Path | None) -> None:
    """Raise ``InvalidInput`` if a picture has another ending than ``.png``."""
    if picture is not None:
        from robots.pictures.path import check_picture  # noqa: PLC0415 - pictures need more than the base install

        check_picture(picture)


async def draw_zones(
    client: "RestClient", path: str, picture: Path | None, geojson: bytes, faults: Sequence[ZoneFault] = ()
) -> None:
    """Draw zones and their faults on a map as a PNG file, if one is named.

    Parameters
    ----------
    client : RestClient
    path : str
        Path of the map or of a version of it.
    picture : Path, optional
    geojson : bytes
    faults : sequence of ZoneFault
    """
    if picture is None:
        return
    # Pictures and maps need more than the base install.
    from ppaas.maps.formats.map_files import load_map  # noqa: PLC0415
    from robots.pictures.zones import write_zones  # noqa: PLC0415

    yaml, image = [await client.fetch(f"{path}/{part}") for part in ("yaml", "image")]
    write_zones(picture, load_map(yaml, image), geojson, faults)
