"""The loop of a driver, its sources, and what it shows, with a robot that answers each command at once."""

import asyncio
import json

import pytest

from ppaas.errors import Conflict, InvalidInput
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.operators.teleoperation import DriverRequest, TeleopCommand, TeleopState
from robots.cli.driving.drive_loop import drive_by
from robots.cli.driving.keyboard import Keyboard, status_line
from robots.cli.driving.lines import Lines, show_state
from robots.client.teleop import Hand


class Robot:
    """Client of a robot that obeys, until another takes over after a number of commands."""

    def __init__(self, taken_after: int = 1_000_000) -> None:
        self.commands: list[TeleopCommand] = []
        self.hand = Hand(self)  # type: ignore[arg-type]
        self.driver = self.hand.id
        self.taken_after = taken_after

    async def publish(self, _: str, message: Message) -> None:
        assert isinstance(message, TeleopCommand)
        self.commands.append(message)
        if len(self.commands) == self.taken_after:
            self.driver = "another"
        number = len(self.commands)
        state = TeleopState(Header(), number, self.driver, "bob", "driving", command=number, linear=message.linear)
        state.max_linear, state.max_angular = 0.4, 1.0
        self.hand.hear(state)

    async def drive(self, source: Keyboard | Lines) -> None:
        await self.hand.begin()
        async with asyncio.timeout(10.0):
            await drive_by(self.hand, source, lambda _: None)

    @property
    def moved(self) -> list[tuple[float, float]]:
        return [(each.linear, each.angular) for each in self.commands if each.enable]


async def test_keys_drive_at_parts_of_the_speeds_of_the_robot_and_it_is_let_go_between_them() -> None:
    robot, keyboard = Robot(), Keyboard(0.5)
    keyboard.press("i")
    driving = asyncio.create_task(robot.drive(keyboard))
    while not robot.moved:
        await asyncio.sleep(0)
    keyboard.press("k")
    while robot.commands[-1].enable:
        await asyncio.sleep(0)
    keyboard.press("\x1b")
    await driving
    assert set(robot.moved) == {(0.2, 0.0)}
    assert robot.commands[-1].request == DriverRequest.LEAVE


@pytest.mark.parametrize(("keys", "request_"), [("g", "give back"), ("\x03", "leave"), ("", "leave")])
async def test_a_terminal_ends_driving_by_a_key_and_when_it_hangs_up(keys: str, request_: str) -> None:
    robot, keyboard = Robot(), Keyboard(0.5)
    keyboard.press(keys)
    await robot.drive(keyboard)
    assert robot.commands[-1].request == request_


async def test_a_driver_whom_another_replaces_ends_with_the_name() -> None:
    robot = Robot(taken_after=3)
    with pytest.raises(Conflict, match="bob has taken over"):
        await robot.drive(Keyboard(0.5))


async def test_lines_drive_for_their_time_and_the_last_one_is_driven_to_its_end() -> None:
    robot, lines = Robot(), Lines()
    lines.take(b'{"linear": 0.3, "angular": -0.1, "seconds": 0.1}\n')
    lines.take(b"")
    await robot.drive(lines)
    assert set(robot.moved) == {(0.3, -0.1)}
    assert robot.commands[-1].request == DriverRequest.LEAVE


async def test_a_line_gives_the_robot_back_and_one_of_no_seconds_lets_go() -> None:
    robot, lines = Robot(), Lines()
    lines.take(b'{"linear": 0.3, "seconds": 1.0}')
    lines.take(b'{"seconds": 0}')
    driving = asyncio.create_task(robot.drive(lines))
    while len(robot.commands) < 3:
        await asyncio.sleep(0)
    lines.take(b'{"request": "give back"}')
    await driving
    assert robot.moved == []
    assert robot.commands[-1].request == DriverRequest.GIVE_BACK


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (b"forward\n", "is not valid"),
        (b'{"linaer": 0.3}', "linaer"),
        (b'{"linear": "fast"}', "linear"),
        (b'{"seconds": 5}', "0 to 1 seconds, not 5"),
        (b'{"seconds": -1}', "not -1"),
        (b'{"request": "fly"}', "'fly'"),
    ],
)
async def test_a_line_that_is_not_valid_ends_driving_with_an_error(line: bytes, said: str) -> None:
    robot, lines = Robot(), Lines()
    lines.take(line)
    with pytest.raises(InvalidInput, match=said):
        await robot.drive(lines)
    assert robot.moved == []


async def test_the_line_of_a_terminal_shows_what_the_robot_does() -> None:
    robot = Robot()
    assert status_line("tb1", robot.hand, 0.5) == "tb1: asking for the robot"
    await robot.hand.begin()
    await robot.hand.drive(0.25)
    line = status_line("tb1", robot.hand, 0.5)
    assert line.startswith("tb1  +0.25 m/s  +0.00 rad/s  speed 50%  round trip 0 ms  driving")
    assert robot.hand.state is not None
    robot.hand.state.mode, robot.hand.state.text = "locked", "commands came\x1b[2J 0.4 s late"
    line = status_line("tb1", robot.hand, 0.5)
    assert line.endswith("let go, then press again") and "\x1b" not in line
    robot.hand.state.mode = "blocked"
    assert status_line("tb1", robot.hand, 0.5).endswith("stopped: something is in the way")


async def test_a_state_is_a_line_of_json(capsys: pytest.CaptureFixture[str]) -> None:
    robot = Robot()
    show_state(robot.hand)
    assert capsys.readouterr().out == ""
    await robot.hand.begin()
    show_state(robot.hand)
    assert json.loads(capsys.readouterr().out)["mode"] == "driving"
