"""Made-up trials without simulation. Other processes import them by name.

Their results depend only on the seed.
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
"""Share of scenes with an unattempted object."""
PROTOTYPES = ("power", "precision", "pincer")
CHANCES = {"single": 0.95, "packed": 0.88, "pile": 0.75}
"""Probability of a successful pick, by family."""
BLUR = {"default": 0.0, "fast": 0.12, "fine": -0.03}
"""Reduction of that probability, by perception dial."""
PERCEIVE_MS = {"default": 60.0, "fast": 25.0, "fine": 120.0}
"""Mean time of perception, ms, by perception dial."""
PACE = {"default": 1.0, "slow": 1.5, "fast": 0.7, "planner": 1.1}
"""Factor on the time of a pick, by control dial."""


def run_made_up(trial: dict[str, Any]) -> dict[str, Any]:
    """Return a made-up result: a cleared scene, or a stop after two failures in a row.

    With known poses no pick fails. Some scenes have an unattempted object, as in a real trial.
    """
    rng = np.random.default_rng(trial["seed"])
    chance = CHANCES[trial["family"]] - BLUR[trial["perception"]] - (trial["friction"] < 1) / 8
    perceive_ms = 0.0 if trial["known"] else PERCEIVE_MS[trial["perception"]]
    other = np.random.default_rng([trial["seed"], 1])
    unattempted = 0 if trial["known"] else int(other.random() < REFUSED)
    picks, placed, in_a_row = [], 0, 0
    while placed < trial["objects"] - unattempted and in_a_row < 2:
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
                "perceive_ms": perceive_ms * rng.uniform(0.8, 1.2),
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
        "untried": untried if unattempted and in_a_row < 2 else [],
        "cpu_seconds": 1.0,
    }


def run_troubled(trial: dict[str, Any]) -> dict[str, Any]:
    """Fail by seed: 1 raises, 2 kills its process once, 3 kills it every time, 4 hangs.

    A file in `objects_dir` records that seed 2 or 3 has run.
    """
    if trial["seed"] == 1:
        raise RuntimeError("the hand\nfell off")
    if trial["seed"] in (2, 3):
        marker = Path(trial["objects_dir"]) / f"ran_{trial['seed']}"
        ran_before = marker.exists()
        marker.write_text("once")
        if trial["seed"] == 3 or not ran_before:
            os.kill(os.getpid(), signal.SIGKILL)
    if trial["seed"] == 4:
        time.sleep(60)
    return run_made_up(trial)


def run_slowly(trial: dict[str, Any]) -> dict[str, Any]:
    """Run for 0.2 s, and leave a file in `objects_dir` at the start."""
    notes = Path(trial["objects_dir"])
    (notes / f"{trial['seed']}_{os.getpid()}_{time.monotonic_ns()}").write_text("began")
    time.sleep(0.2)
    return run_made_up(trial)
