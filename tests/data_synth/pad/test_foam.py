"""The foam law, its inverse, and two foam layers in series."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.data_synth.pad.foam import Foam, pressure_table
from eyehand.errors import InputError


@given(
    thickness=st.floats(1e-3, 0.1),
    modulus=st.floats(1e3, 1e6),
    densification=st.floats(0.3, 1.0),
    share=st.floats(0.0, 1.3),
)
def test_compression_inverts_pressure(
    thickness: float, modulus: float, densification: float, share: float
) -> None:
    foam = Foam(thickness, modulus, densification)
    depth = np.array(share * foam.hard_depth)
    assert foam.compression(foam.pressure(depth)) == pytest.approx(depth, rel=1e-9, abs=1e-15)


def test_pressure_is_smooth_at_densification() -> None:
    foam = Foam()
    depths = foam.hard_depth + np.linspace(-1e-7, 1e-7, 3)
    below, above = np.diff(foam.pressure(depths))
    assert above == pytest.approx(below, rel=1e-3)
    assert foam.pressure(np.array(foam.hard_depth)) == pytest.approx(foam.hard_pressure)


def test_pressure_is_zero_across_gap_and_slope_is_modulus() -> None:
    foam = Foam()
    assert foam.pressure(np.array([-1e-3, 0.0])).tolist() == [0.0, 0.0]
    assert foam.pressure(np.array(1e-8)) * foam.thickness / 1e-8 == pytest.approx(
        foam.modulus, rel=1e-6
    )


def test_two_layers_have_equal_pressure_and_share_depth() -> None:
    pad, ball = Foam(), Foam(0.02, 20e3)
    table = pressure_table(pad, ball)
    depths = table.step * np.arange(len(table.pressures))
    shared = pad.compression(table.pressures) + ball.compression(table.pressures)
    assert shared == pytest.approx(depths, abs=1e-7)
    assert table.pressures[1] / table.step == pytest.approx(
        1 / (pad.thickness / pad.modulus + ball.thickness / ball.modulus), rel=1e-2
    )


@pytest.mark.parametrize("fields", [{"thickness": 0.0}, {"modulus": -1.0}, {"densification": 1.2}])
def test_foam_rejects_invalid_values(fields: dict[str, float]) -> None:
    with pytest.raises(InputError):
        Foam(**fields)
