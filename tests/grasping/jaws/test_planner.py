"""Grasps of parallel jaws around solids of known size."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from jaw_scenes import bowl, box, can, moved, scene_of
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.grasping import JawOptions, ParallelHand, generic_jaw, load_hand, plan_grasps
from eyehand.grasping.jaw_plan import jaw_plans
from eyehand.grasping.jaws import Grasp
from eyehand.grasping.jaws.candidates import solid_candidates
from eyehand.grasping.jaws.scoring import INDEPENDENT, SUCCESS_ODDS
from eyehand.grasping.transport_phases import gripped_too_thin

PANDA = load_hand("panda")


def lowest(grasp: Grasp, hand: ParallelHand) -> float:
    """Return the height of the lowest corner of the hand, m."""
    boxes = np.concatenate([hand.jaw_boxes(grasp.width), hand.fixed_boxes()])
    corners = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1]), -1).reshape(-1, 3)
    points = np.concatenate([np.where(corners, high, low) for low, high in boxes])
    return float(grasp.T_scene_tcp.apply(points)[:, 2].min())


def test_box_is_gripped_across_its_narrow_side():
    grasps = plan_grasps(scene_of(box((0.10, 0.04, 0.12), turn=0.4)), PANDA)
    assert grasps
    best = grasps[0]
    assert best.object_width == pytest.approx(0.04, abs=0.003)
    narrow = np.array([-np.sin(0.4), np.cos(0.4), 0.0])
    assert abs(best.closing @ narrow) > 0.98
    assert best.object_label == 1
    assert 0.5 < best.success <= 1.0
    product = np.prod([term for name, term in best.terms.items() if name not in INDEPENDENT])
    odds = SUCCESS_ODDS * product / (1.0 - product)
    expected = best.terms["depth_error"] * best.terms["existence"] * odds / (1.0 + odds)
    assert best.success == pytest.approx(expected, rel=1e-9)
    assert [one.success for one in grasps] == sorted((g.success for g in grasps), reverse=True)


def test_readings_of_no_object_are_obstacles():
    """A board stands where the palm of the best grasp would be."""
    scene = scene_of(box((0.10, 0.04, 0.12)))
    best = plan_grasps(scene, PANDA)[0]
    low, high = PANDA.fixed_boxes()[0]
    grid = np.stack(np.meshgrid(*np.linspace(low, high, 12).T, indexing="ij"), -1).reshape(-1, 3)
    board = best.T_scene_tcp.apply(grid)
    grasps = plan_grasps(replace(scene, background=board), PANDA)
    assert [one for one in grasps if one.safe]
    for grasp in grasps:
        local = grasp.T_scene_tcp.inv().apply(board)
        cut = sum(
            ((local > low + 0.004) & (local < high - 0.004)).all(axis=1).sum()
            for low, high in [*PANDA.jaw_boxes(grasp.width), *PANDA.fixed_boxes()]
        )
        assert not grasp.safe or cut < 5


@pytest.mark.parametrize("size", [(0.05, 0.05, 0.02), (0.04, 0.06, 0.15), (0.03, 0.1, 0.05)])
@pytest.mark.parametrize("name", ["panda", "2f85", "generic"])
def test_hand_stays_above_the_support_and_clear_of_the_object(size, name):
    hand = load_hand(name)
    scene = scene_of(box(size))
    solid = scene.objects[0].fit.superquadric
    assert solid is not None
    grasps = plan_grasps(scene, hand)
    assert grasps
    for grasp in grasps:
        assert lowest(grasp, hand) > 0.0
        if grasp.success < 0.7:
            continue
        boxes = np.concatenate([hand.jaw_boxes(grasp.width), hand.fixed_boxes()])
        for low, high in boxes:
            grid = np.stack(np.meshgrid(*np.linspace(low, high, 4).T), -1).reshape(-1, 3)
            assert not solid.contains(grasp.T_scene_tcp.apply(grid)).any()


@pytest.mark.parametrize(("radius", "lip"), [(0.07, 0.0), (0.042, 0.006)])
def test_wide_vessel_is_gripped_at_its_rim(radius, lip):
    """One finger is in the opening: the hand opens less than the vessel is wide."""
    wall, height = 0.005, 0.09
    grasps = plan_grasps(scene_of(bowl(radius, height, wall, lip=lip)), PANDA)
    grasp = grasps[0]
    assert grasp.safe
    assert grasp.object_width == pytest.approx(wall, abs=0.003)
    assert np.linalg.norm(grasp.position[:2]) == pytest.approx(radius - wall / 2, abs=0.002)
    assert height - 0.05 < grasp.position[2] < height - 0.008
    radial = grasp.position[:2] / np.linalg.norm(grasp.position[:2])
    assert abs(grasp.closing[:2] @ radial) > 0.99
    assert grasp.approach[2] < -0.99


def test_jaws_at_a_rim_are_compared_with_the_wall_they_grip():
    scene = scene_of(bowl(0.07, 0.09, 0.005))
    item = scene.objects[0]
    for plan in jaw_plans(PANDA, plan_grasps(scene, PANDA)[0], item, np.array([0.0, 0.0, 1.0])):
        assert plan.gripped_width == pytest.approx(0.005, abs=0.003)
        assert gripped_too_thin(0.006, plan, item.fit) == ""
        fingers = replace(plan, gripped_width=None)
        assert "6 mm apart on an object of 90 mm" in gripped_too_thin(0.006, fingers, item.fit)


def test_arm_moves_the_frame_of_the_closed_gripper():
    scene = scene_of(box((0.04, 0.05, 0.1)))
    grasp, up = plan_grasps(scene, PANDA)[0], np.array([0.0, 0.0, 1.0])
    hand = replace(PANDA, middle_shift=(0.04, 0.01))
    for plan in jaw_plans(hand, grasp, scene.objects[0], up):
        axes = np.column_stack([plan.closing, np.cross(plan.palm, plan.closing), plan.palm])
        share = grasp.width / PANDA.stroke
        for task in plan.tasks:
            middle = task.point + axes @ [share * 0.04, share * 0.01, 0.0]
            np.testing.assert_allclose(middle, grasp.position, atol=1e-9)


def test_closed_solid_of_that_width_is_refused():
    assert not plan_grasps(scene_of(can(0.07, 0.09)), PANDA)


def test_list_is_sorted_and_covers_all_objects():
    scene = scene_of(box((0.04, 0.04, 0.1), (-0.1, 0.0)), can(0.025, 0.1, (0.1, 0.0), label=2))
    grasps = plan_grasps(scene, PANDA)
    success = [grasp.success for grasp in grasps]
    assert success == sorted(success, reverse=True)
    assert {grasp.object_label for grasp in grasps} == {1, 2}
    assert len(grasps[:2]) == 2


def test_grasps_do_not_depend_on_the_number_of_threads():
    cans = [can(0.02 + 0.002 * k, 0.1, (0.09 * k - 0.2, 0.0), label=k) for k in range(1, 5)]
    one, three = (plan_grasps(scene_of(*cans), PANDA, JawOptions(threads=n)) for n in (1, 3))
    assert len(one) == len(three) > 4
    assert one.rejected == three.rejected
    for first, second in zip(one, three, strict=True):
        assert (first.object_label, first.success) == (second.object_label, second.success)
        np.testing.assert_array_equal(first.T_scene_tcp.as_matrix(), second.T_scene_tcp.as_matrix())


def test_neighbour_blocks_the_side_where_it_stands():
    alone = plan_grasps(scene_of(box((0.04, 0.05, 0.1))), PANDA)
    # A wall 8 mm beside the narrow side leaves no room for a finger.
    wall = box((0.03, 0.2, 0.1), (0.043, 0.0), label=2)
    beside = plan_grasps(scene_of(box((0.04, 0.05, 0.1)), wall), PANDA)
    first = next(grasp for grasp in beside if grasp.object_label == 1)
    assert abs(alone[0].closing[0]) > 0.9
    assert abs(first.closing[1]) > 0.9 or first.position[2] > 0.08


def test_too_wide_object_has_a_reason():
    grasps = plan_grasps(scene_of(box((0.12, 0.13, 0.12))), PANDA)
    assert not grasps
    assert "wider than the stroke" in grasps.reason
    (reason,) = (one for one in grasps.rejected[1] if "wider than the stroke of 80 mm" in one)
    assert float(reason.partition(" mm wide")[0]) > 80.0


def test_empty_scene_has_a_reason():
    grasps = plan_grasps(scene_of(), PANDA)
    assert not grasps
    assert grasps.reason == "the scene has no objects"


def test_grasp_does_not_depend_on_the_frame():
    scene = scene_of(box((0.10, 0.04, 0.12), turn=0.4))
    T = RigidTransform.from_components([0.3, -0.2, 0.7], Rotation.from_rotvec([1.9, 0.4, 0.1]))
    here = plan_grasps(scene, PANDA)
    there = plan_grasps(replace(moved(scene, T), reference_frame="camera"), PANDA)
    assert there[0].success == pytest.approx(here[0].success, abs=0.03)
    assert np.linalg.norm(T.apply(here[0].position) - there[0].position) < 0.03


def test_poses_before_and_after_lie_on_the_approach():
    grasp = plan_grasps(scene_of(can(0.03, 0.05)), PANDA)[0]
    before = grasp.position - np.asarray(grasp.pre_grasp.translation)
    np.testing.assert_allclose(before, 0.05 * grasp.approach, atol=1e-12)
    after = np.asarray(grasp.retreat.translation) - grasp.position
    assert np.linalg.norm(after) == pytest.approx(0.1)
    assert after[2] > 0


def test_bump_of_the_noise_is_no_object():
    scene = scene_of(box((0.04, 0.03, 0.02)))
    assert scene.support is not None
    noisy = [
        plan_grasps(replace(scene, support=replace(scene.support, tolerance=0.02 / sigmas)), PANDA)
        for sigmas in (6.0, 10.0, 100.0)
    ]
    assert not noisy[0]
    assert noisy[0].reason == "no grasp is possible: as low as bumps of the noise"
    assert noisy[1][0].terms["existence"] == pytest.approx(0.378, abs=0.01)
    assert noisy[1][0].success == pytest.approx(0.378 * noisy[2][0].success, abs=0.01)


def test_low_object_with_tilted_axes_is_gripped_level():
    # The axes of the fit are 40° from the horizontal. Only a level closing axis leaves room below.
    scene = scene_of(box((0.12, 0.05, 0.02)))
    flat = scene.objects[0]
    solid = flat.fit.superquadric
    assert solid is not None
    turn = RigidTransform.from_rotation(Rotation.from_rotvec([0.7, 0.0, 0.0]))
    pose = solid.pose * turn
    round_one = replace(
        solid, semi_axes=np.array([0.06, 0.025, 0.012]), exponents=(1.0, 1.0), pose=pose
    )
    item = replace(flat, fit=replace(flat.fit, superquadric=round_one))
    grasps = plan_grasps(replace(scene, objects=(item,)), PANDA)
    assert grasps
    assert grasps[0].success > 0.3
    assert abs(grasps[0].closing[2]) < 0.1


def test_failed_grasp_ranks_lower():
    scene = scene_of(box((0.04, 0.04, 0.1), (-0.1, 0.0)), can(0.025, 0.1, (0.1, 0.0), label=2))
    first = plan_grasps(scene, PANDA, JawOptions(depth_error=0.005))[0]
    second = plan_grasps(scene, PANDA, JawOptions(depth_error=0.005, failed=(first,)))[0]
    assert second.object_label != first.object_label


def test_object_that_was_pushed_away_ranks_lower():
    can_beside = can(0.025, 0.1, (0.1, 0.0), label=2)
    options = JawOptions(depth_error=0.005)
    before = plan_grasps(scene_of(box((0.04, 0.04, 0.1), (-0.1, 0.0)), can_beside), PANDA, options)
    failed = next(grasp for grasp in before if grasp.object_label == 1)
    pushed = scene_of(box((0.04, 0.04, 0.1), (-0.1, 0.09)), can_beside)
    after = plan_grasps(pushed, PANDA, replace(options, failed=(failed,)))
    memory = {grasp.object_label: grasp.terms["memory"] for grasp in after}
    assert memory[1] < 1.0
    assert memory[2] == 1.0


def test_guarded_arm_succeeds_more_often_with_an_unknown_depth_scale():
    scene = scene_of(box((0.06, 0.06, 0.12)))
    free, guarded = (
        plan_grasps(scene, PANDA, JawOptions(depth_error=0.03, guarded=one))[0]
        for one in (False, True)
    )
    known = plan_grasps(scene, PANDA, JawOptions(depth_error=0.0))[0]
    assert free.success + 0.02 < guarded.success < known.success + 0.05


def test_guarded_arm_goes_deeper_only_with_an_unknown_depth_scale():
    scene = scene_of(box((0.06, 0.06, 0.12)))
    unknown = plan_grasps(scene, PANDA, JawOptions(guarded=True))
    deeper = [grasp for grasp in unknown if "deeper until contact" in grasp.reason]
    assert deeper
    for options in (JawOptions(), JawOptions(guarded=True, depth_error=0.005)):
        assert not any("deeper" in grasp.reason for grasp in plan_grasps(scene, PANDA, options))
    # The same error with the depth of the others: fewer grasps succeed.
    assert max(grasp.terms["depth_error"] for grasp in unknown) > max(
        grasp.terms["depth_error"] for grasp in plan_grasps(scene, PANDA, JawOptions())
    )


def test_object_at_the_limit_of_the_stroke_is_not_safe():
    grasps = plan_grasps(scene_of(box((0.0765, 0.2, 0.05))), PANDA)
    assert all(not grasp.safe and grasp.forbidden_by for grasp in grasps)
    assert grasps.reason.startswith("no grasp is safe: ")


def test_wider_jaw_grips_wider_objects():
    scene = scene_of(box((0.12, 0.13, 0.08)))
    assert plan_grasps(scene, generic_jaw(stroke=0.15, finger_depth=0.06))


def test_options_are_checked():
    with pytest.raises(InputError, match="friction must be from 0 to 3"):
        JawOptions(friction=-1.0)
    with pytest.raises(InputError, match="per_object"):
        JawOptions(per_object=0)
    with pytest.raises(InputError, match="approaches must be from 4 to 360, got 3"):
        JawOptions(approaches=3)
    with pytest.raises(InputError, match="tested must be from 1 to 100000, got 0"):
        JawOptions(tested=0)
    for threads in (0, 2.5):
        with pytest.raises(InputError, match=f"threads must be from 1 to 256, got {threads}"):
            JawOptions(threads=threads)  # pyright: ignore[reportArgumentType]
    with pytest.raises(InputError, match="guarded must be True or False, got 'no'"):
        JawOptions(guarded="no")  # pyright: ignore[reportArgumentType]
    with pytest.raises(InputError, match="failed must hold grasps of plan_grasps"):
        JawOptions(failed=(1,))  # pyright: ignore[reportArgumentType]


def test_name_in_place_of_the_hand_is_refused():
    with pytest.raises(InputError, match="as from load_hand; got Scene and str"):
        plan_grasps(scene_of(), "panda")  # pyright: ignore[reportArgumentType]


def test_fewer_tested_candidates_find_at_most_as_good_a_grasp():
    scene = scene_of(can(0.03, 0.1), box((0.05, 0.1, 0.1), (0.07, 0.0), label=2))
    best = plan_grasps(scene, PANDA)[0].success
    for tested in (40, 60):
        found = plan_grasps(scene, PANDA, JawOptions(tested=tested))
        assert 0.0 < found[0].success <= best + 1e-9


def test_approaches_are_spread_over_the_turn():
    def directions(count):
        solid = box((0.04, 0.3, 0.3)).fit.superquadric
        assert solid is not None
        up = np.array([0.0, 0.0, 1.0])
        found = solid_candidates(solid, 0, PANDA, up, JawOptions(approaches=count, max_tilt=np.pi))
        return np.unique(np.round(found.rotation[:, :, 2], 6), axis=0)

    for count in (8, 24):
        one = directions(count)
        assert len(one) == count
        cosines = np.sort(one @ one.T, axis=1)[:, -2]
        np.testing.assert_allclose(cosines, np.cos(2 * np.pi / count), atol=1e-5)


def test_turns_about_an_axis_of_symmetry_are_one_grasp():
    grasps = plan_grasps(scene_of(can(0.03, 0.05)), PANDA)
    assert 1 < len(grasps) <= 3
    above = [grasp for grasp in grasps if grasp.approach[2] < -0.99]
    heights = sorted(grasp.position[2] for grasp in above)
    assert all(np.diff(heights) > 0.007)


def test_narrow_part_of_an_object_wider_than_the_stroke_is_gripped():
    body, handle = box((0.1, 0.1, 0.04)), box((0.08, 0.03, 0.04), (0.09, 0.0))
    parts = tuple(one.fit.superquadric for one in (body, handle))
    fit = replace(body.fit, parts=parts)
    whole = replace(body, points=np.concatenate([body.points, handle.points]), fit=fit)
    grasps = plan_grasps(scene_of(whole), PANDA)
    assert grasps
    assert all(grasp.position[0] > 0.05 for grasp in grasps)
    assert grasps[0].object_width == pytest.approx(0.03, abs=0.004)
