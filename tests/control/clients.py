#!/usr/bin/env python3
"""Runs the clients of docs/control.md against a server: `tests/control/clients.py PROGRAM`.

Needs python-osc, websockets and numpy beside this Python, and Node 20 or later.
"""
import pathlib, re, signal, subprocess, sys, tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
BLOCKS = re.findall(r"```(python|js)\n(.*?)```", (ROOT / "docs/control.md").read_text(), re.S)
serve = subprocess.Popen([sys.argv[1], "serve", ROOT / "assets/scenes/circle.toml"], stdout=subprocess.PIPE, text=True)
assert serve.stdout.readline() == "OSC on udp://127.0.0.1:9000\n"
failed = 0
for kind, code in BLOCKS:
    with tempfile.NamedTemporaryFile("w", suffix=".py" if kind == "python" else ".js") as client:
        client.write(code)
        client.flush()
        command = [sys.executable] if kind == "python" else ["node", "--experimental-websocket"]
        done = subprocess.run([*command, client.name], capture_output=True, text=True, timeout=60)
    failed += done.returncode != 0
    print(kind, len(code.splitlines()), "lines:", done.returncode, done.stdout.strip() or "-", done.stderr.strip()[-300:])
serve.send_signal(signal.SIGINT)
print(serve.communicate()[0].splitlines()[-1], "; exit", serve.returncode)
sys.exit(failed or serve.returncode)
