"""The field of the same array by levitate and by Sonoglyph: time and error at 10 000 points.

levitate 3.0 (Andersson and Ahrens) needs numpy < 1.24 and scipy < 1.17.

    python levitate_comparison.py
"""

# %%
import json
import time

import levitate
import numpy as np
import sonoglyph as sg
from scipy.special import j1

POINTS, SIDE, PITCH, RADIUS, FREQUENCY, STRENGTH = 10_000, 16, 10.5e-3, 5e-3, 40e3, 3.4

# %% One array, one medium without absorption, one drive.
air = levitate.materials.air
transducer = levitate.transducers.CircularPiston(effective_radius=RADIUS, freq=FREQUENCY, p0=STRENGTH, physical_size=PITCH)
theirs = levitate.arrays.RectangularArray(shape=SIDE, spread=PITCH, transducer=transducer)
ours = sg.Scene(
    targets=[sg.Point((0, 0, 0.1))],
    array=sg.Array(rows=SIDE, columns=SIDE, pitch=PITCH, element_radius=RADIUS, frequency=FREQUENCY, strength=STRENGTH),
    medium=sg.Medium(sound_speed=air.c, density=air.rho, absorption=0.0),
)
# levitate may number elements in another order.
places = theirs.positions.T
order = [int(np.argmin(np.linalg.norm(places - place, axis=1))) for place in ours.positions]
assert sorted(order) == list(range(SIDE * SIDE)) and np.abs(places[order] - ours.positions).max() < 1e-12

random = np.random.default_rng(7)
u = np.exp(2j * np.pi * random.random(SIDE * SIDE))
points = random.uniform([-0.08, -0.08, 0.06], [0.08, 0.08, 0.25], (POINTS, 3))

# %% The expected result: the formula, in more than double precision where available.
def formula(points):
    offset = points[:, None].astype(np.longdouble) - ours.positions[None]
    r = np.sqrt((offset**2).sum(axis=2))
    k = 2 * np.longdouble("3.14159265358979323846264338327950288") * np.longdouble(FREQUENCY) / np.longdouble(air.c)
    x = (k * RADIUS * np.sqrt(offset[..., 0] ** 2 + offset[..., 1] ** 2) / r).astype(float)
    pattern = np.where(x > 1e-9, 2 * j1(x) / np.maximum(x, 1e-12), 1.0)
    phase = np.remainder(k * r, 2 * np.longdouble("3.14159265358979323846264338327950288"))
    return (STRENGTH * pattern / r * (np.sin(phase) + 1j * np.cos(phase)) * u).sum(axis=1).astype(complex)


some = random.choice(POINTS, 500, replace=False)
exact = formula(points[some])


# %% Each with its usual call.
def by_levitate():
    state = np.empty(SIDE * SIDE, complex)
    # levitate uses exp(+jkr).
    state[order] = u.conj()
    parts = np.array_split(points, 10)
    return 1j * np.concatenate([theirs.pressure_derivs(part.T, orders=0)[0].T @ state for part in parts]).conj()


def by_sonoglyph():
    return ours.pressure(points, u)


def timed(work, repeats):
    work()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        made = work()
        times.append(time.perf_counter() - start)
    return float(np.median(times)), made


def error(values):
    """The largest error relative to the largest pressure."""
    return float(np.abs(values[some] - exact).max() / np.abs(exact).max())


result = {"points": POINTS, "elements": SIDE * SIDE}
for name, work, repeats in (("levitate", by_levitate, 5), ("sonoglyph", by_sonoglyph, 50)):
    seconds, made = timed(work, repeats)
    result[name] = {"milliseconds": 1e3 * seconds, "error": error(made)}
result["faster"] = result["levitate"]["milliseconds"] / result["sonoglyph"]["milliseconds"]
print(json.dumps(result, indent=2))
