"""Options of the touch experiments."""

import pytest

OF_EACH = {"features": ("--imprints", 1), "seek": ("--only", "cow")}
"""The option that an experiment has in place of the number of trials, with an invalid value."""


@pytest.mark.parametrize("name", ["cable", "cop", "edge", "features", "roll", "seek", "track"])
def test_invalid_option_value_exits_with_code_2(name, run_experiment):
    for option in (OF_EACH.get(name, ("--trials", 0)), ("--seed", -1)):
        code, _, err = run_experiment(name, *option)
        assert code == 2
        assert option[0] in err
