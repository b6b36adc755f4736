from benchmarks.mapping import live
from benchmarks.mapping.ring import ring_drive


def test_steps_are_measured_beside_their_baselines(monkeypatch):
    monkeypatch.setattr(live, "SEARCHES", 2)
    monkeypatch.setattr(live, "TARGET", 8)
    frames, latencies = live.drive(ring_drive().log.first(250))
    scans, searched = latencies.result(), live.searches(frames)
    assert (scans["count"], searched["count"]) == (250, 2)
    assert 0.0 < scans["mean_ms"] <= scans["max_ms"]
    # The window contains the true motion, and the older scans show the place.
    assert searched["least_score"] > 0.8
    assert live.row(searched)["step"] == "search of 4 m × 90°"
