"""Our client against pymodbus' server, and mbpoll against our emulator: values, word orders and exceptions agree."""
import os
import pathlib
import pty
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import termios
import threading
import time
import tty
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests/support"))
from motor_log import motor_log  # noqa: E402

PROBE = os.environ.get("MODBUS_PROBE", str(ROOT / "build/release/tests/modbus_probe"))
EMULATOR = os.environ.get("MODBUS_EMULATOR", str(ROOT / "build/release/bin/tactor-emulate-modbus"))
PATIENCE = 120  # s, for anything that takes a moment on an idle machine

# Written in the words of pymodbus, so that neither side's idea of an order is taken from the other.
SERVER = r"""
import asyncio, sys
from pymodbus.constants import Endian
from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext, ModbusSlaveContext
from pymodbus.payload import BinaryPayloadBuilder
from pymodbus.server import StartAsyncSerialServer, StartAsyncTcpServer
try:
    from pymodbus.framer import FramerType
    rtu = FramerType.RTU
except ImportError:  # before 3.7
    from pymodbus.transaction import ModbusRtuFramer as rtu

def words(add, byteorder, wordorder):
    builder = BinaryPayloadBuilder(byteorder=byteorder, wordorder=wordorder)
    add(builder)
    return builder.to_registers()

B, L = (Endian.BIG, Endian.LITTLE) if hasattr(Endian, "BIG") else (Endian.Big, Endian.Little)
values = [0] * 200
def put(at, add, byteorder=B, wordorder=B):
    registers = words(add, byteorder, wordorder)
    values[at:at + len(registers)] = registers
put(0, lambda b: b.add_32bit_int(-123456789))
put(2, lambda b: b.add_32bit_int(-123456789), B, L)
put(4, lambda b: b.add_32bit_uint(4012345678))
put(6, lambda b: b.add_32bit_uint(4012345678), B, L)
put(8, lambda b: b.add_32bit_float(3.1415927))
put(10, lambda b: b.add_32bit_float(-2.5e-6), B, L)
put(12, lambda b: b.add_16bit_int(-321))
put(13, lambda b: b.add_16bit_uint(54321))
# An address on the line is one less than in a block.
store = ModbusSlaveContext(hr=ModbusSequentialDataBlock(1, values), ir=ModbusSequentialDataBlock(1, [4] * 16))
context = ModbusServerContext(slaves={7: store}, single=False)

async def main():
    kind, where = sys.argv[1], sys.argv[2]
    print("ready", flush=True)
    if kind == "tcp":
        await StartAsyncTcpServer(context, address=("127.0.0.1", int(where)))
    else:
        await StartAsyncSerialServer(context, framer=rtu, port=where, baudrate=19200, parity="N", timeout=0.1)

asyncio.run(main())
"""
PROFILE = """line: {unit: 7, baud: 19200, parity: even, response_timeout: %s}
registers:
  int32:        {address: 0, type: int32, access: read_write}
  int32_low:    {address: 2, type: int32, access: read, word_order: low_first}
  uint32:       {address: 4, type: uint32, access: read}
  uint32_low:   {address: 6, type: uint32, access: read, word_order: low_first}
  float32:      {address: 8, type: float32, access: read}
  float32_low:  {address: 10, type: float32, access: read, word_order: low_first}
  int16:        {address: 12, type: int16, access: read}
  uint16:       {address: 13, type: uint16, access: read}
  input:        {address: 3, type: uint16, access: read, function: 4}
  by_6:         {address: 20, type: int16, access: read_write, function: [3, 6]}
  by_16:        {address: 22, type: float32, access: read_write, function: [3, 16], word_order: low_first}
  position:     {address: 40, type: int32, access: read, scale: 1 um}
  effort:       {address: 42, type: int32, access: read_write, scale: 1 mN, function: 23}
  beyond:       {address: 5000, type: uint16, access: read}
identify:
  - {register: uint16, value: 54321}
cycle: combined
axes:
  - {position: position, effort: effort, effort_max: 1 N, speed_max: 1 m/s, jump_tolerance: 1 mm}
"""
# A device that takes one word at a time: it answers every other write with an exception, and tells what it was given.
ONE_WORD_SERVER = r"""
import asyncio, sys
from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext, ModbusSlaveContext
from pymodbus.server import StartAsyncTcpServer

class OneWord(ModbusSlaveContext):
    def validate(self, function, address, count=1):
        return function in (3, 6) and any(a <= address and address + count <= b for a, b in ((1, 2), (10, 12), (20, 22)))
    def setValues(self, function, address, values):
        if values[0] != self.getValues(3, address)[0]:
            print("wrote", function, address, *values, flush=True)
        super().setValues(function, address, values)

store = OneWord(hr=ModbusSequentialDataBlock(1, [0, 7] + 8 * [0] + [0, 25000] + 20 * [0]))

async def main():
    print("ready", flush=True)
    await StartAsyncTcpServer(ModbusServerContext(slaves={7: store}, single=False), address=("127.0.0.1", int(sys.argv[1])))

asyncio.run(main())
"""
ONE_WORD_PROFILE = """line: {unit: 7, response_timeout: 2 s}
registers:
  id:        {address: 1, type: uint16, access: read}
  position:  {address: 10, type: int32, access: read, scale: 1 um}
  direction: {address: 20, type: uint16, access: write, function: 6}
  force:     {address: 21, type: uint16, access: write, scale: 1 mN, function: 6}
identify:
  - {register: id, value: 7}
each_cycle: {direction: 0}
axes:
  - {position: position, effort: force, effort_max: 5 N, speed_max: 1 m/s, jump_tolerance: 1 mm, effort_as: magnitude,
     sign: {register: direction, positive: 1, negative: 2, zero: 0}}
"""
# A motor whose force has the type and the word order of a test.
FORCE_PROFILE = """word_order: %s
registers:
  position: {address: 10, type: int32, access: read, scale: 1 um}
  force:    {address: 28, access: read_write, %s}
identify:
  - {register: position, min: -1 m, max: 1 m}
fence: {address: 10, count: 1}
axes:
  - {position: position, effort: force, effort_max: 5 N, speed_max: 1 m/s, jump_tolerance: 1 mm}
"""
EXPECTED = {"int32": -123456789, "int32_low": -123456789, "uint32": 4012345678, "uint32_low": 4012345678,
            "float32": 3.1415927, "float32_low": -2.5e-6, "int16": -321, "uint16": 54321, "input": 4}


def free_port():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


class Peer(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tactor-modbus-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def start(self, *command, **options):
        process = subprocess.Popen([*map(str, command)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)

        def end():
            if process.poll() is None:
                process.kill()
            process.communicate()
        self.addCleanup(end)
        return process


class PymodbusServer(Peer):
    def probe(self, endpoint, *writes, text=PROFILE % "2 s"):
        """Asks until the server listens; what the probe read, by name."""
        profile = self.folder / "peer.yaml"
        profile.write_text(text)
        end = time.monotonic() + PATIENCE
        while True:
            result = subprocess.run([PROBE, endpoint, profile, *writes], capture_output=True, text=True, timeout=PATIENCE,
                                    check=False)
            self.assertNotEqual(result.returncode, 2, result.stderr)
            if not result.stdout.startswith("connect error"):
                return dict(line.split(" ", 1) for line in result.stdout.splitlines())
            self.assertLess(time.monotonic(), end, result.stdout)
            time.sleep(0.2)

    def check(self, endpoint):
        values = self.probe(endpoint)
        for name, value in EXPECTED.items():
            with self.subTest(register=name):
                self.assertAlmostEqual(float(values[name]), value, delta=abs(value) * 1e-6)
        # An address that the server has not.
        self.assertIn("error exception exception 2", values["beyond"])
        values = self.probe(endpoint, "int32=-7", "by_6=-1234", "by_16=-0.375")
        self.assertEqual(float(values["int32"]), -7)
        self.assertEqual(float(values["by_6"]), -1234)
        self.assertEqual(float(values["by_16"]), -0.375)
        self.assertEqual(float(values["combined"]), -7)
        self.assertEqual(float(self.probe(endpoint)["effort"]), 21)

    def test_a_device_that_is_written_by_function_6_alone_is_driven(self):
        port = free_port()
        server = self.start("/usr/bin/python3", "-c", ONE_WORD_SERVER, port)
        self.assertEqual(server.stdout.readline(), "ready\n")
        # It has three reads of its own lengths, of which a fourth can be told by its function alone.
        text = ONE_WORD_PROFILE + "fence: {address: 10, count: 1, function: 4}\n"
        values = self.probe(f"tcp:127.0.0.1:{port}", "--cycle", "-1.5", text=text)
        self.assertEqual(values, {"q": "0.025"})
        server.kill()
        wrote = server.stdout.read().splitlines()
        # The two registers lie side by side, and are never written at once. In the end both are back at zero.
        self.assertEqual(wrote, ["wrote 6 20 2", "wrote 6 21 1500", "wrote 6 20 0", "wrote 6 21 0"])

    def test_over_tcp(self):
        port = free_port()
        server = self.start("/usr/bin/python3", "-c", SERVER, "tcp", port)
        self.assertEqual(server.stdout.readline(), "ready\n")
        self.check(f"tcp:127.0.0.1:{port}")

    def test_over_a_serial_line(self):
        # Two pseudo-terminals, joined by a thread that carries bytes from one to the other.
        a, a_end = pty.openpty()
        b, b_end = pty.openpty()
        for file in (a, a_end, b, b_end):
            tty.setraw(file, termios.TCSANOW)

        def carry(source, sink):
            try:
                while data := os.read(source, 256):
                    os.write(sink, data)
            except OSError:
                pass
        for source, sink in ((a, b), (b, a)):
            threading.Thread(target=carry, args=(source, sink), daemon=True).start()
        server = self.start("/usr/bin/python3", "-c", SERVER, "rtu", os.ttyname(a_end))
        self.assertEqual(server.stdout.readline(), "ready\n")
        time.sleep(1)
        self.check("rtu:" + os.ttyname(b_end))


@unittest.skipIf(shutil.which("mbpoll") is None, "mbpoll is not installed")
class Mbpoll(Peer):
    def emulator(self, *line, profile=ROOT / "devices/modbus/profiles/iris_orca.yaml"):
        process = self.start(EMULATOR, profile, *line, stdin=subprocess.PIPE)
        ready = process.stdout.readline()
        self.assertTrue(ready.startswith("ready "), ready)
        return ready.split()[1]

    def mbpoll(self, endpoint, *arguments):
        kind, rest = endpoint.split(":", 1)
        if kind == "tcp":
            host, port = rest.split(":")
            where = ["-m", "tcp", "-p", port]
            target = [host]
        else:
            where = ["-m", "rtu", "-b", "19200", "-P", "even"]
            target = [rest]
        values = arguments[arguments.index("--") + 1:] if "--" in arguments else ()
        options = arguments[:arguments.index("--")] if "--" in arguments else arguments
        return subprocess.run(["mbpoll", "-0", *([] if values else ["-1"]), "-a", "1", "-o", "5", *where, *options, "--", *target,
                               *values],
                              capture_output=True, text=True, timeout=PATIENCE, check=False)

    def read(self, endpoint, *arguments):
        result = self.mbpoll(endpoint, *arguments)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        return [float(v) for v in re.findall(r"^\[\d+\]:\s+(-?[\d.]+)", result.stdout, re.MULTILINE)]

    def write(self, endpoint, *arguments):
        result = self.mbpoll(endpoint, *arguments)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)

    def test_the_force_that_is_written_acts_in_both_word_orders(self):
        # The words of -1500 and of -1.5 (bfc00000), high word first.
        for kind, value, register, words in (("int", "-1500", "type: int32, scale: 1 mN", [0xffff, 0xfa24]),
                                             ("float", "-1.5", "type: float32, scale: 1 N", [0xbfc0, 0])):
            for order, flags in (("low_first", ()), ("high_first", ("-B",))):
                with self.subTest(type=kind, words=order):
                    profile, log = self.folder / "force.yaml", self.folder / f"{kind}_{order}.log"
                    profile.write_text(FORCE_PROFILE % (order, register))
                    endpoint = self.emulator("--tcp", "0", "--log", log, profile=profile)
                    self.write(endpoint, "-t", f"4:{kind}", *flags, "-r", "28", "--", value)
                    self.assertEqual(self.read(endpoint, "-t", f"4:{kind}", *flags, "-r", "28", "-c", "1"), [float(value)])
                    self.assertEqual(self.read(endpoint, "-t", "4", "-r", "28", "-c", "2"),
                                     words if order == "high_first" else words[::-1])
                    # The motor has it, and nothing else but zero before it.
                    end = time.monotonic() + PATIENCE
                    while not (forces := [row.force_N for row in motor_log(log)]) or forces[-1] != -1.5:
                        self.assertLess(time.monotonic(), end, forces[-5:])
                        time.sleep(0.05)
                    self.assertEqual(set(forces), {0, -1.5})

    def check(self, endpoint):
        self.assertEqual(self.read(endpoint, "-t", "4", "-r", "408", "-c", "1"), [6])
        # mbpoll's 32-bit integers have the low word first unless -B says otherwise.
        self.assertEqual(self.read(endpoint, "-t", "4:int", "-r", "406", "-c", "1"), [4711])
        position, = self.read(endpoint, "-t", "4:int", "-r", "342", "-c", "1")
        self.assertTrue(0 < position < 150_000, position)
        # Function 6 and function 16.
        for arguments in (["-r", "163", "--", "250"], ["-r", "143", "--", "77"]):
            self.write(endpoint, "-t", "4", *arguments)
        self.assertEqual(self.read(endpoint, "-t", "4", "-r", "163", "-c", "1"), [250])
        self.assertEqual(self.read(endpoint, "-t", "4", "-r", "143", "-c", "1"), [77])
        self.write(endpoint, "-t", "4:int", "-r", "28", "--", "-1500")
        self.assertEqual(self.read(endpoint, "-t", "4:int", "-r", "28", "-c", "1"), [-1500])
        # -1500 is fffffa24 in hexadecimal; this motor has its low word first.
        self.assertEqual(self.read(endpoint, "-t", "4", "-r", "28", "-c", "2"), [0xfa24, 0xffff])
        # Input registers show the same, and what is not there is an exception.
        self.assertEqual(self.read(endpoint, "-t", "3", "-r", "408", "-c", "1"), [6])
        result = self.mbpoll(endpoint, "-t", "4", "-r", "5000", "-c", "1")
        self.assertIn("Illegal data address", result.stdout + result.stderr)

    def test_over_tcp(self):
        self.check(self.emulator("--tcp", "0"))

    def test_over_a_serial_line(self):
        self.check(self.emulator("--pty"))


if __name__ == "__main__":
    unittest.main()
