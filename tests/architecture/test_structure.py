"""The folders of the code form layers, none has too many modules, and no import is hidden in a string."""

import grimp

from tests.architecture import structure
from tests.support.sources import ALL_PACKAGES, Source, sources


def test_folders_have_no_import_cycle():
    assert structure.folder_cycle(structure.arrows_between(structure.all_imports())) == []


def test_no_folder_has_too_many_modules():
    assert structure.crowded_folders() == []


def test_no_module_is_imported_by_a_string_only():
    modules = frozenset(structure.import_graph().modules)
    faults = [fault for source in sources(*ALL_PACKAGES) for fault in structure.unseen_module_names(source, modules)]
    assert faults == []


def test_a_small_module_has_two_importers_or_a_cause():
    lines = {
        source.path.removesuffix(".py").replace("/", "."): len(source.text.splitlines())
        for source in sources(*ALL_PACKAGES)
        if not source.path.endswith(("__init__.py", "__main__.py"))
    }
    assert structure.small_modules(structure.import_graph(), lines) == structure.listed("small_modules")


# -- the rules find violations -----------------------------------------------------------------------------------------


def test_folder_cycle_is_reported_with_its_imports():
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


def test_folder_and_its_parent_can_form_a_cycle():
    imports = [("ppaas.maps.grid", "ppaas.errors"), ("ppaas.errors", "ppaas.maps.grid")]
    assert len(structure.folder_cycle(structure.arrows_between(iter(imports)))) == 2


def test_imports_within_a_folder_are_no_dependency():
    assert structure.arrows_between(iter([("ppaas.maps.grid", "ppaas.maps.raycast")])) == {}


def test_module_named_only_in_a_string_is_found():
    modules = frozenset({"engine.fabric.router", "ppaas.planners"})
    command = 'COMMAND = ("python", "-m", "engine.fabric.router")\n'
    assert structure.unseen_module_names(Source.of("engine/agent/agent.py", command), modules)
    seen = "from engine.fabric import router\n" + command
    assert structure.unseen_module_names(Source.of("engine/agent/agent.py", seen), modules) == []


def test_entry_point_groups_and_docstrings_are_not_hidden_imports():
    modules = frozenset({"engine.fabric.router", "ppaas.planners"})
    text = '"""engine.fabric.router"""\nGROUP = "ppaas.planners"\nFOLDER = "engine/fabric"\n'
    assert structure.unseen_module_names(Source.of("engine/agent/agent.py", text), modules) == []


def test_a_small_module_is_one_with_few_lines_and_one_importer():
    graph = grimp.ImportGraph()
    for module in ("a", "b", "c"):
        graph.add_module(module)
    graph.add_import(importer="a", imported="b")
    assert structure.small_modules(graph, {"b": 59, "c": 60}) == ["b"]
    graph.add_import(importer="c", imported="b")
    assert structure.small_modules(graph, {"b": 59}) == []
