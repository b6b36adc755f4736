"""Parameter files of gmapping."""

from ppaas.imports.parameters.slam.gmapping import import_gmapping
from tests.support.imported_parameters import outcomes, refused

TEXT = b"""
slam_gmapping:
  base_frame: base_footprint
  delta: 0.1
  maxUrange: 5.5
  maxRange: 8.0
  linearUpdate: 0.0
  temporalUpdate: -1.0
  particles: 80
  xmin: -50.0
  tf_delay: 0.05
  lstpe: 0.05
"""


def test_gmapping_has_its_names_in_grid_slam() -> None:
    into = import_gmapping(TEXT, "gmapping.yaml", "hall")
    assert into[0] == {
        "map": "new:hall",
        "parameters": {
            "grid_slam": {
                "base_frame": "base_footprint", "delta": 0.1, "maxUrange": 5.5, "linearUpdate": 0.05,
                "temporalUpdate": -1.0, "transform_timeout": 0.05,
            }
        },
    }  # fmt: skip
    found = outcomes(into)
    assert found["slam_gmapping.particles"] == found["slam_gmapping.xmin"] == "no effect"
    assert refused(into) == ["unknown parameter; did you mean 'lstep'?"]
