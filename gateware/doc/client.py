#!/usr/bin/env python3
"""A host for the gateware, written from protocol.md alone: python3 client.py PORT [--address N]

It tests a board: INFO, RESET, digests, refusals, a focus, a circle played from the board's store, the watchdog, MUTE.
Each line of its report is one statement of the document. It exits with 0 if all hold. Begin without transducers: it
switches the outputs on for some seconds. It needs only Python's standard library, and opens the port raw, so it runs on
Linux and other Unix systems.
"""

import argparse
import math
import os
import select
import sys
import termios
import time
import tty
import zlib

INFO, STATUS, ENABLE, MUTE, RESET, DIGEST = 0x01, 0x02, 0x03, 0x04, 0x06, 0x07
PHASES, FRAME, PLAY, STOP = 0x10, 0x11, 0x20, 0x21
ENVELOPE, RATE, SILENCER, WIDTHS, CALIBRATION = 0x30, 0x31, 0x32, 0x33, 0x34
OK, CRC, LENGTH, BUSY, UNKNOWN, ARGUMENT, STATE = range(7)
ENABLED, TRIPPED, PLAYING, PRESSED, ON, WAITING, STOPPED, FOLLOWS = (1 << bit for bit in range(8))
BROADCAST = 0xFF
SLOT, TABLE_ENVELOPE, TABLE_WIDTHS, TABLE_CALIBRATION = range(4)

# For the simulated gateware, which is several times slower than a board, and for USB adapters.
PATIENCE = 20.0
SILENCE = 0.3


def cobs_encode(data):
    out, code, n = bytearray([0]), 0, 1
    for i, byte in enumerate(data):
        if byte != 0:
            out.append(byte)
            n += 1
        if byte == 0 or (n == 255 and i + 1 < len(data)):
            out[code] = n
            code, n = len(out), 1
            out.append(0)
    out[code] = n
    return bytes(out)


def cobs_decode(data):
    out, i = bytearray(), 0
    while i < len(data):
        code = data[i]
        if code == 0 or i + code > len(data):
            raise ValueError("COBS ends within a block")
        out += data[i + 1:i + code]
        i += code
        if code < 255 and i < len(data):
            out.append(0)
    return bytes(out)


def packet(kind, address, seq, arguments=b"", payload=b""):
    """A packet's bytes on the line; `arguments` are padded with zeros."""
    body = bytes([kind, address, seq]) + arguments.ljust(4, b"\0") + payload
    return cobs_encode(body + zlib.crc32(body).to_bytes(4, "little")) + b"\0"


def crc16_genibus(data):
    register = 0xFFFF
    for byte in data:
        register ^= byte << 8
        for _ in range(8):
            register = (register << 1 ^ (0x1021 if register & 0x8000 else 0)) & 0xFFFF
    return register ^ 0xFFFF


class Reply:
    """A reply of 16 bytes with a valid CRC."""

    def __init__(self, body):
        self.body = body
        self.kind, self.address, self.seq, self.result, self.flags = body[:5]
        self.slot, self.framing = body[5], body[6]
        self.good = int.from_bytes(body[7:9], "little")
        self.spoiled = int.from_bytes(body[9:11], "little")
        self.periods = self.digest = int.from_bytes(body[11:15], "little")


class Board:
    """A device at an address on a serial port."""

    def __init__(self, port, address):
        self.file = os.open(port, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.file)
        settings = termios.tcgetattr(self.file)
        settings[4] = settings[5] = termios.B2000000
        settings[2] |= termios.CLOCAL | termios.CREAD
        settings[2] &= ~termios.CRTSCTS
        termios.tcsetattr(self.file, termios.TCSANOW, settings)
        termios.tcflush(self.file, termios.TCIOFLUSH)
        self.address, self.seq, self.received = address, 0, bytearray()
        # Ends any packet that the device had begun to receive; its answer is ignored.
        self.write(b"\0")
        self.read_packet(SILENCE)
        self.received.clear()

    def write(self, data):
        while data:
            data = data[os.write(self.file, data):]

    def read_packet(self, patience):
        """The next packet between two zeros, decoded, or None."""
        end = time.monotonic() + patience
        while True:
            raw, zero, rest = self.received.partition(b"\0")
            if zero:
                self.received = rest
                if raw:
                    return cobs_decode(raw)
                continue
            if not select.select([self.file], [], [], max(0.0, end - time.monotonic()))[0]:
                return None
            data = os.read(self.file, 4096)
            if not data:
                raise OSError("the port has been closed")
            self.received += data

    def read_reply(self, patience=PATIENCE):
        data = self.read_packet(patience)
        if data is None:
            return None
        if len(data) != 20 or zlib.crc32(data[:16]) != int.from_bytes(data[16:], "little"):
            raise ValueError(f"this is no reply of 16 bytes and their CRC-32: {data.hex(' ')}")
        return Reply(data[:16])

    def send(self, kind, arguments=b"", payload=b"", address=None):
        self.seq = (self.seq + 1) % 256
        self.write(packet(kind, self.address if address is None else address, self.seq, arguments, payload))

    def ask(self, kind, arguments=b"", payload=b""):
        """Sends a packet and waits for its own reply."""
        self.send(kind, arguments, payload)
        reply = self.read_reply()
        if reply is None:
            raise ValueError(f"no reply to a packet of type 0x{kind:02X} within {PATIENCE:.0f} s")
        if (reply.kind, reply.address, reply.seq) != (kind | 0x80, self.address, self.seq):
            raise ValueError(f"the reply to type 0x{kind:02X}, seq {self.seq} is {reply.body.hex(' ')}")
        return reply

    def digest(self, table, slot=0):
        reply = self.ask(DIGEST, bytes([table, slot]))
        if reply.result != OK:
            raise ValueError(f"DIGEST of table {table}, slot {slot}: result {reply.result}")
        return reply.digest

    def wait_for(self, mask, value, what):
        """Polls STATUS until these flags have this value."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            reply = self.ask(STATUS)
            if reply.flags & mask == value:
                return reply
        raise ValueError(f"{what}: flags are still 0x{reply.flags:02X} after {PATIENCE:.0f} s")


class Report:
    def __init__(self):
        self.failed = 0

    def holds(self, statement, true, found=None):
        self.failed += not true
        note = "" if true or found is None else f" (found {found})"
        print(f"{'ok  ' if true else 'FAIL'}  {statement}{note}", flush=True)


# A 16 x 16 array: channel = row * 16 + column, x to the right, y upwards. Spacing of elements and speed of sound of air
# at 20 °C.
PITCH, SOUND = 0.010, 343.0


def focus(x, y, z, carrier, amplitude):
    """256 pairs (phase, amplitude) that focus on (x, y, z); metres, array in z = 0."""
    distances = []
    for row in range(16):
        for column in range(16):
            dx, dy = (column - 7.5) * PITCH - x, (row - 7.5) * PITCH - y
            distances.append(math.sqrt(dx * dx + dy * dy + z * z))
    # A nearer element is delayed by the difference of distances.
    farthest = max(distances)
    delays = [(farthest - distance) * carrier / SOUND for distance in distances]
    return b"".join(bytes([round(256 * delay) % 256, amplitude]) for delay in delays)


def examples(report):
    """The document's examples, without a board."""
    report.holds("CRC-32 of 123456789 is 0xCBF43926", zlib.crc32(b"123456789") == 0xCBF43926)
    known = {
        "INFO, address 0, seq 1": (packet(INFO, 0, 1), "02 01 02 01 01 01 01 05 7A FD 7B 06 00"),
        "ENABLE, address 2, seq 7, watchdog 125": (packet(ENABLE, 2, 7, b"\x7d"), "05 03 02 07 7D 01 01 05 B9 C0 39 CA 00"),
        "MUTE, broadcast, seq 0": (packet(MUTE, BROADCAST, 0), "03 04 FF 01 01 01 01 05 A1 50 E7 8D 00"),
    }
    for name, (made, written) in known.items():
        report.holds(f"example {name}", made == bytes.fromhex(written), made.hex(" "))
    data = [bytes([1] * n) for n in (0, 1, 253, 254, 255, 508, 509)] + [b"\0", b"\0\0", b"\1\0", bytes(range(256)) * 2]
    report.holds("COBS: what is encoded has no zero and decodes to itself",
                 all(0 not in cobs_encode(x) and cobs_decode(cobs_encode(x)) == x for x in data))
    report.holds("COBS: 254 bytes are FF and these, 255 are FF, 254 of them, 02, the last",
                 cobs_encode(b"x" * 254) == b"\xff" + b"x" * 254 and cobs_encode(b"x" * 255) == b"\xff" + b"x" * 254 + b"\x02x")


def identify(board, report):
    """Checks INFO; returns (carrier in Hz, slots)."""
    info = board.ask(INFO).body
    carrier, slots = int.from_bytes(info[9:13], "little") / 1000, info[7] + 1
    print(f"      protocol {info[5]}, gateware {info[8]}, {info[6]} phase bits, {slots} slots, carrier {carrier:.3f} Hz, "
          f"{info[13] + 1} channels, up to {info[14] * 100000} baud")
    report.holds("INFO: protocol 2, 5 to 8 phase bits, 256 channels", info[5] == 2 and 5 <= info[6] <= 8 and info[13] == 255, info.hex(" "))
    report.holds("INFO: the carrier is within 1 kHz of 40 kHz", 39_000 < carrier < 41_000, carrier)
    return carrier, slots


def silence(board):
    """MUTE, then RESET as soon as it is accepted."""
    board.ask(MUTE)
    board.wait_for(ON, 0, "MUTE")
    end = time.monotonic() + PATIENCE
    while (reply := board.ask(RESET)).result == STATE and time.monotonic() < end:
        pass
    return reply


def after_reset(board, report, slots):
    reply = silence(board)
    report.holds("MUTE, then RESET: OK; not enabled, not tripped, not on", reply.result == OK and not reply.flags & 0x57, hex(reply.flags))
    found = [board.digest(SLOT, slot) for slot in (0, slots - 1)]
    report.holds("RESET: slots are all zeros (0xB2AA7578)", found == [0xB2AA7578] * 2, [hex(x) for x in found])
    found = [board.digest(table) for table in (TABLE_ENVELOPE, TABLE_WIDTHS, TABLE_CALIBRATION)]
    report.holds("RESET: envelope, widths and calibration are those of power-up", found == [0xFEA8A821, 0xAF0475A1, 0x1B6E50DD],
                 [hex(x) for x in found])
    widths = bytes(round(256 / math.pi * math.asin(a / 255)) for a in range(256))
    known = [zlib.crc32(b"\xff" * 256), zlib.crc32(widths), zlib.crc32(b"\0\xff" * 256)]
    report.holds("and these digests are what the tables' formulae give", found == known, [hex(x) for x in known])


def refusals(board, report, slots):
    def refused(what, result, *asked):
        reply = board.ask(*asked)
        report.holds(f"{what}: result {result}", reply.result == result, reply.result)

    refused("a type that there is not: UNKNOWN", UNKNOWN, 0x7F)
    refused("STATUS with a payload: LENGTH", LENGTH, STATUS, b"", b"x")
    refused("ENABLE without watchdog and confirm: ARGUMENT", ARGUMENT, ENABLE)
    refused("PLAY with divider 0: ARGUMENT", ARGUMENT, PLAY, bytes([1, 2, 0, 0]), bytes(3))
    refused("PLAY with when = 4: ARGUMENT", ARGUMENT, PLAY, bytes([1, 2, 1, 0]), bytes([0, 0, 4]))
    refused("SILENCER with a step of 0: ARGUMENT", ARGUMENT, SILENCER, bytes([0, 0, 1, 0]))
    refused("DIGEST of a fifth table: ARGUMENT", ARGUMENT, DIGEST, bytes([4]))
    if slots < 256:
        refused("FRAME into a slot beyond the store: ARGUMENT", ARGUMENT, FRAME, bytes([slots]), bytes(512))
    refused("FRAME into the slot that is played: BUSY", BUSY, FRAME, bytes([board.ask(STATUS).slot]), bytes(512))


def counting(board, report):
    """Which packets are counted and answered."""
    before = board.ask(STATUS)
    board.send(STATUS, address=BROADCAST)
    report.holds("a broadcast is not answered", board.read_reply(SILENCE) is None)
    board.send(STATUS, address=(board.address + 1) % 8)
    report.holds("a packet for another address is not answered", board.read_reply(SILENCE) is None)
    damaged = bytearray(packet(STATUS, board.address, 9))
    damaged[-2] ^= 0x10
    board.write(damaged)
    reply = board.read_reply(PATIENCE if board.address == 0 else SILENCE)
    if board.address == 0:
        report.holds("a damaged packet is answered by 0x80, seq 0, CRC", reply is not None
                     and (reply.kind, reply.address, reply.seq, reply.result) == (0x80, 0, 0, CRC), reply and reply.body.hex(" "))
    else:
        report.holds("a damaged packet is answered at address 0 alone", reply is None)
    board.write(b"\0\0")
    after = board.ask(STATUS)
    report.holds("counted: the broadcast and the last STATUS", (after.good - before.good) % 65536 == 2, after.good - before.good)
    report.holds("counted as spoiled: the damaged one", (after.spoiled - before.spoiled) % 65536 == 1, after.spoiled - before.spoiled)
    if board.address == 0:
        old = b"\x01\x4d\0\0\0\0"
        board.write(cobs_encode(old + crc16_genibus(old).to_bytes(2, "big")) + b"\0")
        data = board.read_packet(PATIENCE) or b""
        true = len(data) == 16 and data[:3] == b"\x81\x4d\x04" and crc16_genibus(data[:14]) == int.from_bytes(data[14:], "big")
        report.holds("INFO of version 1 is answered in its form: UNKNOWN, protocol 2", true and data[4] == 2, data.hex(" "))
    for _ in range(4):
        board.send(STATUS)
    replies = [board.read_reply() for _ in range(4)]
    in_order = [(board.seq + n) % 256 for n in (-3, -2, -1, 0)]
    report.holds("four packets at once are answered in their order", [reply and reply.seq for reply in replies] == in_order)


def sound(board, report, carrier):
    """A focus 10 cm above the centre, at half amplitude."""
    frame = focus(0.0, 0.0, 0.10, carrier, 128)
    report.holds("FRAME: OK", board.ask(FRAME, bytes([1, 0, 0]), frame).result == OK)
    report.holds("DIGEST of the slot is the frame's CRC-32", board.digest(SLOT, 1) == zlib.crc32(frame))
    phases = frame[::2]
    report.holds("PHASES writes the same with one amplitude", board.ask(PHASES, bytes([2, 128]), phases).result == OK
                 and board.digest(SLOT, 2) == zlib.crc32(frame))
    reply = board.ask(ENABLE, round(carrier / 64).to_bytes(2, "little"))
    report.holds("ENABLE with a watchdog of 1 s: OK, enabled", reply.result == OK and reply.flags & ENABLED, hex(reply.flags))
    reply = board.ask(PLAY, bytes([1, 1, 1, 0]), bytes([1, 0, 0]))
    report.holds("PLAY of the focus: OK", reply.result == OK)
    reply = board.wait_for(ON | WAITING, ON, "PLAY")
    waits = board.ask(PLAY, bytes([2, 2, 1, 0]), bytes([1, 0, 3]))
    report.holds("PLAY at a trigger: OK, it waits", waits.result == OK and waits.flags & WAITING and waits.slot == 1, hex(waits.flags))
    reply = board.ask(STOP)
    report.holds("outputs are on, slot 1 is played", reply.slot == 1 and not reply.flags & (TRIPPED | STOPPED | PLAYING), hex(reply.flags))
    report.holds("RESET while it is enabled: STATE", board.ask(RESET).result == STATE)


def circle(board, report, carrier, slots):
    """A focus on a circle of 1 cm radius, at some 10 frames per second, from the board's store."""
    count = min(slots - 2, 12)
    for n in range(count):
        angle = 2 * math.pi * n / count
        frame = focus(0.01 * math.cos(angle), 0.01 * math.sin(angle), 0.10, carrier, 128)
        if board.ask(FRAME, bytes([2 + n]), frame).result != OK:
            report.holds(f"FRAME into slot {2 + n}", False)
    divider = 50
    reply = board.ask(PLAY, bytes([2, 1 + count]) + divider.to_bytes(2, "little"), bytes(3))
    report.holds(f"PLAY of {count} frames, {divider} periods each, for ever: OK", reply.result == OK)
    seen, end = set(), time.monotonic() + PATIENCE
    while len(seen) < count and time.monotonic() < end:
        reply = board.ask(STATUS)
        seen.add(reply.slot)
    report.holds("STATUS shows all slots of the circle, and flag 2", seen - {1} == set(range(2, 2 + count)) and reply.flags & PLAYING, seen)
    report.holds("FRAME into the circle while it is played: BUSY", board.ask(FRAME, bytes([3]), bytes(512)).result == BUSY)
    report.holds("RATE and ENVELOPE: OK", board.ask(RATE, round(200 / carrier * 2 ** 24).to_bytes(3, "little") + b"\1").result == OK
                 and board.ask(ENVELOPE, b"", bytes(range(256))).result == OK)
    report.holds("DIGEST of the envelope", board.digest(TABLE_ENVELOPE) == zlib.crc32(bytes(range(256))))
    board.ask(STOP)
    stopped = board.wait_for(PLAYING, 0, "STOP").slot
    report.holds("STOP: it stays on its slot", board.ask(STATUS).slot == stopped and board.ask(STATUS).slot == stopped)


def watchdog(board, report):
    # 2 * 64 periods, 3.2 ms.
    board.ask(ENABLE, b"\x02")
    time.sleep(0.5)
    reply = board.ask(STATUS)
    report.holds("a host that falls silent is noticed: tripped, no longer enabled", reply.flags & (ENABLED | TRIPPED) == TRIPPED, hex(reply.flags))
    board.wait_for(ON, 0, "the watchdog's ramp")
    reply = board.ask(ENABLE, round(40_000 / 64).to_bytes(2, "little"))
    report.holds("ENABLE clears it", reply.flags & (ENABLED | TRIPPED) == ENABLED, hex(reply.flags))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("port", help="the serial port, such as /dev/ttyUSB0")
    parser.add_argument("--address", type=int, default=0, choices=range(8), help="of the device, 0 unless its pins say otherwise")
    asked = parser.parse_args()
    report = Report()
    examples(report)
    try:
        board = Board(asked.port, asked.address)
        carrier, slots = identify(board, report)
        after_reset(board, report, slots)
        refusals(board, report, slots)
        counting(board, report)
        sound(board, report, carrier)
        circle(board, report, carrier, slots)
        watchdog(board, report)
        reply = silence(board)
        report.holds("MUTE and RESET at the end: OK, outputs off", reply.result == OK and not reply.flags & (ENABLED | ON), hex(reply.flags))
    except (OSError, ValueError, termios.error) as error:
        report.holds(str(error), False)
    print(f"{report.failed} of the statements do not hold" if report.failed else "all of this is as the document says")
    return 1 if report.failed else 0


if __name__ == "__main__":
    sys.exit(main())
