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

FAILURES = ("slipped", "empty_close", "stuck")
REFUSALS = ("refused", "unreachable", "unseen")
REFUSED = 0.2
"""Share of scenes with an object that no pick begins on."""
PROTOTYPES = ("power", "precision", "pincer")
CHANCES = {"single": 0.95, "packed": 0.88, "pile": 0.75}
"""Of a pick to succeed, by family ..."""
BLUR = {"default": 0.0, "fast": 0.12, "fine": -0.03}
"""... less so much for less careful perception."""
PACE = {"default": 1.0, "slow": 1.5, "fast": 0.7, "planner": 1.1}
"""Times that a pick takes."""


def run_made_up(trial: dict[str, Any]) -> dict[str, Any]:
    """Clear a scene in no time, or stop after two failures; with known poses none fails.

    Some scenes hold an object that is left alone, as the real trial tells of it: beside the picks.
    """
    rng = np.random.default_rng(trial["seed"])
    chance = CHANCES[trial["family"]] - BLUR[trial["perception"]] - (trial["friction"] < 1) / 8
    look = 0.0 if trial["known"] else {"fast": 25.0, "fine": 120.0}.get(trial["perception"], 60.0)
    other = np.random.default_rng([trial["seed"], 1])
    alone = 0 if trial["known"] else int(other.random() < REFUSED)
    picks, placed, in_a_row = [], 0, 0
    while placed < trial["objects"] - alone and in_a_row < 2:
        success = trial["known"] or bool(rng.random() < chance)
        placed, in_a_row = placed + success, 0 if success else in_a_row + 1
        picks.append(
            {
                "pick": len(picks),
                "object": f"box_{placed}",
                "kind": "box",
                "prototype": PROTOTYPES[rng.integers(3)],
                "approach": "top",
                "rows": np.int64(4),
                "outcome": "placed" if success else FAILURES[rng.integers(3)],
                "reason": "" if success else "fell < 20 mm & rolled",
                "success": success,
                "perceive_ms": look * rng.uniform(0.8, 1.2),
                "plan_ms": rng.uniform(20, 60),
                "seconds": PACE[trial["control"]] * rng.uniform(3.5, 5),
                "wall_seconds": rng.uniform(1, 2),
                "touched_before": 0,
                "pads": 4,
                "curl": np.nan,
            }
        )
    left = trial["objects"] - placed
    stopped = "2 picks failed in a row" if in_a_row == 2 else "no remaining object can be grasped"
    untried = [{"object": "flat", "outcome": str(other.choice(REFUSALS)), "reason": "too flat"}]
    return {
        "picks": picks,
        "placed": placed,
        "total": trial["objects"],
        "left": left,
        "stopped": stopped if left else "clear",
        "untried": untried if alone and in_a_row < 2 else [],
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
