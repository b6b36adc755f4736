"""Floor plans as pictures: PNG, JPEG, BMP and the other formats of images of maps."""

import numpy as np

from ppaas.imports.maps.drawings.plan_picture import DrawnPlan, PlanOptions, needed_scale
from ppaas.imports.report import ImportReport
from ppaas.maps.formats.image import open_image

_LUMA = np.array([299, 587, 114], np.uint32)
"""Weights of red, green and blue in a grey [1/1000] (ITU-R BT.601)."""


def draw_picture(content: bytes, options: PlanOptions, report: ImportReport) -> DrawnPlan:
    """Return a picture as plan; transparent pixels are white. Raises ``InvalidMap`` if it cannot be read."""
    scale = needed_scale(options)
    opened = open_image(content)
    image = opened.rows(0, opened.shape[0])
    channels = image.channels
    greys = channels[..., 0] if channels.shape[2] == 1 else ((channels[..., :3] @ _LUMA + 500) // 1000).astype(np.uint8)
    if image.alpha is not None:
        greys = np.where(image.alpha < 128, np.uint8(255), greys)
    height, width = greys.shape
    report.taken("picture", f"{width} × {height} pixels of {scale.unit:.4g} m")
    return DrawnPlan(np.ascontiguousarray(greys), scale.unit)
