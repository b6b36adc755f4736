import pytest

from ppaas.errors import InvalidParameter
from ppaas.mapping.parameters import SlamParameters
from ppaas.parameters import read_parameters


def test_names_of_slam_toolbox_and_gmapping_are_read():
    given = {"minimum_travel_distance": 0.5, "scan_buffer_size": 10, "srr": 0.2, "str": 0.3}
    parameters = read_parameters(SlamParameters, "grid_slam", given)
    assert (parameters.minimum_travel_distance, parameters.scan_buffer_size) == (0.5, 10)
    assert (parameters.srr, parameters.str) == (0.2, 0.3)


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"resolution": 0.0}, "resolution must be above 0"),
        ({"srt": -0.1}, "srt must be at least 0"),
        ({"max_laser_range": 0.01}, "below max_laser_range"),
        ({"scan_buffer_size": 65}, "at most 64"),
        ({"no_such": 1}, "no_such"),
    ],
)
def test_parameters_out_of_range_are_refused(given, text):
    with pytest.raises(InvalidParameter, match=text):
        read_parameters(SlamParameters, "grid_slam", given)
