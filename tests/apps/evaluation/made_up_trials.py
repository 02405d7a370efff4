"""Made-up trials, found by name in other processes: what a picked table tells, in no time.

They behave by their seed alone.
"""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path
from typing import Any

import numpy as np

OUTCOMES = ("placed", "placed", "slipped", "placed", "empty_close", "placed", "placed")
PROTOTYPES = ("power", "precision", "pincer")


def run_made_up(trial: dict[str, Any]) -> dict[str, Any]:
    """Clear a scene in no time; every third pick or so fails, none where the pose is known."""
    rng = np.random.default_rng(trial["seed"])
    picks, placed = [], 0
    while placed < trial["objects"] and len(picks) < 2 * trial["objects"]:
        outcome = "placed" if trial["known"] else OUTCOMES[rng.integers(len(OUTCOMES))]
        placed += outcome == "placed"
        picks.append(
            {
                "pick": len(picks),
                "object": f"box_{placed}",
                "kind": "box",
                "prototype": PROTOTYPES[rng.integers(3)],
                "approach": "top",
                "rows": np.int64(4),
                "outcome": outcome,
                "reason": "" if outcome == "placed" else "fell < 20 mm & rolled",
                "success": outcome == "placed",
                "perceive_ms": 0.0 if trial["known"] else rng.uniform(40, 90),
                "plan_ms": rng.uniform(20, 60),
                "seconds": rng.uniform(3, 6),
                "wall_seconds": rng.uniform(1, 2),
                "touched_before": 0,
                "pads": 4,
                "curl": np.nan,
            }
        )
    left = trial["objects"] - placed
    return {
        "picks": picks,
        "placed": placed,
        "total": trial["objects"],
        "left": left,
        "stopped": "two failures" if left else "clear",
        "cpu_seconds": 1.0,
    }


def run_troubled(trial: dict[str, Any]) -> dict[str, Any]:
    """Seed 1 raises, seed 2 kills its own process the first time, seed 3 each time, 4 hangs.

    `objects_dir` holds a file for each time that seed 2 was run.
    """
    if trial["seed"] == 1:
        raise RuntimeError("the hand\nfell off")
    if trial["seed"] in (2, 3):
        note = Path(trial["objects_dir"]) / f"ran_{trial['seed']}"
        ran_before = note.exists()
        note.write_text("once")
        if trial["seed"] == 3 or not ran_before:
            os.kill(os.getpid(), signal.SIGKILL)
    if trial["seed"] == 4:
        time.sleep(60)
    return run_made_up(trial)


def run_slowly(trial: dict[str, Any]) -> dict[str, Any]:
    """Take a while, and leave a note of having begun in `objects_dir`."""
    notes = Path(trial["objects_dir"])
    (notes / f"{trial['seed']}_{os.getpid()}_{time.monotonic_ns()}").write_text("began")
    time.sleep(0.2)
    return run_made_up(trial)
