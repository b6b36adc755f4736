import pytest

from ppaas.imports.maps.drawings.names import is_door, is_other


@pytest.mark.parametrize(
    "name",
    [
        "A-DOOR",
        "doors",
        "Door_Swing",
        "I-DR",
        "Türen",
        "01_Innentür",
        "TUEREN",
        "porte",
        "PORTES_INT",
        "puertas",
        "Deuren",
    ],
)
def test_doors_are_known_in_several_languages(name):
    assert is_door(name) and not is_other(name)


@pytest.mark.parametrize(
    "name",
    ["A-ANNO-DIMS", "DIMENSIONS", "Bemaßung", "A-FURN", "furniture", "Möbel", "S-GRID", "Defpoints", "G-ANNO-TEXT"],
)
def test_what_is_no_wall_is_known_too(name):
    assert is_other(name) and not is_door(name)


@pytest.mark.parametrize(
    "name",
    ["WALLS", "A-WALL", "0", "STRUCTURE", "indoor_walls", "OUTDOOR", "Wände", "muros", "profondeur", "context",
     "layer1", "path10", "support", "denoted", "rect1234", "Turm"],
)  # fmt: skip
def test_other_names_are_those_of_walls(name):
    assert not is_door(name) and not is_other(name)
