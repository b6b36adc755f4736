"""Names like an unknown one."""

from ppaas.imports.nearest_name import nearest_name


def test_the_most_similar_name_is_found_whatever_its_case() -> None:
    assert nearest_name("Debg", ("deal", "debug", "rules")) == "debug"
    assert nearest_name("max_vel_X", ("MAX_VEL_x",)) == "MAX_VEL_x"


def test_names_that_are_not_like_it_are_none() -> None:
    assert nearest_name("nothing_like_it", ("debug", "max_vel_x")) is None
    assert nearest_name("debg", ("debug",), 0.95) is None
