#!/usr/bin/env python3
"""Latency from a packet to the first byte on a board's line.

    tests/control/latency.py PROGRAM [PACKETS] [PER_SECOND] [PROFILE]

Opens a pseudo-terminal, lets `sonoglyph serve` play on it, moves eight foci by OSC bundles, and reads the line.
"""
import math, os, pty, select, signal, socket, struct, subprocess, sys, tempfile, time, tty

PROGRAM = sys.argv[1]
PACKETS, RATE = int((sys.argv[2:3] or [1000])[0]), float((sys.argv[3:4] or [50])[0])
PROFILE = (sys.argv[4:5] or ["sonicsurface"])[0]
FOCI = 8


def text(value):
    return value.encode() + b"\0" * (4 - len(value.encode()) % 4)


def message(address, *numbers):
    return text(address) + text("," + "f" * len(numbers)) + b"".join(struct.pack(">f", x) for x in numbers)


def bundle(parts):
    return b"#bundle\0" + struct.pack(">II", 0, 1) + b"".join(struct.pack(">I", len(p)) + p for p in parts)


def places(step):
    turn = [step / 50 + math.tau * n / FOCI for n in range(FOCI)]
    return [(0.03 * math.cos(t), 0.03 * math.sin(t), 0.1) for t in turn]


def resident(process):
    lines = open(f"/proc/{process.pid}/status").read().splitlines()
    return next(line.split()[1] for line in lines if line.startswith("VmRSS"))


master, slave = pty.openpty()
tty.setraw(slave)
with tempfile.NamedTemporaryFile("w", suffix=".toml") as scene:
    targets = "".join(f"[[target]]\nat = [{x:.6f}, {y:.6f}, {z}]\n" for x, y, z in places(0))
    scene.write("format = 1\n" + targets)
    scene.flush()
    arguments = ["--osc", "0", "--port", os.ttyname(slave), "--profile", PROFILE]
    serve = subprocess.Popen([PROGRAM, "serve", scene.name, *arguments], stdout=subprocess.PIPE, text=True)
    line = serve.stdout.readline()
    port = int(line.rsplit(":", 1)[1])
    out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    out.connect(("127.0.0.1", port))
    out.send(message("/sonoglyph/send"))
    time.sleep(0.5)
    before, delays, missed = resident(serve), [], 0
    for step in range(1, PACKETS + 1):
        due = time.monotonic() + 1 / RATE
        while select.select([master], [], [], 0)[0]:
            os.read(master, 65536)
        packet = bundle([message(f"/sonoglyph/target/{n + 1}/at", *at) for n, at in enumerate(places(step))])
        sent = time.monotonic_ns()
        out.send(packet)
        if select.select([master], [], [], 0.2)[0]:
            os.read(master, 1)
            delays.append((time.monotonic_ns() - sent) / 1e6)
        else:
            missed += 1
        while (rest := due - time.monotonic()) > 0:
            if select.select([master], [], [], rest)[0]:
                os.read(master, 65536)
    delays.sort()
    at = lambda part: delays[min(len(delays) - 1, int(len(delays) * part))]
    print(f"{PROFILE}, {len(delays)} packets of {FOCI} foci at {RATE:g}/s, {missed} without a frame: "
          f"median {at(.5):.2f} ms, 95 % {at(.95):.2f} ms, 99 % {at(.99):.2f} ms, most {delays[-1]:.2f} ms; "
          f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores; {before} kB before, {resident(serve)} kB after")
    serve.send_signal(signal.SIGINT)
    while serve.poll() is None:
        if select.select([master], [], [], 0.1)[0]:
            os.read(master, 65536)
    sys.exit(serve.returncode)
