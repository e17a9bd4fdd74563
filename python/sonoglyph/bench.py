"""Time against error on this machine."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np

from ._native import Scene


def bench(
    scene: Scene | None = None,
    sizes: Sequence[int] = (256, 512, 1024),
    evaluators: Sequence[str] = ("auto",),
    repeats: int = 9,
) -> list[dict[str, Any]]:
    """Times a solve and maps of new drives, and measures their error against the f64 reference.

    Returns a list of dictionaries: `work`, `evaluator`, `size`, `seconds` (median) and `error` (largest, relative to
    the peak, for a map of 128 x 128 pixels with the same evaluator and tolerance; None for the solve). `scene` is five
    points on a plane by default.
    """
    if scene is None:
        places = [(0.03 * x, 0.03 * y, 0.1) for x, y in ((0, 0), (1, 1), (-1, 1), (1, -1), (-1, -1))]
        scene = Scene(targets=[{"at": at} for at in places])
    solving, solution = _timed(lambda: scene.solve(), repeats)
    rows: list[dict[str, Any]] = [
        {"work": "solve", "evaluator": None, "size": None, "seconds": solving, "error": None}
    ]
    reference = scene.field("rms", 128, solution, evaluator="reference")
    for evaluator in evaluators:
        small = scene.field("rms", 128, solution, evaluator=evaluator)
        error = float(np.abs(small - reference).max() / reference.max())
        for size in sizes:
            # Each drive is new: only the plan is reused.
            turns = iter(range(repeats + 1))
            seconds, _ = _timed(
                lambda: scene.field("rms", size, solution.phases + 0.1 * next(turns), evaluator=evaluator), repeats
            )
            rows.append(
                {"work": "map", "evaluator": evaluator, "size": size, "seconds": seconds, "error": error}
            )
    return rows


def _timed(work: Any, repeats: int) -> tuple[float, Any]:
    """Median time without the first run, and the last result."""
    made = work()
    times = []
    for _ in range(repeats):
        start = perf_counter()
        made = work()
        times.append(perf_counter() - start)
    return median(times), made
