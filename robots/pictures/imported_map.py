"""Picture of an imported map, with the plan that it was made of beside it."""

from pathlib import Path
from typing import TYPE_CHECKING

from PIL import Image, ImageDraw

from ppaas.zones.reading import geojson_of
from robots.pictures.map_pictures import GridImage, draw_zones
from robots.pictures.path import FAINT, INK, PAPER, check_picture

if TYPE_CHECKING:
    from ppaas.imports.maps.common.imported_map import ImportedMap
    from ppaas.imports.maps.drawings.plan_picture import DrawnPlan

_GAP, _HEAD = 24, 40


def write_imported(path: Path, imported: "ImportedMap", drawn: "DrawnPlan | None" = None) -> None:
    """Draw an imported map with its zones, and write it to a PNG file.

    Parameters
    ----------
    path : Path
    imported : ImportedMap
    drawn : DrawnPlan, optional
        The plan before its walls were found, drawn to the left.

    Raises
    ------
    InvalidInput
        The file name does not end with ``.png``, or the file cannot be written.
    """
    check_picture(path)
    after = draw_zones(imported.grid, geojson_of(imported.zones))
    if drawn is None:
        after.write(path)
        return
    height = after.picture.height
    before = Image.fromarray(drawn.greys)
    before = before.resize((max(1, round(before.width * height / before.height)), height), Image.Resampling.LANCZOS)
    sheet = Image.new("RGB", (before.width + after.picture.width + 3 * _GAP, height + _HEAD + _GAP), PAPER)
    brush = ImageDraw.Draw(sheet)
    left = _GAP
    for title, picture in (("before", before), ("after", after.picture)):
        brush.text((left, _HEAD // 4), title, INK, font_size=18)
        sheet.paste(picture, (left, _HEAD))
        brush.rectangle((left - 1, _HEAD - 1, left + picture.width, _HEAD + height), outline=FAINT)
        left += picture.width + _GAP
    GridImage(sheet, imported.grid.info, after.scale).write(path)
