import os
import subprocess
import sys

from engine.processes.instances import folder_of, instance_name, is_dead, sweep_stale


def name_of_a_dead_process() -> str:
    code = "from engine.processes.instances import instance_name; print(instance_name())"
    return subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout.strip()


def test_folder_of_a_dead_process_is_removed_with_its_content(tmp_path):
    dead = folder_of(name_of_a_dead_process(), tmp_path)
    (dead / "map").mkdir(parents=True)
    (dead / "map" / "grid.npy").write_bytes(b"x")
    assert sweep_stale(tmp_path) == [dead]
    assert not dead.exists()


def test_the_folder_of_a_living_process_stays(tmp_path):
    mine = folder_of(instance_name(), tmp_path)
    mine.mkdir()
    assert sweep_stale(tmp_path) == []
    assert mine.exists()


def test_reused_process_id_does_not_keep_the_folder(tmp_path):
    namespace, pid, started = instance_name().split("-")
    earlier = folder_of(f"{namespace}-{pid}-{int(started) - 1}", tmp_path)
    earlier.mkdir()
    assert int(pid) == os.getpid()
    assert sweep_stale(tmp_path) == [earlier]


def test_a_zombie_is_dead():
    code = "from engine.processes.instances import instance_name; print(instance_name())"
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as process:
        name = process.stdout.read().strip()
        os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
        assert is_dead(name)
    assert not is_dead(instance_name())


def test_other_folders_and_those_of_another_pid_namespace_are_kept(tmp_path):
    _, pid, _ = instance_name().split("-")
    others = [tmp_path / "ppaas-notes", tmp_path / "sem.x", tmp_path / f"ppaas-1-{pid}-1"]
    for folder in others:
        folder.mkdir()
    assert sweep_stale(tmp_path) == []
    assert all(folder.exists() for folder in others)


def test_semaphores_of_a_dead_process_are_removed(tmp_path):
    _, pid, _ = instance_name().split("-")
    dead = tmp_path / f"sem.ppaas-{name_of_a_dead_process()}-x_y1"
    kept = [tmp_path / f"sem.ppaas-{instance_name()}-xyz", tmp_path / f"sem.ppaas-1-{pid}-1-xyz", tmp_path / "sem.mp-x"]
    for file in (dead, *kept):
        file.write_bytes(b"x")
    assert sweep_stale(tmp_path) == [dead]
    assert not dead.exists()
    assert all(file.exists() for file in kept)
