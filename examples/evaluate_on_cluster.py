"""Measure picks on a Dask cluster: python examples/evaluate_on_cluster.py [tcp://HOST:8786].

Start it with `dask scheduler` and, on each machine, `dask worker tcp://HOST:8786 --nthreads 1`.
"""

import sys

from eyehand.apps.main import main as eyehand


def main(address="", scenes=100):
    words = ["evaluate", "grasp", "--family", "packed", "--scenes", str(scenes)]
    if address:
        words += ["--cluster", address]
    # The rows are stored scene by scene. The same command continues a run that was stopped.
    eyehand([*words, "--out", "out/cluster"])


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "")
