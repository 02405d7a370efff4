"""Fit the simplest solid to the points of one object, seen from one side."""

import numpy as np

from eyehand.perception.superquadric import fit_superquadric


def can(rng):
    """Return the points of a can that a camera at x = 0.8 m sees, with 1 mm of noise."""
    angle, height = rng.uniform(-1.4, 1.4, 800), rng.uniform(0.0, 0.11, 800)
    side = np.column_stack([0.033 * np.cos(angle), 0.033 * np.sin(angle), height])
    turn, radius = rng.uniform(-np.pi, np.pi, 300), 0.033 * np.sqrt(rng.random(300))
    top = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), np.full(300, 0.11)])
    return np.concatenate([side, top]) + rng.normal(scale=0.001, size=(1100, 3))


def main():
    points = can(np.random.default_rng(0))
    fit = fit_superquadric(points, view_origin=[0.8, 0.0, 0.5], support_plane=[0, 0, 1, 0])
    if fit.superquadric is None:
        print("no solid:", fit.reason)
        return
    solid = fit.superquadric
    print(f"{solid.kind}: radius {1000 * solid.semi_axes[0]:.1f} mm (true 33.0)")
    print(f"height {2000 * solid.semi_axes[2]:.1f} mm (true 110.0)")
    print("converged" if fit else f"doubtful: {fit.reason}")


if __name__ == "__main__":
    main()
