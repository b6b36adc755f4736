"""Occupancy of pixels, by the rules of map_server or of Nav2.

Sources: ``image_loader.cpp`` of map_server (ros-planning/navigation) and ``map_io.cpp`` of Nav2
(ros-navigation/navigation2). Three apparent errors of map_server are not reproduced: it takes palette indices as greys,
it takes the blue of an RGB image as alpha, and its raw mode produces values that an occupancy grid cannot hold (they
are unknown here, as in Nav2).
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.maps.formats.image import MapImage
from ppaas.maps.formats.map_yaml import MapYaml, Mode, Rules
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN

Cells = NDArray[np.int8]

_LUMA = np.array([299, 587, 114], np.uint32)
"""Weights of red, green and blue in a grey [1/1000] (ITU-R BT.601), as GraphicsMagick uses them for Nav2."""


def occupancy(image: MapImage, keys: MapYaml) -> Cells:
    """Return the occupancy of each pixel.

    Parameters
    ----------
    image : MapImage
        Row 0 on top.
    keys : MapYaml
        Thresholds, mode and rules.

    Returns
    -------
    (height, width) int8 array
        0 free to 100 occupied, −1 unknown; row 0 on top.
    """
    return (_by_nav2 if keys.rules is Rules.NAV2 else _by_map_server)(image, keys)


# -- map_server --------------------------------------------------------------------------------------------------------


def _by_map_server(image: MapImage, keys: MapYaml) -> Cells:
    """Classify pixels by the mean of their channels, which in trinary mode includes alpha.

    A cell is occupied above ``occupied_thresh``, else free below ``free_thresh``, else graded (scale) or unknown
    (trinary). In scale mode, fully transparent pixels between the thresholds are unknown. Where the thresholds are
    equal, map_server divides 0 by 0 for a pixel between them; it is unknown here.
    """
    alpha = image.alpha
    averaged = image.channels if keys.mode is Mode.TRINARY else image.channels[..., :3]
    count = averaged.shape[2]
    total = averaged[..., 0] if count == 1 else averaged.sum(axis=2, dtype=np.uint16)
    mean = np.arange(255 * count + 1) / count
    mean = 255.0 - mean if keys.negate else mean
    if keys.mode is Mode.RAW:
        return _raw(mean)[total]
    ratio = (255.0 - mean) / 255.0
    between = (ratio >= keys.free_thresh) & (ratio <= keys.occupied_thresh)
    values = np.where(ratio > keys.occupied_thresh, OCCUPIED, FREE).astype(np.int8)
    span = keys.occupied_thresh - keys.free_thresh
    scaled = keys.mode is Mode.SCALE and span > 0.0
    values[between] = 1.0 + 98.0 * (ratio[between] - keys.free_thresh) / span if scaled else UNKNOWN
    cells = values[total]
    if keys.mode is Mode.SCALE and alpha is not None:
        cells[between[total] & (alpha == 0)] = UNKNOWN
    return cells


# -- Nav2 --------------------------------------------------------------------------------------------------------------


def _by_nav2(image: MapImage, keys: MapYaml) -> Cells:
    """Classify pixels by their luma, in float32 as Nav2 does.

    A cell is free up to ``free_thresh``, else occupied from ``occupied_thresh`` up, else graded (scale) or unknown
    (trinary). A pixel that is not fully opaque is unknown. Raw mode ignores alpha and ``negate``.
    """
    luma = _luma(image)
    if keys.mode is Mode.RAW:
        return _raw(np.arange(256.0))[luma]
    ratio = np.arange(256, dtype=np.float32) / np.float32(255.0)
    ratio = ratio if keys.negate else np.float32(1.0) - ratio
    low, high = np.float32(keys.free_thresh), np.float32(keys.occupied_thresh)
    # Overflows or divides by 0 only if the thresholds are so close that no value is between them.
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        graded = np.floor((ratio - low) / (high - low) * np.float32(100.0) + np.float32(0.5))
    between = graded if keys.mode is Mode.SCALE else np.full(256, UNKNOWN)
    values = np.where(ratio <= low, FREE, np.where(ratio >= high, OCCUPIED, between)).astype(np.int8)
    cells = values[luma]
    if image.alpha is not None:
        cells[image.alpha < 255] = UNKNOWN
    return cells


def _luma(image: MapImage) -> NDArray[np.uint8]:
    if image.channels.shape[2] == 1:
        return image.channels[..., 0]
    return ((image.channels[..., :3] @ _LUMA + 500) // 1000).astype(np.uint8)


def _raw(grey: NDArray[np.float64]) -> Cells:
    """Return the occupancy of greys in raw mode: the integer part of the grey, or unknown above 100."""
    return np.where(np.floor(grey) <= OCCUPIED, np.floor(grey), UNKNOWN).astype(np.int8)
