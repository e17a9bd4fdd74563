#!/usr/bin/env python3
"""The link over Web Serial in a real browser: web/tests/serial.py FOLDER SONOGLYPH

FOLDER is the page built by `web/build`. web/tests/serial.js runs in a headless Chromium with web/tests/stand-in.js in
place of `navigator.serial`, and compares the bytes written by the page with those that `sonoglyph send` writes to a
virtual board for the same scene. For a stock board all bytes are compared, but repeated frames count once, since their
number depends on timing. For a native board all packets are compared in order, decoded by gateware/doc/client.py, which
was written from protocol.md alone: type, address, arguments and payload; without sequence numbers, MUTE before the
first sound, and the keep-alive questions INFO and STATUS. Exits with 0 if everything agrees, and prints the
comparisons.
"""

import http.server
import importlib.util
import json
import os
import pathlib
import select
import shutil
import subprocess
import sys
import tempfile
import termios
import threading
import time
import tty

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PROFILES = ["native", "sonicsurface"]
PATIENCE = 240.0
SCENE = """format = 1
[[target]]
kind = "point"
at = [0.01, -0.005, 0.1]
[modulation]
shape = "{shape}"
"""
SPEEDS = {230400: termios.B230400, 2000000: termios.B2000000}
BAUDS = {"native": 2000000, "sonicsurface": 230400}
INFO, STATUS, MUTE, PHASES = 0x01, 0x02, 0x04, 0x10
# The last byte of a stock frame.
SWAP = b"\xfd"
START = bytes([151, 192])


def scene(profile):
    # A stock board is modulated by the host, whose timing varies; its still sound does not.
    return SCENE.format(shape="sine" if profile == "native" else "off")


def client():
    spec = importlib.util.spec_from_file_location("client", ROOT / "gateware" / "doc" / "client.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def make(site, folder):
    """Collects the files that the browser loads in one folder."""
    shutil.copytree(site, folder, dirs_exist_ok=True)
    for name in ["serial.html", "serial.js", "stand-in.js"]:
        shutil.copy(ROOT / "web" / "tests" / name, folder)


def in_browser(folder, tasks):
    """The page's results."""
    found, done = {}, threading.Event()

    class Handler(http.server.SimpleHTTPRequestHandler):
        def __init__(self, *arguments):
            super().__init__(*arguments, directory=str(folder))

        def do_GET(self):
            if self.path != "/tasks":
                return super().do_GET()
            body = json.dumps(tasks).encode()
            self.send_response(200)
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def do_POST(self):
            found.update(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
            self.send_response(204)
            self.end_headers()
            done.set()

        def log_message(self, *arguments):
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    with tempfile.TemporaryDirectory() as profile:
        address = f"http://localhost:{server.server_port}/serial.html"
        options = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
                   "--disable-component-update", "--disable-sync", "--enable-logging=stderr", f"--user-data-dir={profile}"]
        with open(folder / "browser.log", "w") as log:
            browser = subprocess.Popen(["chromium", *options, address], stdout=log, stderr=log)
        try:
            in_time = done.wait(PATIENCE)
        finally:
            browser.terminate()
            browser.wait()
            server.shutdown()
    if not in_time:
        sys.exit(f"no results from the browser in {PATIENCE} s: {(folder / 'browser.log').read_text()[-2000:]}")
    return found


def by_command(sonoglyph, profile, folder):
    """The bytes that `sonoglyph send` writes to a virtual board, recorded between the two."""
    path = folder / f"{profile}.toml"
    path.write_text(scene(profile))
    board = subprocess.Popen([sonoglyph, "board", "--profile", profile], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    heard = bytearray()
    try:
        line = os.open(board.stdout.readline().strip(), os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        tty.setraw(line)
        settings = termios.tcgetattr(line)
        settings[4] = settings[5] = SPEEDS[BAUDS[profile]]
        termios.tcsetattr(line, termios.TCSANOW, settings)
        own, theirs = os.openpty()
        tty.setraw(theirs)
        send = subprocess.Popen([sonoglyph, "send", path, "--port", os.ttyname(theirs), "--profile", profile, "--seconds", "1"],
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        ended = None
        while ended is None or time.monotonic() < ended + 0.3:
            if ended is None and send.poll() is not None:
                ended = time.monotonic()
            for ready in select.select([own, line], [], [], 0.05)[0]:
                data = os.read(ready, 4096)
                if ready == own:
                    heard += data
                os.write(line if ready == own else own, data)
        if send.returncode != 0:
            sys.exit(f"send: {send.stderr.read()}")
    finally:
        board.terminate()
        board.wait()
    return bytes(heard)


def packets(data, decode):
    """(type, address, arguments and payload) of every packet except questions, and the number of questions."""
    found, questions = [], 0
    for part in data.split(b"\0"):
        if not part:
            continue
        body = decode(part)
        if body[0] in (INFO, STATUS):
            questions += 1
        else:
            found.append((body[0], body[1], body[3:-4].hex()))
    return found, questions


def without_mutes(found):
    """The packets without those MUTE before the first frame, whose number depends on timing."""
    first = next((n for n, (kind, *_) in enumerate(found) if kind == PHASES), len(found))
    return [packet for n, packet in enumerate(found) if packet[0] != MUTE or n > first]


def frames(data):
    """Stock bytes, cut after every swap."""
    *parts, rest = data.split(SWAP)
    return [part + SWAP for part in parts] + ([rest] if rest else [])


def once(parts):
    """The frames without repetitions of a frame or of a pair of frames, and without what precedes one after a pause."""
    kept = []
    for part in parts:
        kept.append(part.removeprefix(START))
        for length in (1, 2):
            if len(kept) >= 2 * length and kept[-length:] == kept[-2 * length:-length]:
                del kept[-length:]
                break
    return kept


class Report:
    def __init__(self):
        self.failed = 0

    def state(self, holds, what):
        print(f"{'ok    ' if holds else 'FAILED'} {what}")
        self.failed += not holds


def milliseconds(figures):
    names = ["round trip", "latency", "half period"]
    return ", ".join(f"{name} {figures[3 + 2 * n]:.2f} ± {figures[4 + 2 * n]:.2f} ms" for n, name in enumerate(names) if figures[3 + 2 * n])


def judge_still(report, profile, page, command, decode):
    own = bytes.fromhex(page["bytes"])
    report.state(page["is_played"], f"{profile}: the board behind the page's port plays the scene")
    report.state(page["is_silent"], f"{profile}: silent after the link")
    steps = page["steps"]
    report.state(steps["before"] == [] and steps["declined"] is None and steps["after"] == [steps["chosen"]],
                 f"{profile}: only the chosen port is listed: {steps['chosen']}")
    if profile == "native":
        (ours, asked), (theirs, asked_too) = packets(own, decode), packets(command, decode)
        ours, theirs = without_mutes(ours), without_mutes(theirs)
        report.state(ours == theirs and len(ours) > 5,
                     f"native: {len(ours)} packets of page and `send` are equal, in order (questions: {asked} and {asked_too})")
        if ours != theirs:
            print("page:", [(hex(kind), body[:40]) for kind, _, body in ours])
            print("send:", [(hex(kind), body[:40]) for kind, _, body in theirs])
    else:
        sent, sent_too = frames(own), frames(command)
        ours, theirs = once(sent), once(sent_too)
        report.state(ours == theirs and len(ours) > 2,
                     f"{profile}: {len(b''.join(ours))} bytes of page and `send` are equal, in {len(ours)} frames ({len(sent)} and "
                     f"{len(sent_too)} with those that were sent again)")
        if ours != theirs:
            print("page:", [(len(part), part[:8].hex()) for part in sent])
            print("send:", [(len(part), part[:8].hex()) for part in sent_too])
    print(f"       {milliseconds(page['figures'])}; the page was held for {page['held']:.0f} ms at most; its port: {', '.join(page['events'])}")


def judge(found, commands, decode):
    report = Report()
    for name, part in found.items():
        if "error" in part:
            report.state(False, f"{name}: {part['error']}")
    sound = {name: part for name, part in found.items() if "error" not in part}
    for profile in PROFILES:
        if f"still {profile}" in sound:
            judge_still(report, profile, sound[f"still {profile}"], commands[profile], decode)
        if part := sound.get(f"drag {profile}"):
            report.state(part["is_last"], f"{profile}: after {part['wishes']} requests in {part['seconds']:.1f} s the board plays the last")
            print(f"       {part['frames']} frames shown, {part['figures'][1]:.0f} sent again; {milliseconds(part['figures'])}; the page was "
                  f"held for {part['held']:.0f} ms at most")
        if part := sound.get(f"loss {profile}"):
            lost = [event for event in part["told"] if event.startswith("lost")]
            report.state(part["is_played"] and any("takes no bytes" in event for event in lost), f"{profile}: replugged, it continues; reported: {lost}")
            report.state(part["again"].startswith("ready"), f"{profile}: a second link opens without a loss: {part['again']}")
        for how in ["address", "removed", "failed"]:
            if part := sound.get(f"left {profile} {how}"):
                report.state(part["is_silent"], f"{profile}: silent when the page is left ({how}), by {len(part['last']) // 2} bytes")
    if part := sound.get("rates"):
        report.state("more than the board's" in part["native 9000000"], f"a rate beyond the board's: {part['native 9000000']}")
        report.state("Failed to open" in part["native 3000000"], f"a rate beyond the adapter's: {part['native 3000000']}")
        report.state("Failed to open" in part["sonicsurface 3000000"], f"the same at the start: {part['sonicsurface 3000000']}")
    if part := sound.get("survey"):
        opened = [event for event in part["events"] if event.startswith("open")]
        rates = [line.split(":")[0] for line in part["found"] if line.endswith(", clean")]
        report.state("115200" in rates and "2000000" in rates and "230400" not in rates and part["events"][-1] == "close",
                     f"the line's survey, by {len(opened)} openings of the port, with one unsupported rate; clean: {', '.join(rates)}")
        print("       " + "\n       ".join(part["found"]))
    if part := sound.get("swaps"):
        report.state(any("timers of this page" in event for event in part["told"]), "the page reports that swaps are as even as its timers")
        print(f"       {milliseconds(part['figures'])} (2.5 ms asked); {part['frames']} swaps in 2 s; the page was held for {part['held']:.0f} ms at most")
    return report


def check(site, sonoglyph):
    """Judges the results; whether all checks hold."""
    tasks = []
    for profile in PROFILES:
        task = {"profile": profile, "scene": scene(profile)}
        tasks += [{**task, "name": f"{part} {profile}", "part": part} for part in ["still", "loss"]]
        # A native board's rate is changed after its first answer.
        tasks.append({**task, "name": f"drag {profile}", "part": "drag", "baud": 3000000 if profile == "native" else None})
        tasks += [{**task, "name": f"left {profile} {how}", "part": "left", "how": how} for how in ["address", "removed", "failed"]]
    tasks.append({"name": "rates", "part": "rates", "scene": scene("native")})
    tasks.append({"name": "survey", "part": "survey"})
    tasks.append({"name": "swaps", "part": "swaps", "scene": SCENE.format(shape="square")})
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        make(site, folder)
        commands = {profile: by_command(sonoglyph, profile, folder) for profile in PROFILES}
        found = in_browser(folder, tasks)
    report = judge(found, commands, client().cobs_decode)
    what = "what the page writes to a port and what `sonoglyph send` writes are the same, for " + " and ".join(PROFILES)
    print(what if report.failed == 0 else f"{report.failed} of these failed")
    return report.failed == 0


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    sys.exit(0 if check(*map(os.path.abspath, sys.argv[1:])) else 1)
