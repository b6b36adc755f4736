"""The structure of the code as its imports show it: folders, the arrows between them, and modules named in strings."""

import ast
import itertools
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping
from functools import cache
from graphlib import CycleError, TopologicalSorter
from typing import cast

import grimp

from tests.support.sources import ALL_PACKAGES, ROOT, Source, pyproject

MAX_MODULES = 20
"""Modules in a folder, its ``__init__`` not counted."""
MAX_KERNELS = 25
"""Modules in a folder of kernels, which are short and many."""

SMALL_MODULE = 60
"""Lines below which a module needs two importers."""

MODULE_NAME = re.compile(rf"(?P<module>(?:{'|'.join(ALL_PACKAGES)})(?:\.[a-z_0-9]+)+)(?::\w+)?")

Arrows = dict[str, dict[str, list[str]]]
"""Importing folder to imported folder to the imports, each as ``importer -> imported``."""


def folder_of(module: str) -> str:
    """Return the package that directly holds a module; a package's own ``__init__`` lies in the package."""
    is_package = (ROOT / module.replace(".", "/") / "__init__.py").is_file()
    return module if is_package else module.rpartition(".")[0]


def arrows_between(imports: Iterator[tuple[str, str]]) -> Arrows:
    """Return the arrows between folders that imports make, arrows within a folder left out."""
    arrows: Arrows = defaultdict(lambda: defaultdict(list))
    for importer, imported in imports:
        source, target = folder_of(importer), folder_of(imported)
        if source != target:
            arrows[source][target].append(f"{importer} -> {imported}")
    return arrows


@cache
def import_graph() -> grimp.ImportGraph:
    """Return the imports of all packages, those within functions and under ``TYPE_CHECKING`` included."""
    return grimp.build_graph(*ALL_PACKAGES)


def all_imports() -> Iterator[tuple[str, str]]:
    """Yield each import of the code as importer and imported module."""
    graph = import_graph()
    for module in sorted(graph.modules):
        yield from ((module, imported) for imported in sorted(graph.find_modules_directly_imported_by(module)))


def folder_cycle(arrows: Arrows) -> list[str]:
    """Return the imports that make one cycle of folders, or nothing where there is none."""
    try:
        TopologicalSorter({source: targets.keys() for source, targets in arrows.items()}).prepare()
    except CycleError as error:
        # The sorter lists a cycle from each folder to the one that imports it.
        cycle = cast("list[str]", error.args[1])[::-1]
        return [arrows[source][target][0] for source, target in itertools.pairwise(cycle)]
    return []


def crowded_folders() -> list[str]:
    """Return the folders that hold more modules than a newcomer reads in one look."""
    found = []
    for package in ALL_PACKAGES:
        for init in sorted((ROOT / package).rglob("__init__.py")):
            modules = len(list(init.parent.glob("*.py"))) - 1
            most = MAX_KERNELS if init.parent.name == "kernels" else MAX_MODULES
            if modules > most:
                found.append(f"{init.parent.relative_to(ROOT)}: {modules} modules, at most {most}")
    return found


def listed(name: str) -> list[str]:
    """Return the first words of a list of this folder: each line is ``word: cause``, those with ``#`` are comments."""
    lines = (ROOT / "tests" / "architecture" / name).read_text(encoding="utf-8").splitlines()
    return [line.partition(":")[0] for line in lines if not line.startswith("#")]


def small_modules(graph: grimp.ImportGraph, lines: Mapping[str, int]) -> list[str]:
    """Return the small modules that fewer than two others import: each belongs into the module that a reader opens.

    Parameters
    ----------
    graph : grimp.ImportGraph
    lines : mapping of str to int
        Number of lines of each module to look at.
    """
    return [
        module
        for module, count in sorted(lines.items())
        if count < SMALL_MODULE and len(graph.find_modules_that_directly_import(module)) < 2
    ]


def docstrings(tree: ast.Module) -> set[ast.Constant]:
    """Return the strings of a module that stand alone: docstrings, and those below a constant."""
    return {
        node.value for node in ast.walk(tree) if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    }


def unseen_module_names(source: Source, modules: frozenset[str]) -> list[str]:
    """Return strings that name a module which the same file does not import.

    A module that is reached by such a string is an import that neither import-linter nor mypy sees: a rename breaks it
    at run time, and an arrow against the layers goes unnoticed. Names of entry-point groups are no modules.
    """
    groups = pyproject()["project"]["entry-points"].keys()
    imported = set(imported_names(source.tree))
    docs = docstrings(source.tree)
    strings = (
        (node, match["module"])
        for node in ast.walk(source.tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node not in docs
        for match in [MODULE_NAME.fullmatch(node.value)]
        if match
    )
    return [
        f"{source.path}:{node.lineno} names {name}, and does not import it"
        for node, name in strings
        if name in modules and name not in imported and name not in groups
    ]


def imported_names(tree: ast.Module) -> Iterator[str]:
    """Yield the dotted names that the import statements of a module may bind, wherever they stand."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
