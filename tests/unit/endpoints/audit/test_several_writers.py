"""Several processes append to the audit log of one data folder, while its files are rotated and read."""

import subprocess
import sys
from pathlib import Path

from endpoints.audit.event import AuditEvent, AuditQuery
from endpoints.audit.files import AuditFiles

WRITERS, BATCHES, BATCH = 3, 60, 3

PROGRAM = """
import sys
from pathlib import Path
from endpoints.audit.event import AuditEvent
from endpoints.audit.files import AuditFiles

path, writer, batches, batch = Path(sys.argv[1]), sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
files = AuditFiles(path, max_size=4000, files=60)
print("ready", flush=True)
sys.stdin.readline()
for number in range(batches):
    files.append([AuditEvent(action="put_robot", user=writer, object=f"{number}/{at}") for at in range(batch)])
"""


def start(path: Path, writer: int) -> subprocess.Popen[str]:
    arguments = [str(path), str(writer), str(BATCHES), str(BATCH)]
    return subprocess.Popen(
        [sys.executable, "-c", PROGRAM, *arguments], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )


def test_no_event_of_several_processes_is_lost_repeated_or_out_of_order(tmp_path: Path) -> None:
    path = tmp_path / "audit.jsonl"
    writers = [start(path, number) for number in range(WRITERS)]
    for writer in writers:
        assert writer.stdout is not None and writer.stdout.readline() == "ready\n"
    for writer in writers:
        assert writer.stdin is not None
        writer.stdin.write("go\n")
        writer.stdin.flush()
    files = AuditFiles(path, max_size=4000, files=60)
    while any(writer.poll() is None for writer in writers):
        assert in_order(files.read(AuditQuery(), limit=10_000)), "a reader sees no gap"
    for writer in writers:
        writer.communicate(timeout=30)
        assert writer.returncode == 0
    found = files.read(AuditQuery(), limit=10_000)
    assert len(found) == WRITERS * BATCHES * BATCH
    assert in_order(found)
    for user in map(str, range(WRITERS)):
        own = [event.object for event in reversed(found) if event.user == user]
        assert own == [f"{number}/{at}" for number in range(BATCHES) for at in range(BATCH)]
    assert len(list(tmp_path.iterdir())) > 5, "files were rotated"


def in_order(events: list[AuditEvent]) -> bool:
    """Return whether the numbers of events, newest first, end with 1 and have no gap."""
    return [event.number for event in events] == list(range(len(events), 0, -1))
