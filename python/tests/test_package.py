"""The package against the command line (bit for bit), against NumPy models, and its limits."""

import ast
import dataclasses
import json
import os
import pathlib
import pickle
import re
import signal
import struct
import subprocess
import threading
import time

import numpy as np
import pytest
import sonoglyph as sg

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENES = ROOT / "assets" / "scenes"
FIVE = [(0.03 * x, 0.03 * y, 0.1) for x, y in ((0, 0), (1, 1), (-1, 1), (1, -1), (-1, -1))]


def program():
    """The command line as built by the checks."""
    named = os.environ.get("SONOGLYPH", ROOT / "target" / "debug" / "sonoglyph")
    assert pathlib.Path(named).exists(), f"{named}: build the command line, or name it in SONOGLYPH"
    return str(named)


def run(*arguments):
    return subprocess.run([program(), *map(str, arguments)], check=True, capture_output=True, text=True).stdout


def five(**tables):
    return sg.Scene(targets=[sg.Point(at) for at in FIVE], **tables)


# --- against the command line


@pytest.mark.parametrize("name", ["hit", "five-points", "two-boards", "water-circle"])
def test_drives_equal_the_command_lines_to_the_last_bit(name):
    path = SCENES / f"{name}.toml"
    assert path.exists()
    told = json.loads(run("solve", path, "--json"))
    solution = sg.Scene.load(path).solve()
    assert np.array_equal(solution.phases, told["phases"])
    assert np.array_equal(solution.amplitudes, told["amplitudes"])
    assert solution.nonlinear == told.get("nonlinear")
    mine, theirs = dict(solution.quality), dict(told["quality"])
    theirs.pop("widths")
    assert mine == theirs
    assert np.array_equal(solution.foci, [focus["position"] for focus in told["foci"]])


@pytest.mark.parametrize(
    ("name", "quantity"),
    [("hit", "rms"), ("five-points", "phase"), ("five-points", "intensity"), ("two-boards", "rms"), ("water-circle", "depression")],
)
@pytest.mark.parametrize("evaluator", ["cpu", "reference"])
def test_maps_equal_the_command_lines_to_the_last_bit(name, quantity, evaluator, tmp_path):
    path = SCENES / f"{name}.toml"
    data, size = tmp_path / "map.npy", (97, 64)
    wanted = ["--quantity", quantity, "--size", "97x64", "--backend", evaluator]
    run("render", path, "-o", tmp_path / "map.png", "--data", data, *wanted)
    made = sg.Scene.load(path).field(quantity, size, evaluator=evaluator)
    assert made.dtype == np.float32 and made.shape == (64, 97)
    assert np.array_equal(made, np.load(data))


def test_frames_equal_the_command_lines(tmp_path):
    scene = five(motion=sg.MotionPath(path="circle", size=0.01, frames=6, rate=2))
    path = tmp_path / "scene.toml"
    scene.save(path)
    told = json.loads(run("solve", path, "--motion", "--json"))
    frames = scene.frames()
    assert len(frames) == 6 and frames.rate == 12 and np.allclose(frames.times, np.arange(6) / 12)
    assert np.array_equal(frames.phases, [frame["phases"] for frame in told["frames"]])


def test_what_is_felt_equals_the_command_lines(tmp_path):
    scene = five(skin=sg.Skin(viscosity=2.0), modulation=sg.Modulation(shape="sine", frequency=150.0))
    path = tmp_path / "scene.toml"
    scene.save(path)
    felt = scene.solve().felt
    assert felt is not None and felt["level"] > 0 and felt == json.loads(run("solve", path, "--json"))["felt"]
    assert five().solve().felt is None


# --- against NumPy models


def transfer(points, positions, scene):
    """Far field of baffled pistons, in f64: S·2 J1(x)/x·e^(-αr)·j e^(-jkr)/r."""
    table = scene.to_dict()
    array, medium = table["array"], table["medium"]
    k = 2 * np.pi / scene.wavelength
    offset = points[:, None] - positions[None]
    r = np.linalg.norm(offset, axis=2)
    x = k * array["element_radius"] * np.hypot(offset[..., 0], offset[..., 1]) / r
    # 2 J1(x)/x by its integral: (2/π) ∫ cos(x cos θ) sin²θ dθ over half a turn.
    nodes, weights = np.polynomial.legendre.leggauss(40)
    theta = np.pi * (nodes + 1) / 2
    pattern = np.tensordot(np.cos(x[..., None] * np.cos(theta)), weights * np.sin(theta) ** 2, 1) * (np.pi / 2) * (2 / np.pi)
    decay = np.exp(-medium["absorption"] * np.log(10) / 20 * r)
    return array["strength"] * pattern * decay * 1j * np.exp(-1j * k * r) / r


def plain():
    return five(medium=sg.Medium(sound_speed=343.0, density=1.2, absorption=1.3), plane=sg.Plane(tolerance=1e-4))


def test_pressures_agree_with_a_model():
    scene = plain()
    random = np.random.default_rng(1)
    points = random.uniform([-0.1, -0.1, 0.05], [0.1, 0.1, 0.3], (3, 7, 3))
    u = np.exp(2j * np.pi * random.random(256)) * random.random(256)
    model = transfer(points.reshape(-1, 3), scene.positions, scene) @ u
    made = scene.pressure(points, u)
    assert made.shape == (3, 7) and made.dtype == np.complex128
    assert np.abs(made.ravel() - model).max() < 1e-11 * np.abs(model).max()
    assert np.abs(scene.transfer(points) @ u - model).max() < 1e-11 * np.abs(model).max()
    half = np.pi / 2 + 0.0
    assert np.allclose(scene.pressure(points, np.full(256, half)), scene.pressure(points, np.full(256, 1j)))


def test_maps_keep_their_tolerance_against_a_model():
    scene, (w, h) = plain(), (60, 40)
    solution = scene.solve()
    x, y = ((np.arange(n) + 0.5) / n - 0.5 for n in (w, h))
    points = np.stack(np.broadcast_arrays(0.2 * x[None], 0.2 * y[:, None], 0.1), axis=-1).reshape(-1, 3)
    u = solution.amplitudes * np.exp(1j * solution.phases)
    model = np.abs(transfer(points, scene.positions, scene) @ u).reshape(h, w) / np.sqrt(2)
    for evaluator in ("cpu", "reference"):
        made = scene.map("rms", (w, h), solution, evaluator=evaluator)
        error = np.abs(made.values - model).max() / model.max()
        assert error < 1e-4 and made.error < 1e-4, (evaluator, error)
        assert made.peak == made.values.max() and made.unit == "Pa"
    assert np.array_equal(solution.excitations[0], u)


def test_volumes_are_maps_layer_by_layer():
    scene = plain()
    solution = scene.solve()
    corners = ((-0.05, -0.04, 0.06), (0.05, 0.04, 0.12))
    volume = scene.volume((10, 8, 3), "rms", corners, solution)
    assert volume.shape == (3, 8, 10) and volume.dtype == np.float32
    x, y, z = (np.linspace(a, b, 2 * n + 1)[1::2] for a, b, n in zip(*corners, (10, 8, 3)))
    points = np.stack(np.meshgrid(z, y, x, indexing="ij")[::-1], axis=-1)
    exact = np.abs(scene.pressure(points, solution)) / np.sqrt(2)
    assert np.abs(volume - exact).max() < 1.1e-4 * exact.max()


def test_forces_are_slopes_of_the_potential():
    scene = sg.Scene(targets=[sg.Trap((0, 0, 0.1))])
    solution = scene.solve()
    at, step = np.array([0.0004, -0.0003, 0.1002]), 2e-6
    found = scene.force(at, solution)
    assert found["gorkov"].shape == () and found["force"].shape == (3,) and found["stiffness"].shape == (3, 3)
    around = at + step * np.concatenate([np.eye(3), -np.eye(3)])
    there = scene.force(around, solution)
    stiffness = -(there["force"][:3] - there["force"][3:]).T / (2 * step)
    assert np.abs(stiffness - found["stiffness"]).max() < 1e-3 * np.abs(stiffness).max()


def test_drives_in_turn_have_a_mean():
    scene = plain()
    a, b = np.random.default_rng(2).uniform(-3, 3, (2, 256))
    both = scene.field("rms", (32, 32), np.stack([a, b]), evaluator="reference").astype(float)
    single = [scene.field("rms", (32, 32), drive, evaluator="reference").astype(float) for drive in (a, b)]
    assert np.allclose(both, np.sqrt((single[0] ** 2 + single[1] ** 2) / 2), rtol=1e-5)


def packed(values, kind):
    """A column of a structured array without padding, so misaligned."""
    table = np.zeros(len(values), dtype=[("off", "?"), ("value", kind)])
    table["value"] = values
    return table["value"]


def test_every_layout_of_numbers_is_a_drive_and_a_point():
    scene = plain()
    phases = np.random.default_rng(4).uniform(-3, 3, (3, 256)).astype("f4").astype(float)
    u = (0.9 * np.exp(1j * phases)).astype("c8")
    field = lambda drive: scene.field("rms", (24, 24), drive)
    table = np.concatenate([np.zeros((3, 2)), phases], axis=1)
    for layout in (table[:, 2:], np.asfortranarray(phases), phases.astype(">f8"), phases.astype("f4"), phases.tolist()):
        assert np.array_equal(field(layout), field(phases))
    one = phases[0]
    for layout in (packed(one, "f8"), one[::-1].copy()[::-1], np.stack([one, one], axis=1)[:, 1], tuple(one)):
        assert np.array_equal(field(layout), field(one))
    for layout in (u, u.astype(">c8"), np.repeat(u, 2, axis=1)[:, ::2], u.tolist()):
        assert np.array_equal(field(layout), field(u.astype(complex)))
    # Of modulus 1 but for rounding.
    assert np.allclose(field(np.exp(1j * one).astype("c8")), field(one), rtol=1e-5, atol=1e-2)
    points = np.random.default_rng(5).uniform(0.05, 0.1, (4, 3))
    assert np.array_equal(scene.pressure(packed(points, ("f8", 3)), one), scene.pressure(points, one))


def test_own_drives_are_played_and_judged(tmp_path):
    phases = np.random.default_rng(6).uniform(-3, 3, 256)
    rows = [f"{element};{phase!r};0.5\n" for element, phase in enumerate(phases.tolist())]
    (tmp_path / "own.csv").write_text("element;phase;amplitude\n" + "".join(reversed(rows)))
    text = "format = 1\n[[target]]\nat = [0.01, 0, 0.1]\n"
    scene = sg.Scene.loads(text, folder=tmp_path)
    named = sg.Scene.loads("drive = 'own.csv'\n" + text, folder=tmp_path)
    u = 0.5 * np.exp(1j * phases)
    at = scene.transfer([(0.01, 0, 0.1)])[0] @ u
    for judged in (scene.solve(drive=u), scene.solve(drive="own.csv"), named.solve()):
        assert judged.method == "drive" and np.allclose(judged.phases, phases)
        assert np.isclose(judged.quality["mean_pressure"], abs(at))
    assert np.array_equal(scene.field(size=16, drive="own.csv"), named.field(size=16))
    assert np.isclose(scene.pressure((0.01, 0, 0.1), "own.csv"), at)
    assert named.solve("naive").method == "naive"
    with pytest.raises(ValueError, match="gone.csv"):
        scene.field(drive="gone.csv")
    with pytest.raises(ValueError, match="nothing is solved"):
        scene.solve("naive", drive=u)


# --- scenes


def test_classes_dictionaries_and_files_are_one_scene(tmp_path):
    classes = sg.Scene(
        targets=[sg.Circle((0, 0, 0.1), 0.02, pressure=2), sg.Line((0, 0, 0.1), np.array([0.01, 0, 0.1]), points=3)],
        array=sg.Array(rows=8, columns=np.int64(10), off=[3, 4]),
        boards=[sg.Board(), sg.Board(at=(0, 0, 0.3), normal=(0, 0, -1))],
        liquid=sg.Liquid(name="glycerol"),
    )
    tables = sg.Scene.from_dict(
        {
            "target": [
                {"kind": "circle", "at": [0, 0, 0.1], "radius": 0.02, "pressure": 2.0},
                {"kind": "line", "from": [0, 0, 0.1], "to": [0.01, 0, 0.1], "points": 3},
            ],
            "array": {"rows": 8, "columns": 10, "off": [3, 4]},
            "board": [{}, {"at": [0, 0, 0.3], "normal": [0, 0, -1]}],
            "liquid": {"name": "glycerol"},
        }
    )
    path = tmp_path / "scene.toml"
    classes.save(path)
    assert classes == tables == sg.Scene.load(path) == sg.Scene.loads(classes.dumps())
    assert classes == sg.Scene.from_dict(classes.to_dict()) == pickle.loads(pickle.dumps(classes))
    other = classes.replace(array={"rows": 9}, targets=[sg.Point((0, 0, 0.1))])
    table = other.to_dict()
    assert (table["array"]["rows"], table["array"]["columns"], len(table["target"])) == (9, 10, 1)
    assert other != classes and classes.to_dict()["array"]["rows"] == 8
    assert classes.positions.shape == classes.normals.shape == (160, 3)


def test_files_named_by_a_scene_are_found_beside_it(tmp_path):
    (tmp_path / "elements.csv").write_text("x,y,z,nx,ny,nz\n0,0,0,0,0,1\n0.01,0,0,0,0,1\n")
    (tmp_path / "scene.toml").write_text('format = 1\n[array]\nelements = "elements.csv"\n[[target]]\nat = [0, 0, 0.1]\n')
    loaded = sg.Scene.load(tmp_path / "scene.toml")
    assert loaded.positions.shape == (2, 3)
    assert pickle.loads(pickle.dumps(loaded)) == loaded
    assert sg.Scene.loads(loaded.dumps(), folder=tmp_path) == loaded
    with pytest.raises(sg.SceneError, match="elements.csv"):
        sg.Scene.loads(loaded.dumps())


def test_bodies_are_tables_of_a_scene(tmp_path):
    (tmp_path / "part.obj").write_text("v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
    palm = sg.Body(kind="palm", at=(0, 0, 0.3), normal=(0, 0.2, -1))
    part = sg.Body(kind="mesh", file="part.obj", scale=0.001, at=(0, 0, 0.15))
    scene = sg.Scene(bodies=[palm, part], folder=tmp_path)
    assert scene.dumps().count("[[body]]") == 2 and sg.Scene.loads(scene.dumps(), folder=tmp_path) == scene
    with pytest.raises(sg.SceneError, match="millimetres"):
        sg.Scene(bodies=[sg.Body(kind="mesh", file="part.obj", at=(0, 0, 0.15))], folder=tmp_path)
    with pytest.raises(sg.SceneError, match="no such key"):
        sg.Scene(bodies=[sg.Body(kind="palm", radius=0.01)])


def test_bodies_are_pushed_and_nothing_is_within():
    array = sg.Array(rows=6, columns=6)
    scene = sg.Scene(
        array=array, targets=[sg.Point(at=(0, 0, 0.06))], plane=sg.Plane(centre=(0, 0, 0.06), size=(0.04, 0.04)),
        bodies=[sg.Body(at=(0.006, 0, 0.06), radius=0.004)],
    )  # fmt: skip
    solution = scene.solve()
    [body] = solution.bodies
    force = np.array(body["force"])
    assert body["kind"] == "sphere" and body["triangles"] == 0 and 1e-7 < np.linalg.norm(force) < 1e-2
    assert np.allclose(scene.body_forces()[0]["force"], force)
    quarter = sg.Scene.body_forces(scene, 0.5 * solution.excitations)[0]
    assert np.allclose(quarter["force"], force / 4, rtol=1e-3)
    field = solution.field("rms", (80, 80))
    x, y = np.meshgrid(*[(np.arange(80) + 0.5) / 80 * 0.04 - 0.02] * 2)
    assert np.array_equal(np.isnan(field), np.hypot(x - 0.006, y) < 0.004)
    inside, outside = scene.pressure([(0.006, 0, 0.06), (0, 0, 0.06)])
    assert np.isnan(inside) and np.isfinite(outside)
    assert np.isnan(scene.force([(0.006, 0, 0.0642)])["force"]).all()
    assert sg.Scene(array=array, targets=[sg.Point(at=(0, 0, 0.06))]).solve().bodies == []


def test_solutions_survive_pickling():
    solution = five().solve()
    again = pickle.loads(pickle.dumps(solution))
    assert np.array_equal(again.phases, solution.phases) and again.quality == solution.quality
    assert again.scene == solution.scene


def test_classes_have_the_keys_of_the_scene_file():
    document = (ROOT / "docs" / "scene.md").read_text()
    tables = {
        "medium": sg.Medium, "array": sg.Array, "board": sg.Board, "reflector": sg.Reflector, "solver": sg.Solver,
        "plane": sg.Plane, "liquid": sg.Liquid, "bead": sg.Bead, "modulation": sg.Modulation, "motion": sg.MotionPath,
        "listener": sg.Listener, "quiet": sg.Quiet, "body": sg.Body,
    }  # fmt: skip
    def keys(table):
        return {field.name.rstrip("_") for field in dataclasses.fields(table)}
    for name, table in tables.items():
        documented = set(re.findall(rf"^\| `{name}\.(\w+)` \|", document, re.MULTILINE))
        kinds = {"radius", "width", "height", "sides"} if name == "quiet" else set()
        assert keys(table) == documented | kinds, name
    kinds = dict(re.findall(r"^\| `(\w+)` \| (`.*) \|$", document.split("## Quiet zones")[0], re.MULTILINE))
    targets = [sg.Point, sg.Line, sg.Circle, sg.Rectangle, sg.Triangle, sg.Polygon, sg.Path, sg.Text, sg.Picture, sg.Trap, sg.Direction]
    assert {target.kind for target in targets} == set(kinds)
    common = set(re.findall(r"^\| `target\.(\w+)` \|", document, re.MULTILINE)) - {"kind"}
    assert set().union(*(keys(target) for target in targets)) == common | {
        key for listed in kinds.values() for key in re.findall(r"`(\w+)`", listed)
    }
    for target in targets:
        assert set(re.findall(r"`(\w+)`", kinds[target.kind])) <= keys(target), target


# --- limits


@pytest.mark.parametrize(
    ("make", "key", "said"),
    [
        (lambda: sg.Scene(array=sg.Array(pitch=-1)), "array.pitch", "array.pitch = -1"),
        (lambda: sg.Scene(targets=[sg.Point((0, 0, -1))]), "target[1]", "target[1]"),
        (lambda: sg.Scene(array={"colour": 3}), "array.colour", "colour"),
        (lambda: sg.Scene(colour=3), "colour", "colour"),
        (lambda: sg.Scene.loads("format = 1\n[array]\nrows = 0\n"), "array.rows", "array.rows = 0"),
        (lambda: sg.Scene().solve(), "target", "no target"),
        (lambda: five().solve("focus"), "solver.method", "focus"),
        (lambda: five().solve(search=-1), "solver.search", "solver.search"),
    ],
)
def test_errors_of_invalid_scenes_name_the_key(make, key, said):
    with pytest.raises(sg.SceneError, match=re.escape(said)) as raised:
        make()
    assert raised.value.key == key
    assert isinstance(raised.value, ValueError)


@pytest.mark.parametrize(
    ("call", "kind", "said"),
    [
        (lambda s: s.field("sound"), ValueError, "rms"),
        (lambda s: s.field(size=(0, 3)), sg.FieldError, "0 x 3"),
        (lambda s: s.field(evaluator="best"), ValueError, "reference"),
        (lambda s: s.field(tolerance=-1.0), sg.FieldError, "tolerance"),
        (lambda s: s.field(drive=np.zeros(7)), ValueError, "7 elements"),
        (lambda s: s.field(drive=np.full(256, np.nan)), ValueError, "finite"),
        (lambda s: s.field(drive=np.full(256, 2 + 0j)), ValueError, "modulus 1"),
        (lambda s: s.field(drive=np.zeros((0, 256))), ValueError, "drive"),
        (lambda s: s.field(drive=np.zeros((2, 2, 64))), ValueError, "drives, elements"),
        (lambda s: s.solve("fastest"), ValueError, "gspat"),
        (lambda s: s.pressure([1, 2]), ValueError, r"\.\.\., 3"),
        (lambda s: s.pressure([[np.nan, 0, 0]]), ValueError, "metres"),
        (lambda s: s.volume((0, 1, 1)), ValueError, "counts"),
        (lambda s: s.volume((2, 2, 2), "depression"), ValueError, "no volume"),
        (lambda s: s.volume((2, 2, 2), box=((0, 0, 0), (0, 1, 1))), ValueError, "corners"),
        (lambda s: s.map().png("pink"), ValueError, "viridis"),
        (lambda s: sg.Scene(array={"rows": object()}), TypeError, "array.rows"),
        (lambda s: sg.Scene(array={"pitch": float("nan")}), TypeError, "finite"),
        (lambda s: sg.Scene.load("nowhere.toml"), FileNotFoundError, "nowhere.toml"),
        (lambda s: s.save(ROOT / "nowhere" / "scene.toml"), OSError, "nowhere"),
    ],
)
def test_bad_arguments_are_refused_with_the_allowed_values(call, kind, said):
    with pytest.raises(kind, match=said):
        call(five())


def test_results_are_not_copied():
    values = five().field(size=(64, 64))
    assert values.flags.c_contiguous and values.flags.writeable and not values.flags.owndata
    # A view of one owner: Rust's memory, which lives as long as the array.
    owner = values
    while isinstance(owner, np.ndarray) and owner.base is not None:
        owner = owner.base
    assert type(owner).__name__ == "Values"
    kept = values.copy()
    five().field("phase", size=(64, 64))
    assert np.array_equal(values, kept)
    made = five().map(size=(64, 64))
    assert np.shares_memory(np.asarray(made), made.values)


def test_notebook_pictures_are_png():
    scene = five()
    for shown in (scene, scene.solve(), scene.map("phase", 64)):
        png = shown._repr_png_()
        assert png[:8] == b"\x89PNG\r\n\x1a\n"
        assert struct.unpack(">II", png[16:24])[0] in (64, 360)
    assert sg.Scene()._repr_png_() is None
    assert "5 targets" in repr(scene) and "best" in repr(scene.solve()) and "RMS" in repr(scene.map("rms", 16))


def test_ctrl_c_ends_long_work_while_other_threads_run():
    scene = five()
    # Ignored where the tests run in the background.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    ticks = []
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    ticking = threading.Thread(target=lambda: [ticks.append(time.sleep(0.01)) for _ in range(20)])
    timer.start()
    ticking.start()
    with pytest.raises(KeyboardInterrupt):
        scene.solve(search=3600)
    ticking.join()
    assert len(ticks) == 20
    assert scene.solve().phases.shape == (256,), "the next call is as ever"


def test_ctrl_c_ends_a_loop_of_brief_calls():
    scene, drives = five(), np.random.default_rng(5).uniform(-3, 3, (50, 256))
    signal.signal(signal.SIGINT, signal.default_int_handler)
    threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        for turn in range(10**9):
            scene.solve()
            scene.field(size=(32, 32), drive=drives[turn % 50])


def test_brief_calls_equal_those_with_progress():
    scene, told = five(), []
    for drive in np.random.default_rng(6).uniform(-3, 3, (6, 256)):
        brief = scene.field(size=(48, 48), drive=drive)
        assert np.array_equal(brief, scene.field(size=(48, 48), drive=drive + 0, progress=told.append))
    assert np.array_equal(scene.solve().phases, scene.solve(progress=told.append).phases)


def test_memory_is_used_again_only_after_its_array_is_gone():
    scene, drives = five(), np.random.default_rng(8).uniform(-3, 3, (4, 256))
    made = [scene.field(size=(90, 70), drive=drive) for drive in drives]
    kept = [values.copy() for values in made]
    assert len({values.ctypes.data for values in made}) == 4
    part = made.pop()[3:5]
    freed = made.pop(0).ctypes.data
    again = scene.field(size=(90, 70), drive=drives[0])
    assert again.ctypes.data == freed and np.array_equal(again, kept[0])
    assert np.array_equal(part, kept[3][3:5]), "a view keeps the memory"
    assert all(np.array_equal(a, b) for a, b in zip(made, kept[1:]))


def test_progress_is_reported_and_its_exceptions_propagate():
    scene, drive, told = five(), np.zeros(256), []
    scene.field(size=(300, 300), drive=drive, evaluator="reference", progress=told.append)
    assert told and all(0 <= part <= 1 for part in told) and told == sorted(told)

    def stop(part):
        raise LookupError(part)

    with pytest.raises(LookupError):
        scene.field(size=(400, 400), drive=drive, evaluator="reference", progress=stop)
    assert scene.field(size=(8, 8), drive=drive).shape == (8, 8)


def test_threads_get_equal_results():
    scene = five()
    drives = np.random.default_rng(3).uniform(-3, 3, (8, 256))
    alone = [scene.field(size=(40, 40), drive=drive) for drive in drives]
    made = [None] * 8

    def work(index):
        for _ in range(5):
            made[index] = scene.field(size=(40, 40), drive=drives[index])

    threads = [threading.Thread(target=work, args=(index,)) for index in range(8)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert all(np.array_equal(a, b) for a, b in zip(alone, made))


def test_threads_solve_map_and_read_at_once():
    scenes = [five(), sg.Scene(targets=[sg.Point((0, 0, 0.1))])]
    scenes.append(sg.Scene(targets=[sg.Circle((0, 0, 0.1), 0.02)], array=sg.Array(rows=8, columns=8)))
    points = np.random.default_rng(7).uniform([-0.1, -0.1, 0.05], [0.1, 0.1, 0.3], (300, 3))

    def results(scene):
        solution = scene.solve()
        return solution.phases, solution.field("rms", (40, 40)), scene.pressure(points, solution)

    alone = [results(scene) for scene in scenes]
    made = {}

    def work(index):
        made[index] = [results(scenes[(index + turn) % 3]) for turn in range(3)]

    threads = [threading.Thread(target=work, args=(index,)) for index in range(6)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    for index, turns in made.items():
        for turn, found in enumerate(turns):
            assert all(np.array_equal(a, b) for a, b in zip(alone[(index + turn) % 3], found))
    assert len(made) == 6


def test_evaluators_are_listed_and_used():
    names = [name for name, _ in sg.evaluators()]
    assert names[-2:] == ["cpu", "reference"]
    if "gpu" in names:
        by_gpu, by_cpu = (five().map(size=100, evaluator=name) for name in ("gpu", "cpu"))
        assert np.abs(by_gpu.values - by_cpu.values).max() < 2e-3 * by_cpu.peak
    else:
        assert "gpu" not in os.environ.get("SONOGLYPH_REQUIRE", "")
        with pytest.raises(sg.GpuError):
            five().map(size=100, evaluator="gpu")


def test_the_bench_gives_times_and_errors():
    rows = sg.bench(sizes=(64,), repeats=2)
    assert [row["work"] for row in rows] == ["solve", "map"]
    assert all(row["seconds"] > 0 for row in rows) and 0 < rows[1]["error"] < 1e-3


def test_stubs_list_the_native_members():
    tree = ast.parse((pathlib.Path(sg.__file__).parent / "_native.pyi").read_text())
    for node in tree.body:
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            members = {item.name for item in node.body if isinstance(item, ast.FunctionDef)}
            there = {name for name in vars(getattr(sg, node.name)) if not name.startswith("_")}
            assert {name for name in members if not name.startswith("_")} == there, node.name
