"""The experiment `explore`: points from tactile images, and the true surface."""

import json

import numpy as np
import pytest
from scipy.stats import norm

from eyehand.apps.touch.explore_truth import height_map, on_ridges, reachable_surface
from eyehand.apps.touch.felt_points import confirmed_points, felt_points, friction_shift
from eyehand.apps.touch.press_bench import pressed_decoder
from eyehand.data_synth.pad import Foam, Part, TouchObject, surface_distance, unknown_object
from eyehand.data_synth.pad.tactel_spread import POINT_SPREAD_M
from eyehand.perception.io import read_cloud
from eyehand.tactile import PressDecoder, TactileArray

PAD, FOAM = TactileArray.flat(), Foam()


@pytest.fixture(scope="module")
def decoder() -> PressDecoder:
    return pressed_decoder("good", 0, 0)[0]


def test_measured_cloud_lies_on_true_surface(tmp_path, run_experiment):
    code, out, _ = run_experiment("explore", "--quick", "--json", "--out", tmp_path)
    assert code == 0
    report = json.loads(out)
    assert report["schema"] == "eyehand.experiment_explore/1"
    assert report["outcomes"] == ["done", "done"]
    *_, blurred, both = report["rows"]
    assert both["surface_rms_mm"] < 0.15
    assert both["ridges_rms_mm"] < 0.5 * blurred["ridges_rms_mm"]
    assert both["covered_pct"] > 85.0, "of the surface reachable at 40°, in a few lanes"
    assert 1.2 < report["force_mean_n"] < 3.1, "the force is below 3 N on ridges and corners"
    assert (tmp_path / "explore.png").stat().st_size > 20_000
    assert len(read_cloud(tmp_path / "explore.ply")) == both["points"]


def test_pad_returns_to_an_object_that_the_memory_of_the_foam_hides(tmp_path, run_experiment):
    # The seed of `test_memory_of_the_real_pad…`: both share the presses.
    arguments = ("--quick", "--json", "--seed", 2, "--sensor", "real", "--out", tmp_path)
    report = json.loads(run_experiment("explore", *arguments)[1])
    *_, both = report["rows"]
    assert report["outcomes"] == ["done", "done"]
    assert both["surface_rms_mm"] < 0.2
    assert both["covered_pct"] > 40.0


def test_invalid_option_value_exits_with_code_2(run_experiment):
    code, _, err = run_experiment("explore", "--seed", -1)
    assert code == 2
    assert "--seed" in err


def test_presses_show_gains_spread_and_stiffness(decoder):
    assert decoder.gains == pytest.approx(1.0, abs=0.004)
    assert decoder.residual < 0.03
    pressures = np.array([200.0, 1000.0, 5000.0, 9000.0])
    assert decoder.depth(pressures) == pytest.approx(FOAM.compression(pressures), abs=4e-6)
    rings = 2 * np.pi * decoder.radii * decoder.response
    variance = np.sum(rings * decoder.radii**2) / np.sum(rings)
    assert np.sqrt(variance / 2) == pytest.approx(POINT_SPREAD_M, rel=0.15)


def test_memory_of_the_real_pad_is_fitted_from_presses():
    decoder, memory = pressed_decoder("real", 2, 1)
    assert memory.creep == pytest.approx(0.05, abs=0.005)
    assert memory.creep_time == pytest.approx(5.0, rel=0.15)
    assert memory.share == pytest.approx(0.1, abs=0.02)
    assert memory.recovery == pytest.approx(2.0, rel=0.2)
    assert 0.08 < np.log(decoder.gains).std() < 0.12, "the gains of the sensor model differ by 10 %"
    assert decoder.residual < 0.08


def test_flat_face_gives_its_depth_at_each_inner_tactel(decoder):
    depth = 0.0004
    pressure = float(FOAM.pressure(np.array([depth]))[0])
    found = felt_points(pressure * decoder.gains, decoder, sharpen=False)
    inner = PAD.positions.reshape(16, 16, 3)[1:-1, 1:-1].reshape(-1, 3)
    assert found[:, :2] == pytest.approx(inner[:, :2], abs=1e-9)
    assert found[:, 2] == pytest.approx(-depth, rel=0.003)


def test_edge_between_two_rows_is_located_between_them(decoder):
    across = PAD.positions[:, 1]
    found = felt_points(2000.0 * np.exp(-0.5 * (across / 0.003) ** 2), decoder, sharpen=False)
    assert len(found) > 20
    assert np.abs(found[:, 1]).max() < 0.001, "the next tactels are 2.5 mm away"


def blurred_image(pressure_of_x) -> np.ndarray:
    """Return pressures, blurred by the simulated foam, of a pressure that varies along x only."""
    fine = np.arange(-0.06, 0.06, 0.0001)
    borders = (np.arange(17) * 0.005 - 0.04)[:, None]
    shares = np.diff(norm.cdf((borders - fine) / POINT_SPREAD_M), axis=0)
    line = shares @ pressure_of_x(fine) * (0.0001 / 0.005)
    return np.tile(line, 16)


def test_deconvolution_keeps_depth_of_flat_face(decoder):
    found = felt_points(blurred_image(lambda x: np.full_like(x, 1500.0)), decoder)
    assert len(found) == 28 * 28
    assert found[:, 2] == pytest.approx(-FOAM.compression(np.array([1500.0]))[0], rel=0.007)


@pytest.mark.parametrize("middle", [0.0, 0.0012, 0.005])
def test_deconvolution_restores_height_of_ridge(middle, decoder):
    depth, radius = 0.0012, 0.012
    image = blurred_image(lambda x: FOAM.pressure(depth - (x - middle) ** 2 / (2 * radius)))
    blurred = felt_points(image, decoder, sharpen=False)[:, 2]
    found = felt_points(image, decoder)
    true = -(depth - (found[:, 0] - middle) ** 2 / (2 * radius))
    assert np.sqrt(np.mean((found[:, 2] - true) ** 2)) < 1e-4
    assert blurred.min() > found[:, 2].min() + 2e-4, (
        "without deconvolution, the ridge appears lower"
    )


def test_deconvolution_keeps_force_and_is_non_negative(decoder):
    image = blurred_image(lambda x: np.where(np.abs(x) < 0.004, 3000.0, 0.0))
    restored = decoder.deconvolve(image)
    assert restored.min() >= 0.0
    assert restored.mean() == pytest.approx(image.mean(), rel=0.01)


@pytest.mark.parametrize("seed", range(6))
def test_unknown_objects_differ_and_protrude_less_than_6_mm(seed):
    touch_object = unknown_object(seed)
    _, _, heights = height_map(touch_object)
    assert 0.0 < np.nanmax(heights) < 0.006, "the pads start 8 mm above the top"
    assert touch_object != unknown_object(seed + 1)
    assert np.abs(surface_distance(touch_object, [[0.0, 0.0, 0.0]])) < 0.006


def test_on_ridges_distinguishes_ridges_from_smooth_surface():
    points = [[-0.04, 0.01, 0.0], [0.0, -0.03, -0.003], [0.045, -0.012, 0.0013]]
    assert on_ridges(unknown_object(), np.array(points)).tolist() == [True, False, False]


def test_no_points_are_felt_at_saturated_tactels(decoder):
    image = np.full(256, 1500.0)
    unknown = np.zeros(256, bool)
    unknown[:128] = True
    found = felt_points(image, decoder, unknown=unknown)
    lowest = decoder.array.positions[~unknown, 1].min()
    assert len(found) > 100
    assert found[:, 1].min() > lowest


def test_points_that_no_other_image_confirms_are_noise():
    rng = np.random.default_rng(0)
    face = [rng.uniform(-0.01, 0.01, (40, 3)) * [1, 1, 0] for _ in range(6)]
    # In one image, six tactels in the air beside each other feel their noise.
    face[2] = np.concatenate([face[2], 0.001 * rng.standard_normal((6, 3)) + [0.0, 0.0, 0.02]])
    found = confirmed_points(face)
    assert len(found) > 0.95 * 6 * 40
    assert found[:, 2].max() == 0.0
    assert confirmed_points([]).shape == confirmed_points(face[:2]).shape == (0, 3)


def test_shift_by_friction_tends_to_the_lever_times_the_ratio_of_forces():
    shift, side = np.zeros(2), np.array([0.6, -0.3])
    for _ in range(60):
        shift = friction_shift(shift, side, 1.5, 0.004)
    assert shift == pytest.approx([0.0016, -0.0008], rel=0.01)
    assert friction_shift(np.zeros(2), side, 1.5, 0.0) == pytest.approx(0.0)
    assert np.linalg.norm(friction_shift(np.zeros(2), side, 0.001, 0.004)) <= 0.004


def test_felt_points_is_empty_without_contact(decoder):
    assert felt_points(np.zeros(256), decoder).shape == (0, 3)


def test_reachable_surface_is_flat_part_of_convex_hull():
    table = Part("box", (0.06, 0.04, 0.01), (0.0, 0.0, -0.01))
    pin = Part("box", (0.01, 0.01, 0.01), (0.0, 0.0, 0.0))
    flat = reachable_surface(TouchObject("flat", (table,)))
    assert flat[:, 2] == pytest.approx(0.0, abs=1e-9)
    assert len(flat) == pytest.approx(0.12 * 0.08 / 0.002**2, rel=0.1)
    both = reachable_surface(TouchObject("both", (table, pin)))
    around = both[(np.abs(both[:, :2]).max(axis=1) > 0.012) & (np.abs(both[:, 1]) < 0.03)]
    assert not len(around[np.abs(around[:, 0]) < 0.05]), (
        "around the pin, the pad cannot touch the table"
    )
