"""Grip laws and the pull that estimates friction."""

import numpy as np
import pytest

from eyehand.errors import InputError
from eyehand.tactile import FrictionPull, GripReading, LoadGrip, LoadGripOptions, SlipGrip

DT = 1 / 475


def pulled(friction: float, load: float, noise: float = 0.0) -> FrictionPull:
    """Ease the grip of an object that bears `load` and slides at `friction`."""
    rng = np.random.default_rng(0)
    grip = command = 10.0
    pull = FrictionPull(grip)
    for k in range(700):
        grip += (command - grip) * DT / 0.02
        tangential = min(load * min(k / 50, 1.0), friction * grip)
        command = pull.update(grip, abs(tangential + noise * rng.standard_normal()), DT)
        if pull.done:
            break
    return pull


@pytest.mark.parametrize("friction", [0.3, 0.6, 1.0])
def test_pull_finds_the_friction(friction):
    assert pulled(friction, 1.0).friction == pytest.approx(friction, rel=0.03)


@pytest.mark.parametrize("friction", [0.3, 1.0])
def test_pull_finds_the_friction_despite_noise(friction):
    assert pulled(friction, 1.5, noise=0.05).friction == pytest.approx(friction, rel=0.15)


def test_pull_without_a_load_leaves_the_grip():
    pull = FrictionPull(5.0)
    assert {pull.update(5.0, 0.0, DT) for _ in range(200)} == {5.0}
    assert pull.friction is None
    assert not pull.done


def test_pull_that_never_slides_ends_at_the_least_grip():
    pull = pulled(100.0, 0.5)
    assert pull.done
    assert pull.friction is None or pull.friction <= 3.0


def test_estimate_that_is_too_low_restarts_the_pull_once():
    pull, grips = FrictionPull(5.0), [5.0]
    for _ in range(600):
        # An object that slides from the start at a ratio that no pad has.
        grips.append(pull.update(grips[-1], 0.1 * grips[-1], DT))
        if pull.done:
            break
    assert pull.done
    assert pull.friction is None
    restarts = [k for k in range(1, len(grips)) if grips[k] == 5.0 and grips[k - 1] < 5.0]
    assert len(restarts) == 1


def held(law, loads) -> list[float]:
    return [law.update(GripReading(5.0, load, slipping=False), DT) for load in loads]


def test_grip_follows_a_growing_load_at_once_and_relaxes_slowly():
    law = LoadGrip(0.5, 2.0)
    options = LoadGripOptions()
    steady = held(law, [1.0] * 1900)[-1]
    assert steady == pytest.approx(1.0 / 0.5 + options.reserve, rel=0.02)
    raised = held(law, [2.0] * 40)
    assert max(raised) > 2.0 / 0.5 + options.reserve
    assert raised[-1] == pytest.approx(2.0 / 0.5 + options.reserve, rel=0.1)
    relaxing = held(law, [1.0] * 48)
    assert 3.5 < relaxing[-1] < raised[-1]


def test_alarm_raises_the_grip_and_lowers_the_friction():
    law = LoadGrip(0.5, 2.25)
    before = held(law, [1.0] * 100)[-1]
    after = law.update(GripReading(2.25, 1.0, slipping=True), DT)
    assert after == pytest.approx(1.25 * before, rel=0.02)
    assert 0.4 <= law.friction < 0.5
    # A second alarm of the same event does not count.
    assert law.update(GripReading(2.25, 1.0, slipping=True), DT) < 1.02 * after


def test_alarms_while_the_object_slides_on_after_a_pull_do_not_count():
    law, paused = LoadGrip(0.5, 2.25), LoadGrip(0.5, 2.25, pause=0.08)
    reading = GripReading(2.25, 1.0, slipping=True)
    law.update(reading, DT)
    found = [paused.update(reading, DT) for _ in range(round(0.07 / DT))]
    assert law.friction < paused.friction == 0.5
    assert max(found) < 2.5
    # An object that still slides afterwards is gripped harder.
    assert max(paused.update(reading, DT) for _ in range(round(0.02 / DT))) > 1.2 * found[-1]


def test_pull_that_has_not_ended_knows_the_ratio_at_which_the_object_sticks():
    pull = FrictionPull(5.0)
    for _ in range(100):
        pull.update(4.0, 1.0, DT)
        assert not pull.done or pull.friction is not None
    assert pull.ratio == pytest.approx(0.25, rel=1e-3)


def test_law_of_the_chapter_decays_and_rises_by_a_quarter():
    law, grip = SlipGrip(4.0, decay_time=2.0), 0.0
    for _ in range(475):
        grip = law.update(GripReading(4.0, 1.0, slipping=False), DT)
    assert grip == pytest.approx(4.0 * np.exp(-0.5), rel=1e-3)
    assert law.update(GripReading(4.0, 1.0, slipping=True), DT) == pytest.approx(
        1.25 * grip, rel=0.01
    )


def test_values_out_of_range_are_refused():
    with pytest.raises(InputError, match="friction must be finite and > 0"):
        LoadGrip(0.0, 1.0)
    with pytest.raises(InputError, match="reserve must be finite"):
        LoadGripOptions(reserve=-1.0)
