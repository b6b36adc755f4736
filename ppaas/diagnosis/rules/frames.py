"""Rules on frames: unknown frames of lasers, several parents, loops, odometry of another frame."""

from collections.abc import Iterator

from ppaas.diagnosis.observations.facts import FrameFacts, Observations
from ppaas.diagnosis.rules.finding import Finding, error
from ppaas.diagnosis.rules.words import names, nearest
from ppaas.nodes import topics
from ppaas.nodes.frames import MAP, SCAN_ODOM, prefixed


def frames(seen: Observations) -> Iterator[Finding]:
    """Yield what is wrong with the frames of the robot."""
    parents = {frame.name: frame.parents[-1] for frame in seen.frames if frame.parents}
    loop = _loop(parents)
    if loop:
        text = f"Transforms close a loop: {' → '.join(loop)}."
        yield error("frames-loop", text, "Each frame has one parent, up to 'map': turn one transform round.", "tf")
    for frame in seen.frames:
        yield from _one(frame)
    for scan in seen.scans:
        yield from _laser(seen, parents, scan.frame)
    yield from _odometry(seen, parents)


def _one(frame: FrameFacts) -> Iterator[Finding]:
    if frame.alternates:
        text = f"Two programs publish the transform of '{frame.name}': it jumps to and fro."
        advice = "Stop one of them: for example publish_tf of the base if an EKF publishes it, or amcl on the robot."
        yield error("frames-two-senders", text, advice, "tf")
    elif len(set(frame.parents) - {SCAN_ODOM}) > 1:  # odometry may have come since
        text = f"Frame '{frame.name}' was given several parents: {names(frame.parents)}."
        yield error("frames-two-parents", text, "Let one program publish it, below one parent.", "tf")


def _laser(seen: Observations, parents: dict[str, str], name: str) -> Iterator[Finding]:
    frame = prefixed(seen.prefix, name) if prefixed(seen.prefix, name) in parents else name
    if not frame or frame == seen.base or _root(parents, frame) == _root(parents, seen.base):
        return
    known = sorted({*parents, *parents.values()})
    if frame in known:
        text = f"The frame of the laser, '{name}', is not connected with '{seen.base}'."
        advice = f"Publish the transform '{seen.base}' → '{_root(parents, frame)}' once on 'tf_static'."
        yield error("frames-laser-apart", f"{text} Its scans are not used.", advice, topics.SCAN.name)
        return
    text = f"The frame of the laser, '{name}', has no transform to '{seen.base}': its scans are not used."
    alike = nearest(name, known)
    hint = f" Did you mean '{alike}'?" if alike else ""
    advice = (
        f"Frames that exist: {names(known)}.{hint} Publish '{seen.base}' → '{name}' once on 'tf_static', upload a URDF "
        "that has this link, or send scans with a frame that exists."
    )
    yield error("frames-laser-unknown", text, advice, topics.SCAN.name)


def _odometry(seen: Observations, parents: dict[str, str]) -> Iterator[Finding]:
    child, parent = seen.motion.child, seen.motion.parent
    if not child:
        return
    if _root(parents, child) != _root(parents, seen.base) and child != seen.base:
        text = f"Odometry moves the frame '{child}' (child_frame_id), which is not connected with '{seen.base}'."
        advice = (
            f"Send child_frame_id '{seen.base}', or publish the transform between '{child}' and '{seen.base}' on "
            "'tf_static', or set base_frame_id of amcl in the robot file."
        )
        yield error("frames-odom-child", text, advice, topics.ODOM.name)
    if parent in (seen.base, child):
        text = f"Odometry has the frame '{parent}' as header.frame_id, which is the robot itself."
        yield error("frames-odom-parent", text, "header.frame_id is the fixed frame: send 'odom'.", topics.ODOM.name)
    elif parent == MAP:
        text = "Odometry has 'map' as header.frame_id: that frame belongs to localization."
        yield error("frames-odom-parent", text, "Send 'odom' as header.frame_id.", topics.ODOM.name)


def _root(parents: dict[str, str], frame: str) -> str:
    """Return the highest frame above a frame, or where a loop closes."""
    seen = [frame]
    while (above := parents.get(seen[-1])) is not None and above not in seen:
        seen.append(above)
    return seen[-1]


def _loop(parents: dict[str, str]) -> list[str]:
    """Return the frames of a loop, the first one again at its end; empty if there is none."""
    for start in parents:
        chain = [start]
        while (above := parents.get(chain[-1])) is not None:
            if above in chain:
                return [*chain[chain.index(above) :], above]
            chain.append(above)
    return []
