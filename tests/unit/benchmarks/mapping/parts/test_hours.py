from benchmarks.mapping.parts.lifelong import figure_of

HOUR = {"memory_mb": 200.0, "key_frames": 900}


def test_the_growth_is_that_of_the_last_hour():
    figure = figure_of([HOUR | {"hour": 1}, HOUR | {"hour": 2, "memory_mb": 203.5, "key_frames": 910}])
    assert (figure.value, figure.kept) == (3.5, False)
    assert figure.note.endswith("from 900 to 910 key frames")
