"""Split an object that no one solid explains into few that do."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
from scipy.spatial import KDTree

from .kinds import basis
from .levenberg_marquardt import levenberg_marquardt
from .ladder import parameter_bounds
from .part_cuts import cuts
from .problem import Guess, pose_problem
from .refusals import misses
from .residual_kernels import distances
from .readings import readings_of
from .starts import starting_boxes

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from .options import FitOptions
    from .outliers import Neighbourly
    from .result import SuperquadricFit
    from .shape import Superquadric

    Hidden = Callable[[NDArray[np.float64]], NDArray[np.bool_]]

NEIGHBOURS = 8
FEWEST = 25
QUICK_POINTS = 80
QUICK_STEPS = 8
AGAIN_STEPS = 4
ROUNDS = 3
FINALISTS = 4
CONTACT = 2.0
MARGIN = 10.0
PLANE_PARAMETERS = 3


@dataclass(frozen=True)
class Scene:
    """What an object's cloud was fitted with."""

    near: Neighbourly
    origin: NDArray[np.float64] | None
    plane: NDArray[np.float64] | None
    hidden: Hidden | None


class FitOne(Protocol):
    """Fits one solid."""

    def __call__(self, scene: Scene, options: FitOptions, /) -> SuperquadricFit: ...


class _Split(NamedTuple):
    guesses: list[Guess]
    labels: NDArray[np.int64]
    cost: float


def in_parts(
    whole: SuperquadricFit, scene: Scene, options: FitOptions, fit_one: FitOne
) -> SuperquadricFit:
    return _Splitter(scene, options, fit_one).run(whole)


class _Splitter:
    def __init__(self, scene: Scene, options: FitOptions, fit_one: FitOne) -> None:
        cloud = scene.near.cloud
        self.centre = cloud.mean(axis=0)
        reach = np.sum((cloud - self.centre) ** 2, axis=1)
        self.unit = float(np.sqrt(reach.mean()))
        order = np.argsort(reach, kind="stable")
        self.points = cloud[order] - self.centre
        self.options, self.fit_one = options, fit_one
        self.scene = scene
        self.origin = None if scene.origin is None else scene.origin - self.centre
        self.plane = scene.plane
        if scene.plane is not None:
            self.plane = np.append(scene.plane[:3], scene.plane[3] + scene.plane[:3] @ self.centre)
        spacing, near = KDTree(self.points).query(self.points, k=NEIGHBOURS + 1)
        self.neighbours = np.asarray(near)[:, 1:]
        self.spacing = float(np.median(np.asarray(spacing)[:, 1]))
        self.tree = None
        if self.origin is not None:
            offset = self.points - self.origin
            self.depth = np.linalg.norm(offset, axis=1)
            self.tree = KDTree(offset / self.depth[:, None])

    # judging
    def cost(self, r):
        s = 2 * self.options.noise
        return float(np.mean(0.5 * s * s * np.log1p((r / s) ** 2)))

    def crit(self, cost, parameters, n):
        floor = 0.5 * self.options.noise
        return n * np.log(2 * cost + floor**2) + parameters * np.log(n)

    def local(self):
        pts = self.points[self.neighbours]
        mean = pts.mean(axis=1)
        d = pts - mean[:, None]
        cov = np.einsum("nki,nkj->nij", d, d)
        _, v = np.linalg.eigh(cov)
        return np.einsum("ni,ni->n", self.points - mean, v[:, :, 0])

    def union(self, solids):
        return np.min([s.distance(self.points) for s in solids], axis=0)

    def run(self, whole):
        o = self.options
        moved = None
        if whole.superquadric is not None:
            solid = shifted(whole.superquadric, -self.centre)
            fits = [replace(whole, superquadric=solid)]
            res = solid.distance(self.points)
            params = solid.parameter_count
        else:
            if "plane" not in whole.reason and "line" not in whole.reason:
                return whole
            fits = []
            _, _, rows = np.linalg.svd(self.points, full_matrices=False)
            res = self.points @ rows[2]
            params = PLANE_PARAMETERS
        local = self.local()
        floor_cost = self.cost(local)
        n = o.effective_points
        self.tried = 1
        if self.crit(self.cost(res), 0, n) - self.crit(floor_cost, 5, n) < MARGIN:
            return whole
        labels = np.zeros(len(self.points), dtype=np.int64)
        while max(len(fits), 1) < o.max_parts:
            best = None
            k = max(len(fits), 1)
            # parts by excess cost
            order = sorted(range(k), key=lambda j: -self.cost(res[labels == j]) * np.mean(labels == j))
            accepted = False
            for j in order:
                m = labels == j
                if len(fits) and self.crit(self.cost(res), 0, n) - self.crit(
                    self.cost(np.where(m, local, res)), 5, n) < MARGIN:
                    continue
                self.tried = k + 1
                got = self.split_part(j, fits, labels, res)
                if got is None:
                    continue
                new_fits, new_labels, new_res = got
                readings = readings_of(self.points, new_res, o)
                before = self.crit(self.cost(res), params, readings)
                new_params = sum(f.superquadric.parameter_count for f in new_fits) + k
                after = self.crit(self.cost(new_res), new_params, readings)
                if after < before - MARGIN:
                    fits, labels, res, params = new_fits, new_labels, new_res, new_params
                    accepted = True
                    break
            if not accepted:
                break
        if len(fits) <= 1:
            if not whole and self.tried > 1:
                return replace(whole, reason=f"{whole.reason}; neither do {self.tried} parts explain it")
            return whole
        fits = sorted(fits, key=lambda f: -f.superquadric.volume)
        parts = tuple(shifted(f.superquadric, self.centre) for f in fits)
        reason = misses(res, self.unit, o)
        return replace(fits[0], superquadric=parts[0], converged=not reason, reason=reason,
                       residuals=res, parts=parts)

    def split_part(self, j, fits, labels, res):
        """Split part j; all points relabelled."""
        o = self.options
        m = np.flatnonzero(labels == j)
        sub = self.points[m]
        inv = np.full(len(self.points), -1)
        inv[m] = np.arange(len(m))
        nb = inv[self.neighbours[m]]
        nb = np.where(nb >= 0, nb, np.arange(len(m))[:, None])
        frame = fits[j].superquadric.rotation if fits else np.eye(3)
        r = fits[j].superquadric.distance(sub) if fits else None
        masks = cuts(sub, nb, frame, r, o.noise, FEWEST)
        base = [guess_of(f.superquadric) for f in fits] if fits else [None]
        k = max(len(fits), 1)
        splits = []
        for mask in masks:
            lab = labels.copy()
            lab[m[mask]] = k
            guesses = list(base) + [None]
            guesses[j] = self.quick(lab, j, None, QUICK_STEPS)
            guesses[k] = self.quick(lab, k, None, QUICK_STEPS)
            if guesses[j] is None or guesses[k] is None:
                continue
            splits.append(self.judged(guesses, lab))
        splits.sort(key=lambda s: s.cost)
        kept = splits[:FINALISTS]
        for _ in range(ROUNDS):
            kept = [self.again(s) for s in kept]
            kept = sorted(kept, key=lambda s: s.cost)
            kept = kept[: max(len(kept) // 2, 1)] if False else kept
        self.debug = (splits, kept)
        for s in kept[:1]:
            lab = self.reassigned(s.guesses)
            new = []
            for i in range(k + 1):
                pl = self.part_scene(lab, i)
                f = self.fit_one(pl, o) if np.count_nonzero(lab == i) >= FEWEST else None
                if f is None or f.superquadric is None or not f.converged:
                    self.why = (i, f.reason if f is not None else "few")
                    return None
                new.append(f)
            r = self.union([f.superquadric for f in new])
            return new, lab, r
        return None

    def judged(self, guesses, labels):
        d = np.array([distances(self.points, *g) for g in guesses])
        return _Split(guesses, labels, self.cost(d.min(axis=0)))

    def reassigned(self, guesses):
        d = np.abs([distances(self.points, *g) for g in guesses])
        lab = d.argmin(axis=0)
        k = len(guesses)
        votes = np.eye(k)[lab]
        votes = votes + votes[self.neighbours].sum(axis=1)
        return votes.argmax(axis=1)

    def again(self, s):
        lab = self.reassigned(s.guesses)
        gs = []
        for i, g in enumerate(s.guesses):
            if np.count_nonzero(lab == i) < FEWEST:
                return s
            gs.append(self.quick(lab, i, g, AGAIN_STEPS) or g)
        new = self.judged(gs, lab)
        return new if new.cost < s.cost else s

    def part_scene(self, labels, i):
        mask = labels == i
        plane = self.plane
        if plane is not None:
            h = self.points[mask] @ plane[:3] + plane[3]
            if h.min() > CONTACT * self.options.plane_scale:
                plane = None
        return Scene(self.scene.near._replace(cloud=self.points[mask]), self.origin, plane,
                     lambda rays: self.behind(rays, labels, i))

    def behind(self, rays, labels, i):
        out = np.zeros(len(rays), bool) if self.scene.hidden is None else self.scene.hidden(rays)
        dist = float(np.median(self.depth))
        R = 2.0 * self.spacing / dist
        for q, found in enumerate(self.tree.query_ball_point(rays, R)):
            found = np.array(found, dtype=int)
            other = found[labels[found] != i]
            own = found[labels[found] == i]
            if len(other) and (not len(own) or self.depth[other].min() < self.depth[own].max() + 3 * self.spacing):
                out[q] = True
        return out

    def quick(self, labels, i, guess, steps):
        o = self.options
        sc = self.part_scene(labels, i)
        p = pose_problem(sc.near, sc.origin, sc.plane, sc.hidden, replace(o, points=QUICK_POINTS, silhouette_rays=min(o.silhouette_rays, 12)))
        bounds = parameter_bounds("superquadric", p, o)
        if guess is None:
            box = starting_boxes(p, sc.plane is not None)[0]
            box = best_z(box)
            start = box._replace(eps=np.array([.7, .7]))
        else:
            start = guess._replace(axes=np.clip(guess.axes - np.log(p.unit), *bounds[0]), c=(guess.c - p.centre) / p.unit)
        g, cost, _ = levenberg_marquardt(p, start, basis("superquadric"), bounds, steps, 1e-3)
        if not all(np.all(np.isfinite(x)) for x in g):
            return None
        return g._replace(axes=g.axes + np.log(p.unit), c=g.c * p.unit + p.centre)


def best_z(box):
    a = box.axes
    gaps = [abs(a[(k + 1) % 3] - a[(k + 2) % 3]) for k in range(3)]
    last = int(np.argmin(gaps))
    order = [(last + 1) % 3, (last + 2) % 3, last]
    return box._replace(axes=box.axes[order], R=np.ascontiguousarray(box.R[:, order]))


def guess_of(s: Superquadric) -> Guess:
    return Guess(np.log(s.semi_axes), np.array(s.exponents), s.rotation.copy(), s.centre.copy(), np.array(s.taper))


def shifted(s: Superquadric, by) -> Superquadric:
    from scipy.spatial.transform import RigidTransform
    return replace(s, pose=RigidTransform.from_translation(by) * s.pose)
