from benchmarks.mapping.parts.volumes import figures_of, row

RESULT = {
    "method": "blocks", "threads": 1, "points": 1000, "points_per_s": 3_000_000, "points_per_cpu_s": 4_000_000,
    "wall_s": 0.1, "voxels": 50, "equal_log_odds": 1.0, "equal_occupancy": 0.998,
}  # fmt: skip


def test_one_thread_is_measured_by_its_cpu_time_and_two_by_the_clock():
    rate, equal = figures_of(RESULT, bars=True)
    assert (rate.value, rate.limit, rate.kept) == (4_000_000, 1.1e6, True)
    assert (equal.value, equal.kept) == (99.8, False)
    (rate,) = figures_of(RESULT | {"threads": 2}, bars=True)
    assert (rate.value, rate.limit) == (3_000_000, 2.0e6)
    assert figures_of(RESULT, bars=False)[0].limit is None
    assert row(RESULT)["equal occupancy"] == "99.800 %"


def test_the_insertion_of_octomap_is_a_baseline():
    baseline = {name: value for name, value in RESULT.items() if name not in ("threads", "equal_occupancy")}
    (figure,) = figures_of(baseline, bars=True)
    assert figure.yardstick and figure.limit is None
    assert row(baseline)["equal occupancy"] == ""
