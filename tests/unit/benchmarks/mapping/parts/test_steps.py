from benchmarks.mapping.parts import steps
from benchmarks.mapping.small_worlds import ring_drive
from ppaas.maps.generate import office


def test_steps_are_measured_beside_their_baselines(monkeypatch):
    monkeypatch.setattr(steps, "SEARCHES", 2)
    monkeypatch.setattr(steps, "TARGET", 8)
    frames, latencies = steps.drive(ring_drive().log.first(250))
    scans, searched = latencies.result(), steps.searches(frames)
    assert (scans["count"], searched["count"]) == (250, 2)
    assert 0.0 < scans["mean_ms"] <= scans["max_ms"]
    # The window contains the true motion, and the older scans show the place.
    assert searched["least_score"] > 0.8
    assert steps.row(searched)["step"] == "search of 4 m × 90°"


def test_layers_are_measured_on_the_whole_map(monkeypatch):
    monkeypatch.setattr(steps, "BUILDS", 2)
    built = steps.layers(office(0, 14.0, 11.0))
    assert (built["step"], built["count"]) == ("layers of 280 × 220 cells", 2)
    assert 0.0 < built["mean_ms"] <= built["max_ms"]
