"""The folders of the code form layers, none is crowded, and no import hides in a string."""

from tests.architecture import structure
from tests.support.sources import ALL_PACKAGES, Source, sources


def test_no_folders_import_each_other_in_a_circle():
    assert structure.folder_cycle(structure.arrows_between(structure.all_imports())) == []


def test_no_folder_is_crowded():
    assert structure.crowded_folders() == []


def test_no_module_is_reached_by_its_name_in_a_string():
    modules = frozenset(structure.import_graph().modules)
    faults = [fault for source in sources(*ALL_PACKAGES) for fault in structure.unseen_module_names(source, modules)]
    assert faults == []


# -- the rules find what breaks them -----------------------------------------------------------------------------------


def test_a_cycle_of_folders_is_told_by_the_imports_that_make_it():
    imports = [
        ("ppaas.maps.grid", "ppaas.errors"),
        ("ppaas.costmap.costmap", "ppaas.maps.grid"),
        ("ppaas.maps.grid", "ppaas.costmap.costmap"),
    ]
    cycle = structure.folder_cycle(structure.arrows_between(iter(imports)))
    assert sorted(cycle) == [
        "ppaas.costmap.costmap -> ppaas.maps.grid",
        "ppaas.maps.grid -> ppaas.costmap.costmap",
    ]


def test_a_folder_and_the_one_above_it_may_make_a_cycle():
    imports = [("ppaas.maps.grid", "ppaas.errors"), ("ppaas.errors", "ppaas.maps.grid")]
    assert len(structure.folder_cycle(structure.arrows_between(iter(imports)))) == 2


def test_imports_within_a_folder_make_no_arrow():
    assert structure.arrows_between(iter([("ppaas.maps.grid", "ppaas.maps.raycast")])) == {}


def test_a_module_named_in_a_string_and_not_imported_is_found():
    modules = frozenset({"engine.fabric.router", "ppaas.planners"})
    command = 'COMMAND = ("python", "-m", "engine.fabric.router")\n'
    assert structure.unseen_module_names(Source.of("engine/agent/agent.py", command), modules)
    seen = "from engine.fabric import router\n" + command
    assert structure.unseen_module_names(Source.of("engine/agent/agent.py", seen), modules) == []


def test_the_name_of_an_entry_point_group_or_a_word_in_a_docstring_is_no_hidden_import():
    modules = frozenset({"engine.fabric.router", "ppaas.planners"})
    text = '"""engine.fabric.router"""\nGROUP = "ppaas.planners"\nFOLDER = "engine/fabric"\n'
    assert structure.unseen_module_names(Source.of("engine/agent/agent.py", text), modules) == []
