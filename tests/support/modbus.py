"""PLC with a lift (unit 1) and a door (unit 2): the server of pymodbus, with simulated devices behind it."""

import socket
from contextlib import asynccontextmanager

from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

from ppaas.buildings.doors.simulated import SimulatedDoor
from ppaas.buildings.doors.states import DOOR_MODES, DoorRequest
from ppaas.buildings.lifts.simulated import SimulatedLift
from ppaas.buildings.lifts.states import EndSession, LiftRequest
from ppaas.clock import epoch
from tests.support.buildings import LEVELS, QUICK

READ_INPUTS, WRITE_REGISTERS = 4, 16
FLOORS = list(LEVELS)


class Plc:
    """Registers from 100 on: inputs with the state, holding registers with the order."""

    def __init__(self) -> None:
        self.lift = SimulatedLift("A", LEVELS, epoch(), QUICK)
        self.door = SimulatedDoor("L1", "main", epoch(), 0.1)
        self.mode = 2
        self.counts = True
        self.reads = 0
        self.counters: list[int] = []
        self._counter = 1
        self.port = 0

    async def lift_accessed(self, function, _start, _address, _count, registers, values):
        if function == WRITE_REGISTERS:
            wanted, floor, _doors, counter = values
            self.counters.append(counter)
            if wanted:
                self.lift.request(LiftRequest("A", "plc", FLOORS[floor]), epoch())
            else:
                self.lift.end(EndSession("A", "plc"), epoch())
        elif function == READ_INPUTS:
            state = self.lift.state(epoch())
            door = ("closed", "moving", "open").index(state.door)
            motion = ("stopped", "up", "down").index(state.motion)
            self.reads += 1
            self._counter += self.counts
            state_words = [FLOORS.index(state.floor), door, motion, self.mode, int(bool(state.session)), self._counter]
            registers[:6] = state_words

    async def door_accessed(self, function, _start, _address, _count, registers, values):
        if function == WRITE_REGISTERS:
            self.door.request(DoorRequest("L1", "main", "plc", "open" if values[0] else "closed"), epoch())
        elif function == READ_INPUTS:
            registers[:2] = [DOOR_MODES.index(self.door.state(epoch()).mode), 0]

    @asynccontextmanager
    async def serving(self):
        """Serve on the port that it had before, or a free one."""
        if not self.port:
            with socket.create_server(("127.0.0.1", 0)) as listener:
                self.port = listener.getsockname()[1]
        devices = [_device(1, self.lift_accessed), _device(2, self.door_accessed)]
        server = ModbusTcpServer(devices, address=("127.0.0.1", self.port))
        await server.serve_forever(background=True)
        try:
            yield self
        finally:
            await server.shutdown()


def _device(unit, accessed):
    bits = [SimData(100, count=1, values=False, datatype=DataType.BITS)]
    words = [SimData(100, count=8, values=0, datatype=DataType.REGISTERS)]
    return SimDevice(unit, (bits, bits, words, words), use_bit_addressing=True, action=accessed)
