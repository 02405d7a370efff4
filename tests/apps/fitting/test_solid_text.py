"""Descriptions of fits."""

from dataclasses import replace

from eyehand.apps.fitting.solid_text import headline


def test_headline_has_size_shape_and_spread(can):
    title, below = headline(can.fit)
    assert title.startswith("cylinder, 80.")
    assert title.endswith(" mm")
    assert below.startswith("ε 0.10 1.00, spread 0.")
    assert below.endswith(f" over {can.fit.residuals.size} points")


def test_parts_are_listed_and_many_are_counted(hammer):
    title, below = headline(hammer.fit)
    assert title == "box + cylinder"
    assert below.startswith("40.0 × 90.0 × 36.0 mm + 24.0 × 24.0 × 200.0 mm, spread")
    many = replace(hammer.fit, parts=hammer.fit.parts * 3)
    assert headline(many)[0] == "box + cylinder + box + 3 more"


def test_unusable_fit_states_its_reason(can, unfit):
    assert headline(unfit.fit) == ("no solid", "it is mist")
    refused = replace(can.fit, converged=False, reason="an extent ran away")
    assert headline(refused)[1] == "cannot be used: an extent ran away"


def test_vessel_has_its_rim_and_its_wall(mug):
    title, below = headline(mug.fit)
    assert title == "vessel, 80.0 × 80.0 × 90.0 mm + 30.0 × 10.0 × 60.0 mm"
    assert below.startswith("rim 76.0 × 76.0 mm, wall 4.0 mm, spread")
    thin = replace(mug.fit, vessel=replace(mug.fit.vessel, wall=None))
    assert "wall unknown" in headline(thin)[1]
