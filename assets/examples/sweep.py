#!/usr/bin/env python3
"""How strong the weaker of two foci, one above the other, can be, against their distance: a sweep by Dask.

    assets/examples/sweep.py > sweep.csv

Every task pipes eight scenes through one `sonoglyph batch`. Here the workers are processes of this machine; with
Client("scheduler:8786") in place of the local cluster they are those of as many machines as there are.
"""

import csv
import json
import os
import subprocess
import sys

from dask.distributed import Client, LocalCluster

SONOGLYPH = os.environ.get("SONOGLYPH", "sonoglyph")
SCENES_PER_TASK = 8


def scene(distance_mm):
    """Two foci about a height of 100 mm. At 200 mm this is no scene: the lower one lies in the array."""
    heights = [0.1 - distance_mm / 2000, 0.1 + distance_mm / 2000]
    return {"id": distance_mm, "target": [{"at": [0, 0, z]} for z in heights]}


def answers(scenes):
    """What `sonoglyph batch` says of scenes, in their order; runs on a worker."""
    lines = "".join(json.dumps(scene) + "\n" for scene in scenes)
    command = [SONOGLYPH, "batch", "--no-limits", "--threads", "1"]
    done = subprocess.run(command, input=lines, stdout=subprocess.PIPE, text=True, check=True)
    return [json.loads(line) for line in done.stdout.splitlines()]


def main():
    scenes = [scene(distance_mm) for distance_mm in range(5, 205, 5)]
    tasks = [scenes[i : i + SCENES_PER_TASK] for i in range(0, len(scenes), SCENES_PER_TASK)]
    table = csv.writer(sys.stdout, lineterminator="\n")
    table.writerow(["distance_mm", "weaker_pa", "error"])
    with LocalCluster(threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        for future in client.map(answers, tasks):
            for answer in future.result():
                table.writerow([answer["id"], answer.get("quality", {}).get("min_pressure"), answer.get("error")])


if __name__ == "__main__":
    main()
