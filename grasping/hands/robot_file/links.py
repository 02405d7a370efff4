"""The moving links of a robot, how their joints are coupled, and which of them form a gripper."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

from eyehand.errors import InputError

from .read_model import Model, load_mujoco

MAX_BRANCHES = 12
"""Maximum number of links that move directly on a palm."""


@dataclass(frozen=True, eq=False)
class Links:
    """Links of a model: sets of bodies that do not move relative to each other.

    A link has the number of its first body.
    """

    model: Model
    """The model."""

    @cached_property
    def of_body(self) -> list[int]:
        """Link of each body. A body on a free joint counts as fixed."""
        found: list[int] = []
        for body in range(self.model.nbody):
            above = found[self.model.body_parentid[body]] if body else 0
            found.append(body if body and self.joints_of_body(body) else above)
        return found

    @cached_property
    def all(self) -> list[int]:
        """All links."""
        return sorted(set(self.of_body))

    def joints_of_body(self, body: int) -> list[int]:
        """Return the hinges and slides of a body."""
        first, count = self.model.body_jntadr[body], self.model.body_jntnum[body]
        scalar = _scalar_types()
        return [j for j in range(first, first + count) if self.model.jnt_type[j] in scalar]

    def parent(self, link: int) -> int:
        """Return the link below a link; 0 for the fixed one."""
        return self.of_body[self.model.body_parentid[link]] if link else 0

    def children(self, link: int) -> list[int]:
        """Return the links that move directly on a link."""
        return [other for other in self.all if other and self.parent(other) == link]

    def above(self, link: int) -> list[int]:
        """Return the links from a link down to the fixed one, the link first."""
        chain = [link]
        while chain[-1]:
            chain.append(self.parent(chain[-1]))
        return chain

    def subtree(self, link: int) -> list[int]:
        """Return a link and all links that it carries."""
        return [other for other in self.all if link in self.above(other)]

    def joint_link(self, joint: int) -> int:
        """Return the link that a joint moves."""
        return self.of_body[self.model.jnt_bodyid[joint]]

    def joints(self, links: Iterable[int]) -> list[int]:
        """Return the joints that move some links."""
        wanted = set(links)
        return [
            joint
            for joint in range(self.model.njnt)
            if self.joint_link(joint) in wanted and self.model.jnt_type[joint] in _scalar_types()
        ]

    def name(self, link: int) -> str:
        """Return the name of a link's first body."""
        return self.model.body(link).name or f"body {link}"


def _scalar_types() -> tuple[int, int]:
    kinds = load_mujoco().mjtJoint
    return int(kinds.mjJNT_HINGE), int(kinds.mjJNT_SLIDE)


def couplings(links: Links) -> list[set[int]]:
    """Return sets of joints that move together: by equality constraints, tendons and mimic joints.

    MuJoCo reads the mimic joints of a URDF as equality constraints.
    """
    model, mujoco = links.model, load_mujoco()
    pairs: list[set[int]] = []
    for equality in range(model.neq):
        if not model.eq_active0[equality]:
            continue
        kind, one, two = (
            int(t[equality]) for t in (model.eq_type, model.eq_obj1id, model.eq_obj2id)
        )
        if kind == mujoco.mjtEq.mjEQ_JOINT and two >= 0:
            pairs.append({one, two})
        elif kind == mujoco.mjtEq.mjEQ_TENDON:
            pairs.append(set(tendon_joints(model, one)) | set(tendon_joints(model, two)))
        elif kind in (int(mujoco.mjtEq.mjEQ_CONNECT), int(mujoco.mjtEq.mjEQ_WELD)):
            pairs.append(_loop_joints(links, equality))
    pairs += [
        set(tendon_joints(model, int(model.actuator_trnid[a, 0])))
        for a in range(model.nu)
        if model.actuator_trntype[a] == mujoco.mjtTrn.mjTRN_TENDON
    ]
    return _joined(pairs)


def tendon_joints(model: Model, tendon: int) -> list[int]:
    """Return the joints of a fixed tendon; none of a spatial one."""
    if tendon < 0:
        return []
    mujoco = load_mujoco()
    first, count = model.tendon_adr[tendon], model.tendon_num[tendon]
    return [
        int(model.wrap_objid[w])
        for w in range(first, first + count)
        if model.wrap_type[w] == mujoco.mjtWrap.mjWRAP_JOINT
    ]


def loop_bodies(model: Model, equality: int) -> tuple[int, int]:
    """Return the two bodies of a <connect> or <weld>."""
    one, two = int(model.eq_obj1id[equality]), int(model.eq_obj2id[equality])
    if model.eq_objtype[equality] == load_mujoco().mjtObj.mjOBJ_SITE:
        return int(model.site_bodyid[one]), int(model.site_bodyid[two])
    return one, max(two, 0)


def _loop_joints(links: Links, equality: int) -> set[int]:
    """Return the joints of a closed loop: those between its two ends and their common link."""
    one, two = (set(links.above(links.of_body[b])) for b in loop_bodies(links.model, equality))
    return set(links.joints((one | two) - (one & two)))


def _joined(sets: list[set[int]]) -> list[set[int]]:
    """Join the sets that overlap."""
    joined: list[set[int]] = []
    for one in sets:
        new = set(one)
        for other in [other for other in joined if other & new]:
            new |= other
            joined.remove(other)
        joined.append(new)
    return [one for one in joined if len(one) > 1]


def find_palm(links: Links, name: str | None = None) -> int:
    """Return the link on which the jaws of the gripper move.

    Coupled joints on different branches of a link are a gripper. Without them it is the last link
    with several branches, and without branches the link below the last joint.

    Raises
    ------
    InputError
        If there is no gripper, several, or no body of the given name.
    """
    model = links.model
    if name is not None:
        names = [model.body(b).name for b in range(model.nbody)]
        if name not in names:
            raise InputError(
                f"--palm {name}: there is no such body; bodies that carry joints are "
                f"{', '.join(sorted({links.name(links.parent(one)) for one in links.all if one}))}"
            )
        palm = links.of_body[names.index(name)]
        if not links.children(palm):
            raise InputError(f"--palm {name}: no joint moves on this body")
        return palm
    if not links.joints(links.all):
        raise InputError("no gripper is found: the file has no joint that moves")
    coupled = {palm for joints in couplings(links) if (palm := _carrier(links, joints)) is not None}
    found = [one for one in coupled if not any(o in coupled for o in links.above(one)[1:])]
    if not found:
        forks = [one for one in links.all if len(links.children(one)) > 1]
        found = [one for one in forks if not any(one in links.above(o)[1:] for o in forks)]
    if not found:
        found = [links.parent(one) for one in links.all if one and not links.children(one)]
    if len(found) > 1:
        names = ", ".join(sorted(palm_name(links, one) for one in found))
        raise InputError(f"--palm is needed: {len(found)} grippers, on the bodies {names}")
    if len(links.children(found[0])) > MAX_BRANCHES:
        raise InputError(
            f"body {links.name(found[0])} carries {len(links.children(found[0]))} moving links, a "
            f"gripper has at most {MAX_BRANCHES}: name its palm with --palm"
        )
    return found[0]


def palm_name(links: Links, palm: int) -> str:
    """Return the name of the body on which the first jaw of a palm moves."""
    first = links.children(palm)[0]
    body = int(links.model.body_parentid[first])
    return links.model.body(body).name or f"body {body}"


def _carrier(links: Links, joints: set[int]) -> int | None:
    """Return the last link below all joints if they are on different branches of it, else None."""
    chains = [links.above(links.joint_link(joint)) for joint in joints]
    common = next(link for link in chains[0] if all(link in chain for chain in chains))
    branches = {chain[chain.index(common) - 1] for chain in chains if chain[0] != common}
    return common if len(branches) > 1 and all(chain[0] != common for chain in chains) else None


def find_branches(links: Links, palm: int) -> list[list[int]]:
    """Return the links of each finger: the branches on the palm, joined by closed loops."""
    branches = [set(links.subtree(child)) for child in links.children(palm)]
    model, mujoco = links.model, load_mujoco()
    for equality in range(model.neq):
        kind = int(model.eq_type[equality])
        if kind not in (int(mujoco.mjtEq.mjEQ_CONNECT), int(mujoco.mjtEq.mjEQ_WELD)):
            continue
        ends = {links.of_body[body] for body in loop_bodies(model, equality)}
        touched = [branch for branch in branches if branch & ends]
        if len(touched) == 2:
            branches.remove(touched[1])
            touched[0] |= touched[1]
    return [sorted(branch) for branch in branches]


def root_body(links: Links, palm: int) -> int:
    """Return the first body of the gripper: the palm's body and what is fixed below it.

    A body that itself moves on the arm is not part of the gripper, unless it carries the jaws.
    """
    model = links.model
    carriers = {int(model.body_parentid[child]) for child in links.children(palm)}
    body = min(carriers)
    while len(carriers) > 1:
        # The last body below all jaws.
        chains = [_body_chain(model, carrier) for carrier in carriers]
        body = next(b for b in chains[0] if all(b in chain for chain in chains))
        carriers = {body}
    while body and body != palm:
        parent = int(model.body_parentid[body])
        if parent in (palm, 0):
            break
        body = parent
    return body


def _body_chain(model: Model, body: int) -> list[int]:
    chain = [body]
    while chain[-1]:
        chain.append(int(model.body_parentid[chain[-1]]))
    return chain


def palm_bodies(links: Links, palm: int) -> list[int]:
    """Return the bodies of the palm: those fixed to the gripper's first body."""
    root = root_body(links, palm)
    return [
        body
        for body in range(links.model.nbody)
        if links.of_body[body] == palm and root in _body_chain(links.model, body)
    ]
