"""Rules on the content of scans: angles, limits, ranges without readings, intensities."""

from collections.abc import Iterator

from ppaas.diagnosis.observations.facts import Observations, ScanFacts
from ppaas.diagnosis.rules.finding import Finding, error, ok, percent, warn
from ppaas.nodes import topics

FEW = 0.05
"""Share of readings below which a laser sees next to nothing."""

MANY_SHORT = 0.5
"""Share of ranges below ``range_min`` from which that limit is doubtful."""

INCREMENT = "Set angle_increment to (angle_max - angle_min) / (beams - 1)"

WIDE = "to map a hall that is wider than it sees, set 'inf_is_valid' of grid_slam."
"""Advice for lasers that are far from all walls."""

BLIND = "nothing is mapped: "
"""Beginning of the status of mapping while scans have no readings."""

FEWEST_BEAMS = 20
"""Number of beams below which localization has little to go by."""


def scans(seen: Observations) -> Iterator[Finding]:
    """Yield what is wrong with the content of the last scan of each laser."""
    for scan in seen.scans:
        yield from _limits(scan)
        yield from _ranges(scan)
        yield from _size(scan)


def _name(scan: ScanFacts) -> str:
    return f"of '{scan.frame}'" if scan.frame else "without a frame"


def _found(make: object, kind: str, text: str, advice: str) -> Finding:
    assert callable(make)
    finding: Finding = make(kind, text, advice, topics.SCAN.name)
    return finding


def _limits(scan: ScanFacts) -> Iterator[Finding]:
    name = _name(scan)
    if scan.range_max <= 0.0 or scan.range_max <= scan.range_min:
        text = f"Scans {name} have range_min {scan.range_min:g} and range_max {scan.range_max:g}: no range is between."
        yield _found(error, "scan-limits", text, "Set both to those of the laser, in metres, as 0.12 and 12.0.")
    if scan.beams > 1 and scan.increment == 0.0:
        text = f"Scans {name} have angle_increment 0: all beams would have one direction."
        yield _found(error, "scan-angles", text, f"{INCREMENT}, in radians.")
    elif abs(scan.increment) * max(scan.beams - 1, 0) > 7.0:
        turn = abs(scan.increment) * (scan.beams - 1)
        text = f"Scans {name} cover {turn:.0f} rad by angle_increment {scan.increment:g}: more than one turn."
        yield _found(error, "scan-angles", text, "Angles are in radians: multiply degrees by π / 180.")
    elif scan.excess:
        text = (
            f"Scans {name} have {scan.beams} ranges, {abs(scan.excess):.0f} {'more' if scan.excess > 0 else 'less'} "
            "than angle_min, angle_max and angle_increment say."
        )
        advice = f"{INCREMENT}; angle_min and angle_increment are used."
        yield _found(warn, "scan-angles", text, advice)


def _ranges(scan: ScanFacts) -> Iterator[Finding]:
    if not scan.beams:
        yield _found(
            error, "scan-empty", f"Scans {_name(scan)} have no ranges.", "Send one a beam, null without a reading."
        )
        return
    if problem := missing_readings(scan):
        yield _found(error, "scan-no-readings", *problem)


def missing_readings(scan: ScanFacts) -> tuple[str, str] | None:
    """Return why a scan has next to no readings, and what to do; None if it has some."""
    if scan.readings > FEW:
        return None
    if scan.zeros > 0.9:
        text, advice = "are 0", "The driver has no data: look at the motor, the baud rate and the port of the laser."
    elif scan.empty > 0.9:
        text = "are null, NaN or infinite"
        advice = f"See whether the laser is covered, off, or far from all walls; {WIDE}"
    elif scan.short > MANY_SHORT:
        text = f"are below range_min ({scan.range_min:g} m)"
        advice = "Ranges are in metres: divide millimetres by 1000; or the laser sees the robot itself."
    else:
        text = f"are outside range_min and range_max ({scan.range_min:g} to {scan.range_max:g} m)"
        advice = "Ranges are in metres: divide millimetres by 1000, centimetres by 100."
    share = "All" if scan.readings == 0.0 else percent(1.0 - scan.readings)
    return f"{share} ranges of the scans {_name(scan)} {text}.", advice


def _size(scan: ScanFacts) -> Iterator[Finding]:
    name = _name(scan)
    if 0 < scan.beams < FEWEST_BEAMS:
        text = f"Scans {name} have {scan.beams} beams: too few to localize by."
        yield _found(warn, "scan-few-beams", text, "Send 90 or more.")
    if scan.intensities:
        text = f"Scans {name} have {scan.intensities} intensities, which the cloud does not use."
        yield _found(ok, "scan-intensities", text, "Leave them out: that halves the size of a scan.")
