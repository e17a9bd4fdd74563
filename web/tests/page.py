#!/usr/bin/env python3
"""Operates the page in headless Chromium by pointer and keys, and compares its output with the command line's."""

import base64
import contextlib
import io
import json
import subprocess
import sys
import tempfile
import time
import tomllib
import zlib
from pathlib import Path

import numpy as np
from PIL import Image
from selenium import webdriver
from selenium.webdriver import ActionChains, Keys
from selenium.webdriver.chrome.service import Service

SERVER, FOLDER, PROGRAM = sys.argv[1:4]
SCENES = Path("assets/scenes")
SIZE = (1280, 800)
#: Relative to the largest value.
TOLERANCE = 2e-5
#: Sound speed (m/s) of the scene summed below.
SPEED = 343.0
CHECKED = []
#: On the Device page: the button that chooses a port, in points from the upper left corner.
CHOOSE = (1110, 247)


def checked(what):
    print(f"   {what}", flush=True)
    CHECKED.append(what)


def until(condition, what, seconds=60):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        with contextlib.suppress(TypeError, KeyError):
            if found := condition():
                return found
        time.sleep(0.05)
    raise AssertionError(f"after {seconds} s still not: {what}")


@contextlib.contextmanager
def server():
    with subprocess.Popen([SERVER, "serve", FOLDER, "0"], stdout=subprocess.PIPE, text=True) as process:
        try:
            yield process.stdout.readline().strip()
        finally:
            process.kill()


class Page:
    """A headless browser with the page."""

    def __init__(self, address, downloads, profile, flags=()):
        self.address, self.downloads = address, Path(downloads)
        options = webdriver.ChromeOptions()
        width, height = SIZE
        for flag in ["headless=new", "no-sandbox", "disable-quic", "no-first-run", "disable-background-networking",
                     "disable-component-update", "disable-sync", "enable-unsafe-swiftshader", f"window-size={width},{height}",
                     "force-device-scale-factor=1", f"user-data-dir={profile}", *flags]:
            options.add_argument(f"--{flag}")
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(options=options, service=Service("/usr/bin/chromedriver"))
        self.driver.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(downloads)})

    def open(self, fragment="", forget=True):
        """Reloads the page without unsaved changes; returns the seconds until its first picture."""
        if forget and self.script("return !!window.sonoglyph"):
            self.script("Object.keys(localStorage).filter(key => key.includes('recovery')).forEach(key => localStorage.removeItem(key))")
        self.driver.get("about:blank")
        self.driver.get(self.address + fragment)
        until(lambda: self.shown()["size"], "a map")
        self.rest()
        return self.driver.execute_script("return window.sonoglyph.firstPicture") / 1e3

    def follow(self, fragment):
        """Opens a link in the same page, which asks nothing while there are no changes."""
        before = self.shown()["scene"]
        self.script("location.hash = arguments[0]", fragment)
        until(lambda: self.shown()["scene"] != before, "the scene of a link")
        self.rest()

    def script(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def shown(self):
        text = self.script("return window.sonoglyph?.shown()")
        return json.loads(text) if text else None

    def frames(self):
        return self.script("return window.sonoglyph.frames()")

    def rest(self, seconds=60):
        """Waits until the page neither computes nor draws."""
        def still():
            before = self.frames()
            if self.shown()["busy"]:
                return False
            time.sleep(0.4)
            # The blinking cursor of a text field may draw a frame.
            return self.frames() - before <= 1
        until(still, "rest", seconds)

    def place(self, across, up):
        """A point of the map, in fractions of its sides from its lower left corner."""
        left, top, width, height = self.shown()["rect"]
        return left + across * width, top + (1 - up) * height

    def point(self, *places, press=False, settle=True):
        """Moves the pointer from place to place, pressed, or with a click at the end."""
        pointer = ActionChains(self.driver, duration=60)
        for index, (x, y) in enumerate(places):
            pointer.w3c_actions.pointer_action.move_to_location(round(x), round(y))
            if press and index == 0:
                pointer.w3c_actions.pointer_action.pointer_down()
        if not press:
            pointer.w3c_actions.pointer_action.click()
        else:
            pointer.w3c_actions.pointer_action.pointer_up()
        pointer.perform()
        if settle:
            self.rest()

    def type(self, *keys, settle=True):
        for key in keys:
            chain = ActionChains(self.driver)
            if isinstance(key, tuple):
                *held, last = key
                for own in held:
                    chain.key_down(own)
                chain.send_keys(last)
                for own in held:
                    chain.key_up(own)
            else:
                chain.send_keys(key)
            chain.perform()
            time.sleep(0.15)
        if settle:
            self.rest()

    def run(self, action):
        """Runs a command by its name."""
        self.type((Keys.CONTROL, "p"), action, Keys.ENTER)

    def download(self, act):
        """The file downloaded by an action."""
        before = set(self.downloads.iterdir())
        act()
        def whole():
            new = set(self.downloads.iterdir()) - before
            return [path for path in new if not path.name.endswith((".crdownload", ".tmp")) and not path.name.startswith(".")]
        found = until(whole, "a download")
        time.sleep(0.2)
        return found[0]

    def numbers(self):
        """The exported values of the map."""
        def export():
            self.run("map data")
            self.type(Keys.ENTER)
        path = self.download(export)
        values = np.load(path)
        path.unlink()
        return values

    def screenshot(self):
        return np.asarray(Image.open(io.BytesIO(self.driver.get_screenshot_as_png())).convert("RGB")).astype(float)

    def log(self):
        return [entry["message"] for entry in self.driver.get_log("browser") if entry["level"] == "SEVERE"]


def rendered(page, folder):
    """The command line's map of the page's scene."""
    shown = page.shown()
    scene, data = Path(folder) / "shown.toml", Path(folder) / "shown.npy"
    scene.write_text(shown["scene"])
    width, height = shown["size"]
    # Page and command line choose their samples differently, within the map's tolerance.
    backend = "gpu" if shown["evaluator"] == "WebGPU" else "cpu"
    subprocess.run([PROGRAM, "render", scene, "--quantity", shown["quantity"], "--size", f"{width}x{height}", "--data", data,
                    "-o", Path(folder) / "shown.png", "--backend", backend], check=True, capture_output=True)
    return np.load(data)


def compare(page, folder, what):
    mine, theirs = page.numbers(), rendered(page, folder)
    assert mine.shape == theirs.shape, (mine.shape, theirs.shape)
    error = np.abs(mine - theirs).max() / np.abs(theirs).max()
    checked(f"{what}: {mine.shape[1]} x {mine.shape[0]} values, {error:.1e} of the peak from the command line's")
    return error


def bessel(x):
    """J1(x) by its series; x is at most 4 here."""
    term = total = x / 2
    for n in range(1, 30):
        term = -term * (x / 2) ** 2 / (n * (n + 1))
        total = total + term
    return total


def summed(page, folder):
    """The error of some of the map's values against a direct sum over the elements, relative to the largest."""
    def export():
        page.run("phases and amplitudes")
        page.type(Keys.ENTER)
    elements = np.genfromtxt(page.download(export), delimiter=",", names=True)
    mine, plane = page.numbers(), tomllib.loads(page.shown()["scene"])["plane"]
    height, width = mine.shape
    rows, columns = np.arange(3, height, 17), np.arange(5, width, 19)
    size, centre = plane["size"], plane["centre"]
    x = centre[0] + ((columns + 0.5) / width - 0.5) * size[0]
    y = centre[1] + ((rows + 0.5) / height - 0.5) * size[1]
    wavenumber = 2 * np.pi * 40000.0 / SPEED
    total = np.zeros((len(rows), len(columns)), complex)
    for element in elements:
        across = np.hypot(x[None, :] - element["x"], y[:, None] - element["y"])
        distance = np.hypot(across, centre[2])
        argument = np.maximum(wavenumber * 0.005 * across / distance, 1e-12)
        wave = 3.4 * 2 * bessel(argument) / argument / distance * np.exp(-1j * wavenumber * distance)
        total += element["amplitude"] * np.exp(1j * element["phase"]) * wave
    wanted = np.abs(total) / np.sqrt(2)
    return np.abs(mine[np.ix_(rows, columns)] - wanted).max() / mine.max()


def link(scene):
    """The fragment of an address with a scene."""
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    packed = packer.compress(scene.encode()) + packer.flush()
    return "#" + base64.urlsafe_b64encode(packed).decode().rstrip("=")


def of_file(name):
    return link((SCENES / f"{name}.toml").read_text())


def targets(page):
    return tomllib.loads(page.shown()["scene"])["target"]


def picture_is_the_maps(page, folder):
    """The correlation of the screen with the command line's picture."""
    left, top, width, height = (round(side) for side in page.shown()["rect"])
    rendered(page, folder)
    wanted = np.asarray(Image.open(Path(folder) / "shown.png").convert("RGB")).astype(float)
    seen = page.screenshot()[top:top + height, left:left + width]
    assert seen.shape == wanted.shape, (seen.shape, wanted.shape)
    # The lower half may show hints of the first start.
    upper = slice(0, height // 2)
    return np.corrcoef(seen[upper].ravel(), wanted[upper].ravel())[0, 1]


def by_pointer_and_keys(page, folder):
    seconds = page.open()
    checked(f"loads: the first picture after {seconds:.2f} s")
    assert [target["text"] for target in targets(page)] == ["HIT"]
    # Rounding may lead the search to another result than on the command line, so the page's own drive is summed.
    plane = f"[medium]\nsound_speed = {SPEED}\nabsorption = 0.0\n\n[plane]\ntolerance = 1e-5"
    page.follow(link((SCENES / "hit.toml").read_text().replace("[plane]", plane, 1)))
    error = summed(page, folder)
    checked(f"HIT: {error:.1e} of the peak from a direct sum over the elements")
    assert error < TOLERANCE, error
    page.follow(of_file("hit"))
    page.run("dark theme")
    likeness = picture_is_the_maps(page, folder)
    checked(f"HIT on the screen: {likeness:.3f} correlation with the command line's picture")
    assert likeness > 0.9

    before = page.frames()
    time.sleep(3)
    assert page.frames() == before, "frames are drawn while nothing happens"
    checked("left alone for 3 s: 0 frames")

    # More scenes, without the window: field.py.
    for name in ["focus-centre", "water-two-points"]:
        page.follow(of_file(name))
        if name.startswith("water"):
            page.run("show: depression")
        assert compare(page, folder, name) < TOLERANCE
    page.follow(of_file("focus-centre"))
    page.run("show: phase")
    assert page.shown()["quantity"] == "phase"
    page.run("show: pressure")

    before = targets(page)[0]["at"]
    page.point(page.place(0.5, 0.5), page.place(0.6, 0.55), page.place(0.7, 0.65), press=True)
    after = targets(page)[0]["at"]
    assert after[0] - before[0] > 0.01 and after[1] - before[1] > 0.005, (before, after)
    assert compare(page, folder, "a focus dragged aside") < TOLERANCE

    page.type("t")
    page.point(page.place(0.3, 0.4))
    page.type("H", Keys.ENTER)
    assert [target["text"] for target in targets(page) if target["kind"] == "text"] == ["H"]
    checked("a letter is typed")

    page.type((Keys.CONTROL, "s"))
    saved = page.download(lambda: page.type(Keys.ENTER))
    wanted = targets(page)
    assert tomllib.loads(saved.read_text())["target"] == wanted
    page.open(of_file("star"))
    page.type((Keys.CONTROL, "o"))
    page.type(saved.name, Keys.ENTER)
    assert targets(page) == wanted, (targets(page), wanted)
    checked("saved as a download, and opened again after a reload")

    page.point(page.place(0.2, 0.8))
    page.type("p")
    page.point(page.place(0.25, 0.75))
    wanted = targets(page)
    stored = "return Object.keys(localStorage).some(key => key.includes('recovery'))"
    until(lambda: page.script(stored), "what is unsaved in the storage")
    page.open(forget=False)
    page.type(Keys.ENTER)
    assert targets(page) == wanted, (targets(page), wanted)
    checked("a reopened page offers the unsaved scene")
    page.open()
    frames_beside_work(page)
    streams_to_a_board(page)
    assert not page.log(), page.log()


def frames_beside_work(page):
    """The page draws frames while its worker solves."""
    page.script("location.hash = arguments[0]", of_file("heart-and-hit"))
    until(lambda: page.shown()["busy"], "work")
    before = page.frames()
    while page.shown()["busy"]:
        ActionChains(page.driver, duration=20).move_by_offset(3, 0).move_by_offset(-3, 0).perform()
    drawn = page.frames() - before
    assert drawn > 5, drawn
    checked(f"{drawn} frames drawn during the solution of a heart around HIT")


def streams_to_a_board(page):
    """The Device page: a port from the browser's chooser, a stand-in with an emulated native board; then a drag."""
    stand_in = Path(__file__).with_name("stand-in.js").read_text().replace("export class", "class")
    source = {"source": f"{{ {stand_in}\n window.standIn = new StandIn().install(); }}"}
    page.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", source)
    page.open(of_file("focus-centre"))
    page.driver.execute_async_script("""
        const done = arguments[0];
        import("./sonoglyph.js").then(program => { window.standIn.port.board = window.board = new program.Board("native"); done(); });
    """)
    page.run("device panel")
    page.point(CHOOSE, settle=False)
    time.sleep(1.5)
    # It connects to the port that was allowed.
    page.type((Keys.CONTROL, "p"), "send to the board", Keys.ENTER, Keys.ENTER, settle=False)
    # Amplitude and phase alternate; with the envelope it sounds half of the time.
    sounding = "return board.playing().filter((value, n) => n % 2 === 0 && value > 0).length"
    until(lambda: page.script(sounding) == 256, "256 elements that sound")
    time.sleep(0.5)
    page.script("board.frames()")
    page.point(page.place(0.5, 0.5), page.place(0.6, 0.55), page.place(0.7, 0.65), press=True, settle=False)
    moved = until(lambda: page.script("return board.frames()"), "frames of a drag")
    page.type((Keys.CONTROL, "p"), "stop the board", Keys.ENTER, settle=False)
    until(lambda: all(page.script(sounding) == 0 for _ in range(20)), "silence")
    checked(f"a board at a port sounds with 256 elements, follows a drag and falls silent (at least {moved} frames)")


def by_its_gpu(page, folder):
    """Maps by WebGPU, here on a software adapter, which the page uses only on request."""
    page.open(of_file("five-points"))
    assert page.shown()["evaluator"].startswith("CPU, SIMD128"), page.shown()["evaluator"]
    page.address += "?gpu=any"
    page.open(of_file("two-boards"))
    assert page.shown()["evaluator"] == "WebGPU", page.shown()["evaluator"]
    assert compare(page, folder, "two-boards by WebGPU") < TOLERANCE
    page.point(page.place(0.5, 0.5), page.place(0.55, 0.6), page.place(0.6, 0.7), press=True)
    assert compare(page, folder, "after a drag by WebGPU") < TOLERANCE
    assert page.shown()["evaluator"] == "WebGPU", page.shown()["evaluator"]
    assert not page.log(), page.log()


def main():
    with server() as address, tempfile.TemporaryDirectory() as folder:
        downloads = Path(folder) / "downloads"
        downloads.mkdir()
        for number, (use, flags) in enumerate([(by_pointer_and_keys, []), (by_its_gpu, ["enable-unsafe-webgpu"])]):
            page = Page(address, downloads, Path(folder) / f"profile-{number}", flags)
            try:
                use(page, folder)
            except BaseException:
                page.driver.save_screenshot("target/web/failed.png")
                print("screenshot of the failure: target/web/failed.png", *page.log(), sep="\n", file=sys.stderr)
                raise
            finally:
                page.driver.quit()
    print(f"web/check: {len(CHECKED)} checks passed in headless Chromium")


if __name__ == "__main__":
    main()
