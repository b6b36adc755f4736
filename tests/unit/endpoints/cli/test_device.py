import argparse
import asyncio
import json

import pytest
from starlette.responses import Response

from endpoints.cli import device, device_trial
from ppaas.errors import InvalidInput, Unavailable
from tests.support.buildings import LiftServer
from tests.support.endpoints.serving import serve

FLOORS = "?floors=L1:1,L2:2,L3:3&poll=0.1"


def try_device(*words):
    parser = argparse.ArgumentParser()
    device.configure(parser)
    return device.run(parser.parse_args(["try", *words]))


async def try_server(server, path, *words):
    async with serve(server) as port:
        return await asyncio.to_thread(try_device, f"http://127.0.0.1:{port}{path}", *words)


async def test_a_lift_is_sent_to_a_floor_and_let_go(capsys):
    server = LiftServer()
    assert await try_server(server, f"/lift{FLOORS}", "--floors", "L1,L2,L3", "--floor", "L3", "--json") == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert (lines[-1]["floor"], lines[-1]["door"]) == ("L3", "open")
    assert server.orders[-1] == {"session": device_trial.SESSION, "end": True}


async def test_a_door_is_opened_and_let_close(capsys):
    server = LiftServer()
    assert await try_server(server, "/door?poll=0.1", "--open") == 0
    assert "mode=open" in capsys.readouterr().out.splitlines()[-1]
    assert server.orders[-1] == {"session": device_trial.SESSION, "mode": "closed"}


async def test_states_are_shown_without_any_order(capsys):
    server = LiftServer()
    assert await try_server(server, "/door?poll=0.1", "--door", "--seconds", "0.3") == 0
    assert "mode=closed" in capsys.readouterr().out
    assert server.orders == []


async def test_a_device_that_does_not_obey_or_answer_is_an_error():
    server = LiftServer()
    server.lift.set_mode("fire", 0.0)
    with pytest.raises(Unavailable, match="did not obey within"):
        await try_server(server, f"/lift{FLOORS}", "--floor", "L2", "--seconds", "0.5")
    server.answer = Response(status_code=503)
    with pytest.raises(Unavailable, match="with 503"):
        await try_server(server, f"/lift{FLOORS}", "--floor", "L2", "--seconds", "5")


@pytest.mark.parametrize(
    "words", [("sim:", "--floor", "L9"), ("sim:", "--floors", "L1,L1"), ("sim:", "--floors", ","), ("ftp://h",)]
)
def test_wrong_words_are_refused(words):
    with pytest.raises(InvalidInput):
        try_device(*words)
