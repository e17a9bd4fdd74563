#!/usr/bin/env python3
"""The field of the page against the command line's, in headless browsers, and the times of a drag there.

    web/tests/field.py FOLDER SONOGLYPH [--browser chromium|firefox]... [--evaluator cpu|any-gpu]... [--no-times]

FOLDER is the page built by `web/build`. The map of one drive is compared with that of the command line by the same kind
of evaluator, in the scene's own tolerance, and exactly with the f64 reference. Exit 0 if no map is off by more than
2e-5 of its peak.
"""

import argparse
import http.server
import json
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

import numpy as np

SCENES = Path(__file__).parent.parent.parent / "assets" / "scenes"
#: Scenes of one drive, and quantities. The liquid is within the map's own tolerance of f64 only, because of its cells.
MAPS = [("hit", "rms"), ("five-points", "rms"), ("heart", "rms"), ("water-three-points", "depression"), ("two-boards", "rms")]
DRAGS = [("focus-centre", "rms"), ("five-points", "rms"), ("five-points", "phase"), ("hit", "rms"), ("water-circle", "depression"),
         ("two-boards", "rms")]
#: Relative to the peak.
TOLERANCE = 2e-5
SIZE, EXACT_SIZE = 512, 96
FRAMES = 40
#: s
PATIENCE = int(__import__("os").environ.get("PATIENCE", "420"))

CHROMIUM = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
            "--disable-background-networking", "--disable-component-update", "--disable-sync", "--enable-unsafe-webgpu",
            "--enable-unsafe-swiftshader"]
PREFERENCES = {"dom.webgpu.enabled": True, "gfx.webgpu.ignore-blocklist": True, "datareporting.policy.dataSubmissionEnabled": False,
               "browser.shell.checkDefaultBrowser": False, "app.update.enabled": False, "browser.aboutwelcome.enabled": False}


def with_tolerance(text, tolerance):
    text = re.sub(r"(?m)^tolerance *=.*\n", "", text)
    if "[plane]" not in text:
        return f"{text}\n[plane]\ntolerance = {tolerance}\n"
    return text.replace("[plane]", f"[plane]\ntolerance = {tolerance}", 1)


def moved(text, metres):
    """The scene with its first target moved along x."""
    place = re.search(r"(?m)^at *= *\[([^,]*),", text[text.index("[[target]]"):])
    at = text.index("[[target]]") + place.start(1)
    return text[:at] + repr(float(place[1]) + metres) + text[at + len(place[1]):]


def solved(program, path):
    answer = json.loads(subprocess.run([program, "solve", path, "--json"], check=True, capture_output=True).stdout)
    return answer["phases"], answer["amplitudes"]


def rendered(program, path, quantity, size, backend, folder):
    data = folder / "map.npy"
    command = [program, "render", path, "-o", folder / "map.png", "--quantity", quantity, "--size", str(size), "--backend", backend,
               "--data", data]
    subprocess.run(command, check=True, capture_output=True)
    return np.load(data)


class Server(http.server.ThreadingHTTPServer):
    """Serves the page and the jobs, and collects the results."""

    def __init__(self, page, jobs):
        super().__init__(("127.0.0.1", 0), Handler)
        self.page, self.jobs, self.values, self.answers = Path(page), jobs, {}, {}
        self.browser, self.end = None, threading.Event()
        threading.Thread(target=self.serve_forever, daemon=True).start()


class Handler(http.server.BaseHTTPRequestHandler):
    KINDS = {".html": "text/html", ".js": "text/javascript", ".wasm": "application/wasm"}

    def log_message(self, *_):
        pass

    def reply(self, body=b"", kind="text/plain", status=200):
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def do_GET(self):
        name = self.path.split("?")[0].lstrip("/")
        if name == "jobs":
            return self.reply(json.dumps(self.server.jobs).encode(), "application/json")
        own = Path(__file__).parent / name
        path = own if own.name in ("field.html", "field.js") else self.server.page / name
        if ".." in path.parts or not path.is_file():
            return self.reply(status=404)
        return self.reply(path.read_bytes(), self.KINDS.get(path.suffix, "application/octet-stream"))

    def do_POST(self):
        what, _, name = self.path.lstrip("/").partition("?")
        body = self.rfile.read(int(self.headers["Content-Length"]))
        if what == "values":
            self.server.values[name] = np.frombuffer(body, "<f4")
        elif what == "answer":
            self.server.answers[name] = json.loads(body)
        elif what == "problem":
            print(f"the page: {body.decode()}", flush=True)
            self.server.end.set()
        elif what == "end":
            self.server.browser = body.decode()
            self.server.end.set()
        self.reply()


def visit(browser, address, profile):
    if browser == "chromium":
        return CHROMIUM + [f"--user-data-dir={profile}", address]
    lines = [f"user_pref({json.dumps(key)}, {json.dumps(value)});" for key, value in PREFERENCES.items()]
    (profile / "user.js").write_text("\n".join(lines))
    return ["firefox-esr", "--headless", "--no-remote", "--profile", profile, address]


def run(browser, server):
    profile = Path(tempfile.mkdtemp())
    address = f"http://localhost:{server.server_port}/field.html?jobs"
    process = subprocess.Popen(visit(browser, address, profile), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    is_done = server.end.wait(PATIENCE)
    process.terminate()
    try:
        process.wait(20)
    except subprocess.TimeoutExpired:
        process.kill()
    shutil.rmtree(profile, ignore_errors=True)
    if not is_done:
        sys.exit(f"{browser}: no answer in {PATIENCE} s; {len(server.answers)} of {len(server.jobs)} jobs are done")


def prepared(program, evaluators, folder):
    """The jobs, and their expected values."""
    jobs, expected = [], {}
    for scene, quantity in MAPS:
        text = (SCENES / f"{scene}.toml").read_text()
        path = SCENES / f"{scene}.toml"
        phases, amplitudes = solved(program, path)
        exact = folder / f"{scene}-exact.toml"
        exact.write_text(with_tolerance(text, 0.0))
        own = {"quantity": quantity, "phases": phases, "amplitudes": amplitudes}
        for evaluator in evaluators:
            backend = "cpu" if evaluator == "cpu" else "gpu"
            name = f"{scene}/{evaluator}/same"
            expected[name] = rendered(program, path, quantity, SIZE, backend, folder)
            jobs.append({**own, "name": name, "scene": text, "evaluator": evaluator, "size": SIZE})
            name = f"{scene}/{evaluator}/exact"
            if evaluator == evaluators[0]:
                judge = rendered(program, exact, quantity, EXACT_SIZE, "reference", folder)
            expected[name] = judge
            jobs.append({**own, "name": name, "scene": exact.read_text(), "evaluator": evaluator, "size": EXACT_SIZE})
    return jobs, expected


def drags(evaluators):
    jobs = []
    for scene, quantity in DRAGS:
        text = (SCENES / f"{scene}.toml").read_text()
        frames = [moved(text, 2e-4 * step) for step in range(FRAMES)]
        for evaluator in evaluators:
            name = f"{scene}/{quantity}/{evaluator}"
            jobs.append({"name": name, "drag": frames, "quantity": quantity, "evaluator": evaluator, "size": SIZE})
    return jobs


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("page")
    arguments.add_argument("program")
    arguments.add_argument("--browser", action="append", choices=["chromium", "firefox"])
    arguments.add_argument("--evaluator", action="append", choices=["cpu", "gpu", "any-gpu"])
    arguments.add_argument("--no-times", action="store_true")
    asked = arguments.parse_args()
    evaluators = asked.evaluator or ["cpu", "any-gpu"]
    with tempfile.TemporaryDirectory() as folder:
        jobs, expected = prepared(asked.program, evaluators, Path(folder))
    timed = [] if asked.no_times else drags(evaluators)
    worst = 0.0
    for browser in asked.browser or ["chromium", "firefox"]:
        server = Server(asked.page, jobs + timed)
        run(browser, server)
        print(f"{browser}: {server.browser}")
        for job in jobs:
            name = job["name"]
            answer = server.answers[name]
            if "problem" in answer:
                print(f"  {name:34} {answer['problem']}")
                worst = float("inf")
                continue
            values, judge = server.values[name].reshape(expected[name].shape), expected[name]
            off = float(np.abs(values - judge).max() / np.abs(judge).max())
            worst = max(worst, off)
            print(f"  {name:34} off by {off:.1e} of the peak, {answer['mapping']:7.1f} ms, {answer['evaluator']}: {answer['how']}")
        for job in timed:
            answer = server.answers[job["name"]]
            if "problem" in answer:
                print(f"  {job['name']:34} {answer['problem']}")
                worst = float("inf")
                continue
            first, rest = answer["frames"][0], answer["frames"][1:]
            def middle(key):
                return statistics.median(frame[key] for frame in rest)
            parts = " + ".join(f"{middle(key):.1f}" for key in ["solving", "mapping", "colouring"])
            least = min(frame["all"] for frame in rest)
            print(f"  {job['name']:34} frame {middle('all'):6.1f} ms ({parts}; least {least:.1f}), first {first['all']:.1f} ms")
    if not worst <= TOLERANCE:
        sys.exit(f"the worst map is off by {worst:.1e} of its peak, more than {TOLERANCE:.0e}")
    print(f"{len(jobs)} maps in each browser, off by {worst:.1e} of the peak at most")


if __name__ == "__main__":
    main()
