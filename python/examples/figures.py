"""The paper's kind of figures: fields, phases and depressions of points, shapes and letters, drawn by matplotlib.

    python figures.py [FOLDER]
"""

# %%
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import sonoglyph as sg

folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
folder.mkdir(parents=True, exist_ok=True)
at = (0, 0, 0.1)


def show(axes, map, title, label, scale=1.0, colours="inferno"):
    """A map with a colour bar, lengths in mm."""
    extent = [1e3 * edge for edge in map.extent]
    image = axes.imshow(scale * map.values, extent=extent, origin="lower", cmap=colours)
    axes.set(title=title, xlabel="x (mm)", ylabel="y (mm)")
    axes.figure.colorbar(image, ax=axes, label=label, shrink=0.8)


# %% RMS pressure of a point, of four points, and of a word as one continuous stroke.
scenes = {
    "one focal point": sg.Scene(targets=[sg.Point(at)]),
    "four focal points": sg.Scene(targets=[sg.Point((0.02 * x, 0.02 * y, 0.1)) for x in (-1, 1) for y in (-1, 1)]),
    "a word": sg.Scene(targets=[sg.Text("HIT", at, height=0.05)]),
}
figure, rows = plt.subplots(2, 3, figsize=(13, 8), layout="constrained")
for column, (title, scene) in zip(rows.T, scenes.items()):
    solution = scene.solve()
    show(column[0], solution.map("rms", 400), title, "RMS pressure (Pa)")
    show(column[1], solution.map("phase", 400), f"phases of {title}", "phase (rad)", colours="twilight")
figure.savefig(folder / "fields.png", dpi=120)

# %% Depressions of water by shapes.
shapes = {
    "circle": sg.Circle(at, 0.02),
    "triangle": sg.Triangle(at, 0.045),
    "heart": sg.Path([(0.022 * np.sin(t) ** 3, 0.0014 * (13 * np.cos(t) - 5 * np.cos(2 * t) - 2 * np.cos(3 * t) - np.cos(4 * t)), 0.1)
                      for t in np.linspace(0, 2 * np.pi, 48, endpoint=False)], closed=True),
}  # fmt: skip
figure, columns = plt.subplots(1, 3, figsize=(13, 4), layout="constrained")
for axes, (name, shape) in zip(columns, shapes.items()):
    scene = sg.Scene(targets=[shape], plane=sg.Plane(size=(0.1, 0.1)))
    show(axes, scene.map("depression", 400), name, "depression (µm)", 1e6, "viridis")
figure.savefig(folder / "depressions.png", dpi=120)

# %% Pressure per point against the number of points, by method.
counts = (1, 2, 4, 8, 16, 32, 64)
random = np.random.default_rng(0)
places = np.column_stack([random.uniform(-0.06, 0.06, (64, 2)), np.full(64, 0.12)])
figure, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
for method in ("naive", "gspat", "wgs", "best"):
    qualities = [sg.Scene(targets=[sg.Point(p) for p in places[:count]]).solve(method).quality for count in counts]
    axes.plot(counts, [q["min_pressure"] / q["mean_pressure"] for q in qualities], "o-", label=method)
axes.set(xscale="log", xticks=counts, xticklabels=counts, xlabel="focal points", ylabel="weakest over mean pressure", ylim=(0, 1.02))
axes.legend()
figure.savefig(folder / "methods.png", dpi=120)

print(f"fields.png, depressions.png and methods.png are in {folder.resolve()}")
