"""A public class name stands for one class, unless `shared_class_names` gives a cause."""

import ast
from collections import defaultdict
from collections.abc import Iterable

from tests.support.sources import ALL_PACKAGES, ROOT, Source, sources

LISTED = (ROOT / "tests" / "architecture" / "shared_class_names").read_text(encoding="utf-8")


def causes(listed: str) -> dict[str, str]:
    """Return the listed names with their causes."""
    rows = (line.partition(":") for line in listed.splitlines() if not line.startswith("#"))
    return {name: cause.strip() for name, _, cause in rows}


def shared_names(files: Iterable[Source]) -> dict[str, list[str]]:
    """Return the public class names that stand twice or more, each with the places of its classes."""
    places: dict[str, list[str]] = defaultdict(list)
    for source in files:
        for node in source.tree.body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                places[node.name].append(f"{source.path}:{node.lineno}")
    return {name: found for name, found in places.items() if len(found) > 1}


def name_faults(files: Iterable[Source], listed: str) -> list[str]:
    """Return the shared names without a cause, and the listed names that are not shared."""
    shared, known = shared_names(files), causes(listed)
    faults = [f"{name} stands in {', '.join(shared[name])}" for name in sorted(shared) if not known.get(name)]
    return faults + [f"{name} is listed and stands once at most" for name in known if name not in shared]


def test_no_public_class_name_stands_twice_without_a_cause():
    assert name_faults(sources(*ALL_PACKAGES), LISTED) == []


def test_shared_class_names_are_sorted():
    names = [line.partition(":")[0] for line in LISTED.splitlines() if not line.startswith("#")]
    assert names == sorted(set(names))


# -- the rule finds violations -----------------------------------------------------------------------------------------

TWO = [
    Source.of("ppaas/wire/foxglove/answers.py", "class Channel: ...\nclass _Part: ..."),
    Source.of("ppaas/recording/reader.py", "class Channel: ...\nclass _Part: ..."),
]


def test_name_of_two_classes_is_found_with_their_places():
    [fault] = name_faults(TWO, "# Names\n")
    assert fault == "Channel stands in ppaas/wire/foxglove/answers.py:1, ppaas/recording/reader.py:1"


def test_listed_name_needs_a_cause():
    assert len(name_faults(TWO, "Channel:\n")) == 1
    assert name_faults(TWO, "Channel: one is of Foxglove\n") == []


def test_listed_name_that_stands_once_is_found():
    assert name_faults(TWO[:1], "Channel: one is of Foxglove\n") == ["Channel is listed and stands once at most"]


def test_private_and_inner_classes_may_share_names():
    inner = "class A:\n    class Config: ...\nclass B:\n    class Config: ...\n"
    assert name_faults([Source.of("ppaas/maps/grid.py", inner), *TWO], "Channel: one is of Foxglove\n") == []
