"""Times of options: a number of seconds, minutes or hours."""

import pytest

from alight.options.quantities import Seconds

UNITS = {"": 1.0, "s": 1.0, "m": 60.0, "h": 3600.0}


@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("number", ["1", "2.5", "1e2"])
@pytest.mark.parametrize("gap", ["", " "])
def test_a_time_is_its_number_of_units(number, gap, unit):
    found = Seconds().check(f" {number}{gap}{unit.upper() if gap else unit}")
    assert found == float(number) * UNITS[unit]
    # What is written is read as the same.
    assert Seconds().check(Seconds().write(found)) == found
