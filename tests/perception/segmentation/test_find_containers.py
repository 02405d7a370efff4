"""Containers: the walls are measured, they are no objects, and their contents are."""

from dataclasses import replace
from functools import partial
from importlib import import_module

import numpy as np
import pytest
from synthetic_containers import Block, Tub, camera_pose, tub_frame
from synthetic_solids import Bowl, solid_frame

from eyehand.perception import DepthFrame, Segmentation, perceive, segment

find_containers = import_module("eyehand.perception.segmentation.find_containers")

CONTENTS = [
    Block((0.0, 0.0, 0.02), (0.06, 0.04, 0.04)),
    Block((0.11, 0.06, 0.03), (0.05, 0.05, 0.06), 0.7),
    Block((-0.1, -0.04, 0.015), (0.08, 0.05, 0.03), 0.3),
]
TUBS = {
    "bin": Tub(),
    "deep": Tub(height=0.16, thickness=0.005),
    "tray": Tub(height=0.015, thickness=0.008),
}


def overlap(found: Segmentation, labels: np.ndarray) -> list[float]:
    """Return the intersection over union of each true object with its best segment."""
    shares = []
    for label in range(1, labels.max() + 1):
        mask = labels == label
        best = np.bincount(found.labels[mask], minlength=2)[1:].argmax() + 1
        other = found.labels == best
        shares.append((mask & other).sum() / (mask | other).sum())
    return shares


@pytest.mark.parametrize("table", [None, -0.5], ids=["on a table", "in the air"])
@pytest.mark.parametrize("name", TUBS)
def test_walls_are_measured_and_contents_are_objects(name, table):
    tub = TUBS[name]
    if name == "tray" and table is not None:
        pytest.skip("trays lie on tables")
    frame, labels, T_world_camera = tub_frame(tub, CONTENTS, table)
    found = segment(frame)
    assert found.count == len(CONTENTS)
    assert min(overlap(found, labels)) > 0.8
    (container,) = found.containers
    assert container.floor_seen
    assert container.rim == pytest.approx(tub.height, abs=0.004)
    placed = container.moved(T_world_camera)
    assert placed.floor.offset == pytest.approx(0.0, abs=0.003)
    np.testing.assert_allclose(placed.floor.normal, [0, 0, 1], atol=0.01)
    sizes = np.linalg.norm(np.diff(placed.outline, axis=0), axis=1)
    np.testing.assert_allclose(sorted(sizes[:2]), [tub.width, tub.length], atol=0.012)
    for wall in placed.walls:
        assert wall.seen
        assert wall.thickness == pytest.approx(tub.thickness, abs=0.008)
        np.testing.assert_allclose(wall.corners[2:, 2], tub.height, atol=0.004)
        assert wall.axes[1] @ wall.corners.mean(axis=0) > 0.1
        assert placed.on_walls(wall.corners.mean(axis=0)[None], 0.001)[0]
    assert not placed.on_walls(np.array([[0.0, 0.0, 0.01]]), 0.01)[0]
    assert [warning.kind for warning in found.warnings] == ["container"]


@pytest.mark.parametrize("name", TUBS)
def test_empty_container_has_no_objects(name):
    found = segment(tub_frame(TUBS[name])[0])
    assert found.count == 0
    assert len(found.containers) == 1


@pytest.mark.parametrize(("y", "radius", "rim"), [(0.55, 0.3, 0.02), (0.6, 0.25, 0.03)])
def test_plate_is_an_object(monkeypatch, y, radius, rim):
    under = Bowl(0.0, y, radius + 0.002, radius, rim)
    frame, _ = solid_frame([under, under.inside()])
    found = segment(frame)
    assert (found.count, len(found.containers)) == (1, 0)
    monkeypatch.setattr(find_containers, "MAX_PLATE", 0.01)
    assert len(segment(frame).containers) == 1


@pytest.mark.parametrize(("yaw", "rows"), [(0.2, 150), (0.35, 145), (0.35, 140)])
def test_wall_that_the_image_cuts_off_is_measured_where_it_is_visible(yaw, rows):
    whole, _, _ = tub_frame(Tub(yaw=yaw, height=0.16))
    camera = replace(whole.intrinsics, height=rows)
    found = segment(DepthFrame(np.ascontiguousarray(whole.depth[:rows]), camera))
    assert found.count == 0
    (container,) = found.containers
    assert all(wall.seen for wall in container.walls)


def test_objects_at_a_wall_and_over_the_rim_are_found():
    tub = Tub(yaw=0.0)
    contents = [
        Block((0.175, 0.05, 0.03), (0.05, 0.05, 0.06)),
        Block((-0.1, 0.15, 0.105 + 0.01), (0.04, 0.12, 0.02)),
    ]
    frame, labels, _ = tub_frame(tub, contents)
    found = segment(frame)
    assert found.count == 2
    assert min(overlap(found, labels)) > 0.7


def test_object_beside_a_tray_stays():
    beside = Block((0.31, 0.0, 0.021), (0.05, 0.05, 0.05))
    frame, labels, _ = tub_frame(TUBS["tray"], [*CONTENTS, beside])
    found = segment(frame)
    assert found.count == 4
    assert min(overlap(found, labels)) > 0.8


def make_heap() -> list[Block]:
    """Return blocks that hide the floor of a tub."""
    rng = np.random.default_rng(3)
    return [
        Block((x, y, rng.uniform(0.0, 0.05)), (0.05, 0.05, 0.06), rng.uniform(0, 1.5))
        for x in np.arange(-0.18, 0.19, 0.036)
        for y in np.arange(-0.13, 0.14, 0.036)
    ]


def test_heap_hides_the_floor():
    frame, _, T_world_camera = tub_frame(Tub(), make_heap(), -0.4)
    found = segment(frame)
    (container,) = found.containers
    assert not container.floor_seen
    height = -container.moved(T_world_camera).floor.offset
    assert 0.0 < height < 0.06
    kinds = [warning.kind for warning in found.warnings]
    assert {"container", "container_heaped", "support_hidden"} <= set(kinds)
    assert found.count > 5


def lean_sides(measure, *args):
    """Return a measured container, two of whose sides lean outwards too far for walls."""
    found = measure(*args)
    sides = found.sides.copy()
    sides[:2, 4] = find_containers.MAX_DRAFT + 0.1
    return found._replace(sides=sides)


@pytest.mark.parametrize("contents", ["heap", "few"])
def test_leaning_faces_are_walls_only_around_a_visible_floor(contents, monkeypatch):
    frame, _, _ = tub_frame(Tub(), make_heap() if contents == "heap" else CONTENTS, -0.4)
    assert len(segment(frame).containers) == 1
    monkeypatch.setattr(
        find_containers, "measure_container", partial(lean_sides, find_containers.measure_container)
    )
    assert len(segment(frame).containers) == (0 if contents == "heap" else 1)


def test_ring_of_objects_is_no_container():
    ring = [
        Block((0.15 * np.cos(a), 0.13 * np.sin(a), 0.03), (0.05, 0.04, 0.04 + 0.02 * (k % 3)), a)
        for k, a in enumerate(np.arange(0.0, 6.2, 0.63))
    ]
    found = segment(tub_frame(None, ring)[0])
    assert not found.containers
    assert found.count == len(ring)


def test_scene_holds_the_container_in_its_own_frame():
    frame, _, T_world_camera = tub_frame(Tub(), CONTENTS)
    scene = perceive(DepthFrame(frame.depth, frame.intrinsics, T_world_camera))
    (container,) = scene.containers
    np.testing.assert_allclose(container.floor.normal, [0, 0, 1], atol=0.01)
    assert np.ptp(container.outline[:, 2]) < 1e-6
    assert [warning.kind for warning in scene.warnings] == ["container"]


def test_camera_pose_looks_at_the_origin():
    T_world_camera = camera_pose()
    np.testing.assert_allclose(T_world_camera.inv().apply([0.0, 0.0, 0.0])[:2], 0.0, atol=1e-12)


@pytest.mark.parametrize(("length", "count"), [(0.3, 0), (0.2, 1)])
def test_sheet_from_wall_to_wall_is_a_divider(length, count):
    tub = Tub(height=0.12)
    sheet = Block((0.0, 0.0, 0.05), (0.006, length, 0.1), tub.yaw)
    frame, _, _ = tub_frame(tub, [sheet])
    found = segment(frame)
    assert len(found.containers) == 1
    assert found.count == count


def test_round_corners_and_walls_above_the_rim_are_no_objects():
    tub = Tub(yaw=0.0)
    x, y = tub.length / 2, tub.width / 2
    corners = [
        Block((sx * (x - 0.02), sy * (y - 0.02), 0.05), (0.055, 0.004, 0.1), -sx * sy * np.pi / 4)
        for sx in (-1, 1)
        for sy in (-1, 1)
    ]
    back = Block((0.0, y + 0.005, 0.13), (tub.length, 0.01, 0.06))
    thing = Block((0.0, 0.0, 0.02), (0.06, 0.04, 0.04))
    leaning = Block((-0.05, y - 0.02, 0.03), (0.08, 0.035, 0.06))
    for parts in (corners, [back]):
        frame, labels, _ = tub_frame(tub, [thing, leaning, *parts])
        found = segment(frame)
        assert len(found.containers) == 1
        assert found.count == 2
        assert min(overlap(found, np.where(labels <= 2, labels, 0))) > 0.8


@pytest.mark.parametrize(
    ("height", "block"),
    [
        (0.1, Block((0.202, -0.27, 0.03), (0.015, 0.12, 0.06))),
        (0.1, Block((0.0, 0.153, 0.108), (0.14, 0.014, 0.016))),
        (0.1, Block((0.0, 0.153, 0.1065), (0.33, 0.014, 0.013))),
        (0.1, Block((0.0, 0.146, 0.09), (0.1, 0.01, 0.18))),
        (0.1, Block((0.155, 0.105, 0.1), (0.16, 0.014, 0.014), -np.pi / 4)),
        (0.015, Block((0.15, 0.1, 0.007), (0.13, 0.014, 0.014), -np.pi / 4)),
        (0.025, Block((0.1, 0.0, 0.007), (0.014, 0.29, 0.014))),
        (0.1, Block((0.165, 0.115, 0.055), (0.11, 0.03, 0.03), -np.pi / 4, 0.7)),
    ],
    ids=[
        "in line with a wall, outside",
        "pen on a rim",
        "ruler along a rim",
        "board at a wall",
        "pen on the rim across a corner",
        "pen across the corner of a tray",
        "ruler from wall to wall of a tray",
        "bar that leans in a corner",
    ],
)
def test_things_at_walls_and_corners_are_objects(height, block):
    thing = Block((0.0, 0.0, 0.02), (0.06, 0.04, 0.04))
    frame, labels, _ = tub_frame(Tub(yaw=0.0, height=height), [thing, block])
    found = segment(frame)
    assert len(found.containers) == 1
    assert found.count == 2
    assert min(overlap(found, labels)) > 0.5
