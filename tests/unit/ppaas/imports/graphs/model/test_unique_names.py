from ppaas.imports.graphs.model.unique_names import LONGEST, unique_name


def test_names_are_taken_without_what_is_refused() -> None:
    assert unique_name("Lift  1", ()) == "Lift 1"
    assert unique_name("a/b\x00c", ()) == "a-b-c"
    assert unique_name("  ", ()) == "unnamed"
    assert unique_name("inn-Floor 1", (), r"[^A-Za-z0-9_.-]+") == "inn-Floor-1"


def test_names_that_are_taken_get_a_number_within_the_length() -> None:
    assert unique_name("x", {"x", "x-2"}) == "x-3"
    long = unique_name("y" * 100, {"y" * LONGEST})
    assert (len(long), long[-3:]) == (LONGEST, "y-2")
