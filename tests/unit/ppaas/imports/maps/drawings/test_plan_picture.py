"""Size in which drawings are rendered."""

import pytest

from ppaas.errors import InvalidMap
from ppaas.imports.maps.drawings.plan_picture import MOST_PIXELS, PlanOptions, ScaleBar, pixels_of

METRES = PlanOptions(ScaleBar((0.0, 0.0), (1.0, 0.0), 1.0), resolution=0.05)


@pytest.mark.parametrize(("metres", "along"), [(9.0, 3), (135.0, 2), (200.0, 1)])
def test_a_large_drawing_has_fewer_pixels_along_a_cell(metres: float, along: int) -> None:
    columns, rows, pixel = pixels_of(metres, metres, METRES)
    assert (columns, rows, pixel) == (round(metres / pixel), round(metres / pixel), METRES.resolution / along)
    assert columns * rows <= MOST_PIXELS


def test_a_drawing_of_too_many_cells_is_refused_with_their_size() -> None:
    with pytest.raises(InvalidMap, match=r"10000 × 10000 cells of 0.05 m"):
        pixels_of(500.0, 500.0, METRES)
