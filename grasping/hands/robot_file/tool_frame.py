"""The closing axis and the approach of a gripper, from the motion and shape of its fingers."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from .links import Links, palm_bodies, palm_name
from .posing import Posing
from .shapes import geom_triangles, solid_geoms

SNAP = np.cos(np.deg2rad(3.0))
"""A closing axis within 3° of an axis of the file is that axis."""
SNAP_ONE_JAW = np.cos(np.deg2rad(35.0))
"""The same where one jaw moves on an arc against a fixed one."""
MIN_MOTION = 2e-3
"""Minimum motion of a jaw, m."""
MAX_LINK = 1.0
"""Maximum size of a part of a jaw, m. Those of grippers have up to 0.3."""
NEAR_CLOSED = -6
"""Posture from which on the motion of the jaws defines the closing axis."""
JAW_SHARE = 0.5
"""Share of the largest motion from which on a finger is a jaw; the rest is its linkage."""
MAX_DEGREE_SLIP = 0.05
"""Range of hinges below which they were probably meant in rad but read in degrees, rad."""
SIDE_COSINE = 0.6
"""Minimum cosine between the motion of a finger and the closing axis. Fingers at 120° close in
three directions."""
CLEAR_LEAD = 1.25
"""Ratio of the reach of the fingers in the best direction to the second best one that decides."""
ONE_LINK = ". Only one link moves: a suction cup on a spring is no gripper with jaws"
"""Remark about a file whose one jaw may be no jaw."""
_AXIS = re.compile(r"[+-][xyz]")
TCP_NAMES = re.compile(r"(tcp|tool|grasp|grip|pinch|^ee|_ee|eef|end_effector)", re.IGNORECASE)
"""Names of sites and bodies that mark a tool centre point."""


@dataclass(frozen=True, eq=False)
class JawSides:
    """The links of a gripper on both sides of its closing axis."""

    closing: NDArray[np.float64]
    """Unit closing axis in the palm's frame, (3,): from the second side to the first."""
    sides: tuple[list[int], list[int]]
    """Links of both sides. The second list is empty if the palm is the other jaw."""
    fingers: tuple[list[list[int]], list[list[int]]]
    """Links of each finger of both sides, without other parts of a linkage."""


class HandShapes:
    """Triangles of a gripper's links in the frame of its palm's body, at any posture."""

    def __init__(self, posing: Posing, palm: int, branches: list[list[int]]) -> None:
        model, links = posing.model, posing.links
        self.posing, self.links, self.palm = posing, links, palm
        fixed = palm_bodies(links, palm)
        self.base = min(fixed) if palm_name(links, palm) == "world" else _named(links, palm)
        self.fixed_geoms = solid_geoms(model, fixed)
        self.link_geoms = {
            link: solid_geoms(
                model, [body for body in range(model.nbody) if links.of_body[body] == link]
            )
            for branch in branches
            for link in branch
        }
        everything = [*self.fixed_geoms, *(g for geoms in self.link_geoms.values() for g in geoms)]
        self._local = {geom: geom_triangles(model, geom) for geom in everything}
        if not any(len(self._local[g]) for geoms in self.link_geoms.values() for g in geoms):
            raise InputError(
                f"no gripper is found: {', '.join(links.name(branch[0]) for branch in branches)} "
                "have no shapes: no geom, collision or visual"
            )
        for link, geoms in self.link_geoms.items():
            points = np.concatenate([self._local[g] for g in geoms] or [np.zeros((1, 3, 3))])
            if (size := float(np.ptp(points.reshape(-1, 3), axis=0).max())) > MAX_LINK:
                raise InputError(
                    f"{links.name(link)} is {size:.3g} m long, at most {MAX_LINK:g} m expected: "
                    'lengths must be in m, with scale="0.001 0.001 0.001" at meshes in mm'
                )

    def pose(self, posture: NDArray[np.float64]) -> None:
        """Move the gripper to a posture (nq,)."""
        self.posing.pose(posture)

    def triangles(self, geoms: Sequence[int]) -> NDArray[np.float64]:
        """Return triangles of geoms in the palm's frame at the present posture, (T, 3, 3), m."""
        data = self.posing.data
        turn, place = self.base_pose()
        parts = [np.zeros((0, 3, 3))]
        for geom in geoms:
            world = self._local[geom] @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
            parts.append((world - place) @ turn)
        return np.concatenate(parts)

    def base_pose(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return rotation (3, 3) and position (3,) of the palm's body in the world."""
        data = self.posing.data
        return data.xmat[self.base].reshape(3, 3).copy(), data.xpos[self.base].copy()

    def of_links(self, links: Sequence[int]) -> NDArray[np.float64]:
        """Return the triangles of links, (T, 3, 3), m."""
        return self.triangles([geom for link in links for geom in self.link_geoms[link]])


def _named(links: Links, palm: int) -> int:
    name = palm_name(links, palm)
    names = [links.model.body(b).name for b in range(links.model.nbody)]
    return names.index(name) if name in names else palm


def jaw_sides(shapes: HandShapes, path: NDArray[np.float64], branches: list[list[int]]) -> JawSides:
    """Sort the fingers into the two sides of the closing axis.

    Raises
    ------
    InputError
        If no finger moves, or the fingers do not close along one line.
    """
    places = np.array([_leaf_places(shapes, path[k], branches) for k in (0, NEAR_CLOSED, -1)])
    motion = places[2] - places[0]
    length = np.linalg.norm(motion, axis=1)
    if length.max() < MIN_MOTION:
        raise InputError(
            f"no gripper is found: {_names(shapes, branches)} moves by less than "
            f"{1e3 * MIN_MOTION:.0f} mm, as the flange of an arm whose gripper is in another file "
            f"or on fixed joints{_degree_hint(shapes)}"
        )
    # Other links of a linkage may even move outwards.
    jaws = np.flatnonzero(length >= JAW_SHARE * length.max())
    # On arcs the direction next to the closed posture counts.
    motion = places[2] - places[1]
    length = np.linalg.norm(motion, axis=1)
    axis = np.linalg.svd(motion[jaws])[2][0]
    if (np.abs(motion[jaws] @ axis) < SIDE_COSINE * length[jaws]).any():
        raise InputError(
            f"the fingers {_names(shapes, branches)} do not close along one line: this is a hand "
            "of several fingers, not a gripper with two jaws; --pinch BODY BODY uses two of them"
        )
    forwards = motion[jaws] @ axis >= 0
    both = bool(forwards.any() and not forwards.all())
    first, second = jaws[~forwards], jaws[forwards]
    if not both:
        # One jaw moves against the palm: it is the jaw at +x.
        closing = -motion[jaws].mean(axis=0)
        closing = _snapped(shapes, path, closing / np.linalg.norm(closing), both=False)
        everything = [link for branch in branches for link in branch]
        return JawSides(closing, (everything, []), ([branches[k] for k in jaws], []))
    # The components across the closing axis cancel out between mirrored fingers.
    closing = motion[second].mean(axis=0) - motion[first].mean(axis=0)
    closing = _snapped(shapes, path, closing / np.linalg.norm(closing), both=True)
    sides: tuple[list[int], list[int]] = ([], [])
    fingers: tuple[list[list[int]], list[list[int]]] = ([], [])
    along = places[0] @ closing
    for number, branch in enumerate(branches):
        if number in jaws:
            side = int(bool(motion[number] @ closing >= 0))
            fingers[side].append(branch)
        else:
            nearest = [np.abs(along[group] - along[number]).min() for group in (first, second)]
            side = int(np.argmin(nearest))
        sides[side].extend(branch)
    return JawSides(closing, sides, fingers)


def _leaf_places(
    shapes: HandShapes, posture: NDArray[np.float64], branches: list[list[int]]
) -> NDArray[np.float64]:
    """Return the middle of the outermost links of each branch, (n, 3), m."""
    shapes.pose(posture)
    places = []
    for branch in branches:
        leaves = [one for one in branch if not shapes.links.children(one)]
        points = shapes.of_links(leaves)
        points = points if len(points) else shapes.of_links(branch)
        flat = points.reshape(-1, 3)
        places.append(flat.mean(axis=0) if len(flat) else np.zeros(3))
    return np.array(places)


def _degree_hint(shapes: HandShapes) -> str:
    """Return a hint if all hinges have so small ranges that they were meant in rad."""
    model, links = shapes.posing.model, shapes.links
    joints = links.joints(shapes.link_geoms)
    spans = [np.ptp(model.jnt_range[j]) for j in joints if model.jnt_type[j] == 3]
    if spans and max(spans) < MAX_DEGREE_SLIP:
        return '; its hinges turn less than 3°: write <compiler angle="radian"/> if they are in rad'
    return ""


def _names(shapes: HandShapes, branches: list[list[int]]) -> str:
    return ", ".join(shapes.links.name(branch[0]) for branch in branches)


def file_axes(shapes: HandShapes, path: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return unit axes that the file uses, in the palm's frame, (n, 3): of bodies and geoms."""
    shapes.pose(path[-1])
    turn, _ = shapes.base_pose()
    data = shapes.posing.data
    bodies = [shapes.base, *shapes.link_geoms]
    frames = [data.xmat[body].reshape(3, 3) for body in bodies]
    frames += [
        data.geom_xmat[geom].reshape(3, 3)
        for geoms in shapes.link_geoms.values()
        for geom in geoms
        if shapes.posing.model.geom_type[geom] != 7
    ]
    axes = np.concatenate([(turn.T @ frame).T for frame in frames])
    return np.concatenate([axes, -axes])


def _snapped(
    shapes: HandShapes, path: NDArray[np.float64], axis: NDArray[np.float64], *, both: bool
) -> NDArray[np.float64]:
    """Return the axis of the file next to a direction, or the direction."""
    axes = file_axes(shapes, path) if both else np.concatenate([np.eye(3), -np.eye(3)])
    cosines = axes @ axis
    best = int(np.argmax(np.round(cosines, 6)))
    return axes[best] if cosines[best] > (SNAP if both else SNAP_ONE_JAW) else axis


def approach_axis(
    shapes: HandShapes, path: NDArray[np.float64], jaws: JawSides, tcp: str | None
) -> NDArray[np.float64]:
    """Return the unit approach in the palm's frame, (3,): out of the palm, along the fingers.

    Parameters
    ----------
    shapes, path, jaws
        The gripper.
    tcp
        Name of a site or body that marks the tool centre point, an axis of the palm's body such as
        ``+x``, or None.

    Raises
    ------
    InputError
        If the named point does not exist, or two directions are equally likely.
    """
    axes = file_axes(shapes, path)
    axes = np.asarray(axes[np.abs(axes @ jaws.closing) < 0.02], dtype=np.float64)
    axes = axes - (axes @ jaws.closing)[:, None] * jaws.closing
    lengths = np.sqrt((axes**2).sum(axis=1))[:, None]
    axes = _distinct(np.asarray(axes / lengths, dtype=np.float64))
    if not len(axes):
        helper = np.eye(3)[int(np.argmin(np.abs(jaws.closing)))]
        first = np.cross(jaws.closing, helper)
        first /= np.linalg.norm(first)
        second = np.cross(jaws.closing, first)
        axes = np.array([first, -first, second, -second], dtype=np.float64)
    shapes.pose(path[-1])
    fingers = shapes.of_links(jaws.sides[0] + jaws.sides[1]).reshape(-1, 3)
    palm = shapes.triangles(shapes.fixed_geoms).reshape(-1, 3)
    if len(palm) and jaws.sides[1]:
        reach = (fingers @ axes.T).max(axis=0) - (palm @ axes.T).max(axis=0)
    else:
        # Without a palm, or with a jaw on the palm, the joint of the moving jaw is the base.
        joint = _jaw_joint(shapes, jaws)
        reach = (fingers @ axes.T).max(axis=0) - axes @ joint
    if tcp is not None and (given := _AXIS.fullmatch(tcp)):
        return _given_axis(shapes, axes, given.group())
    marked = tcp_points(shapes, tcp)
    order = np.argsort(-np.round(reach, 6), kind="stable")
    if tcp is not None or (
        len(marked) == 1 and len(axes) > 1 and reach[order[1]] * CLEAR_LEAD > reach[order[0]]
    ):
        direction = next(iter(marked.values())) - (0.0 if len(palm) else _jaw_joint(shapes, jaws))
        return axes[int(np.argmax(axes @ direction))]
    if len(axes) > 1 and reach[order[1]] * CLEAR_LEAD > reach[order[0]]:
        words = [_axis_text(axes[k]) for k in order[:2]]
        raise InputError(
            f"--tcp is needed: the fingers may point along {words[0]} or {words[1]} of the body "
            f"{shapes.posing.model.body(shapes.base).name!r}: give one of these axes, or the name "
            f"of a site or body at the fingertips{'' if jaws.sides[1] else ONE_LINK}"
        )
    return axes[order[0]]


def _given_axis(shapes: HandShapes, axes: NDArray[np.float64], text: str) -> NDArray[np.float64]:
    """Return the axis of the palm's body that the user names."""
    axis = np.eye(3)["xyz".index(text[1])] * (1.0 if text[0] == "+" else -1.0)
    best = int(np.argmax(axes @ axis))
    if axes[best] @ axis < SNAP:
        known = ", ".join(sorted(_axis_text(one) for one in axes))
        raise InputError(
            f"--tcp {text} does not lie across the closing axis; of the body "
            f"{shapes.posing.model.body(shapes.base).name!r} these do: {known}"
        )
    return axes[best]


def tcp_points(shapes: HandShapes, name: str | None) -> dict[str, NDArray[np.float64]]:
    """Return the points that mark a tool centre, in the palm's frame, by name.

    Raises
    ------
    InputError
        If a name is given and no site or body of the gripper has it.
    """
    model, data = shapes.posing.model, shapes.posing.data
    turn, place = shapes.base_pose()
    mine = set(palm_bodies(shapes.links, shapes.palm)) | {
        body for body in range(model.nbody) if shapes.links.of_body[body] in shapes.link_geoms
    }
    points: dict[str, NDArray[np.float64]] = {}
    for body in mine:
        points[model.body(body).name] = (data.xpos[body] - place) @ turn
    for site in range(model.nsite):
        if int(model.site_bodyid[site]) in mine:
            points[model.site(site).name] = (data.site_xpos[site] - place) @ turn
    if name is not None:
        if name not in points:
            known = ", ".join(sorted(one for one in points if one))
            raise InputError(f"--tcp {name}: the gripper has no such site or body; it has {known}")
        return {name: points[name]}
    return {
        one: point
        for one, point in points.items()
        if TCP_NAMES.search(one) and np.linalg.norm(point) > 0.01
    }


def _jaw_joint(shapes: HandShapes, jaws: JawSides) -> NDArray[np.float64]:
    data = shapes.posing.data
    turn, place = shapes.base_pose()
    links = jaws.sides[0] + jaws.sides[1]
    return np.mean([(data.xpos[link] - place) @ turn for link in links[:1]], axis=0)


def _distinct(axes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the axes that differ by more than 1°."""
    kept: list[NDArray[np.float64]] = []
    for axis in axes:
        if all(axis @ other < np.cos(np.deg2rad(1.0)) for other in kept):
            kept.append(axis)
    return np.array(kept).reshape(-1, 3)


def _axis_text(axis: NDArray[np.float64]) -> str:
    """Return ``+z`` for an axis of the frame, or the three numbers of another direction."""
    best = int(np.argmax(np.abs(axis)))
    if abs(axis[best]) > 0.999:
        return f"{'+' if axis[best] > 0 else '-'}{'xyz'[best]}"
    return f"({', '.join(f'{value:.2f}' for value in axis)})"
