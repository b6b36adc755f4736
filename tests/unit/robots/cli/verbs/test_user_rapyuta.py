import hashlib
from pathlib import Path

from tests.support.cloud.command_line import CommandLine


async def test_the_password_for_robots_is_set_and_removed(ppaas: CommandLine, tmp_path: Path) -> None:
    file = tmp_path / "robots"
    file.write_text("battery staple\n")
    ended = await ppaas("user", "rapyuta", "ann", "--password-file", str(file), user="admin")
    assert ended.rows[1][:2] == ["ann", "user"]
    digest = hashlib.sha256(b"battery staple").hexdigest()
    assert (await ppaas.services.accounts.rapyuta.sign_in("ann", digest))[0].id == "ann"
    assert (await ppaas("user", "rapyuta", "ann", "--off", user="admin")).status == 0
    assert ppaas.services.store.user("ann").rapyuta_hash == ""


async def test_only_an_administrator_sets_it(ppaas: CommandLine) -> None:
    ended = await ppaas("user", "rapyuta", "ann", stdin="battery staple\n")
    assert ended.err.startswith("ppaas: not-permitted: ")
