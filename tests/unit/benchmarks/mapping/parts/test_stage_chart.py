from benchmarks.mapping.parts.suite import _points, write_stages

SECONDS = {"points": 1.0, "tracking": 2.0, "closures": 1.5, "solver": 0.5, "refinement": 3.0, "polish": 1.0}
ERRORS = {"tracking": 0.1, "closures": 0.03, "refinement": 0.02, "polish": 0.01}
TIMES = {"cpu_s": 5.0, "wall_s": 10.0}
STAGES = {name: {"mean_m": error} for name, error in ERRORS.items()}


def test_error_and_time_after_each_stage_are_drawn(tmp_path):
    without: dict[str, dict[str, float]] = {name: {} for name in STAGES}
    results = [
        {"log": "a", "seconds": SECONDS, **TIMES, "stages": STAGES},
        {"log": "b", "seconds": SECONDS, **TIMES, "stages": without},
    ]
    path = tmp_path / "stages.png"
    write_stages(path, results)
    assert path.read_bytes().startswith(b"\x89PNG")


def test_a_stage_takes_the_time_of_its_parts_after_that_of_the_stages_before():
    assert _points({"seconds": SECONDS, **TIMES, "stages": STAGES}) == [
        (1.5, 0.1),
        (2.5, 0.03),
        (4.0, 0.02),
        (4.5, 0.01),
    ]
