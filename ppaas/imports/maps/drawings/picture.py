"""Floor plans as pictures: PNG, JPEG, BMP and the other formats of images of maps."""

import numpy as np
from PIL import Image

from ppaas.imports.maps.drawings.plan_picture import DrawnPlan, PlanOptions, needed_scale
from ppaas.imports.report import ImportReport
from ppaas.maps.formats.image import open_image


def draw_picture(content: bytes, options: PlanOptions, report: ImportReport) -> DrawnPlan:
    """Return a picture as plan; transparent pixels are white. Raises ``InvalidMap`` if it cannot be read.

    Colours become greys by ITU-R BT.601.
    """
    scale = needed_scale(options)
    opened = open_image(content)
    image = opened.rows(0, opened.shape[0])
    channels = image.channels
    greys = channels[..., 0]
    if channels.shape[2] > 1:
        greys = np.asarray(Image.fromarray(np.ascontiguousarray(channels[..., :3])).convert("L"))
    if image.alpha is not None:
        greys = np.where(image.alpha < 128, np.uint8(255), greys)
    height, width = greys.shape
    report.taken("picture", f"{width} × {height} pixels of {scale.unit:.4g} m")
    return DrawnPlan(np.ascontiguousarray(greys), scale.unit)
