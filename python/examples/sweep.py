"""A sweep of 10 000 scenes on a local Dask cluster, with one worker and with two.

    python sweep.py [SCENES]
"""

# %%
import json
import os
import sys
import time

import numpy as np
import sonoglyph as sg

SCENES = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
CHUNK = 200


def chunk(numbers):
    """Two to eight random points per scene: number, points, mean pressure (Pa, peak), weakest over mean."""
    rows = []
    for number in numbers:
        random = np.random.default_rng(number)
        count = 2 + number % 7
        places = np.column_stack([random.uniform(-0.05, 0.05, (count, 2)), random.uniform(0.08, 0.2, count)])
        solution = sg.Scene(targets=[sg.Point(place) for place in places]).solve()
        pressures = np.abs(solution.pressures)
        rows.append((number, count, pressures.mean(), pressures.min() / pressures.mean()))
    return rows


def sweep(workers):
    """Seconds, and a table of all scenes."""
    from distributed import Client, LocalCluster

    cluster = LocalCluster(n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=None)
    with cluster, Client(cluster) as client:
        client.wait_for_workers(workers)
        # Every worker has imported and computed once.
        client.gather([client.submit(chunk, [SCENES + worker], pure=False) for worker in range(2 * workers)])
        start = time.perf_counter()
        parts = client.map(chunk, [range(first, min(first + CHUNK, SCENES)) for first in range(0, SCENES, CHUNK)])
        rows = [row for part in client.gather(parts) for row in part]
        return time.perf_counter() - start, np.array(rows)


# %%
if __name__ == "__main__":
    # One thread per worker, so that two workers share the machine fairly.
    os.environ["RAYON_NUM_THREADS"] = "1"
    one, table = sweep(1)
    two, again = sweep(2)
    assert np.array_equal(table, again) and len(table) == SCENES
    for count in range(2, 9):
        rows = table[table[:, 1] == count]
        print(f"{count} points: mean {rows[:, 2].mean():7.0f} Pa, weakest over mean {rows[:, 3].mean():.3f}")
    print(json.dumps({"scenes": SCENES, "one_worker_s": one, "two_workers_s": two, "ratio": one / two}))
