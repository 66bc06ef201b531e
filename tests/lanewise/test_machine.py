"""What decides the bits of compiled code: packets of portable code have one width everywhere."""

import pytest

from lanewise import machine
from lanewise.application import variable


@pytest.mark.parametrize("asked", ["", "16", "4"])
def test_portable_packets_are_as_wide_on_any_machine(asked, monkeypatch):
    """Whatever the processor has, and whatever the environment asks for; native ones follow it."""
    if asked:
        monkeypatch.setenv(variable("LANES"), asked)
    monkeypatch.setattr(machine, "_native_lanes", machine._native_lanes.__wrapped__)
    monkeypatch.setattr(machine, "_target", machine.PORTABLE)
    assert machine.lanes_of_machine() == 8
    monkeypatch.setattr(machine, "_target", machine.NATIVE)
    assert machine.lanes_of_machine() in ({int(asked)} if asked else {4, 8, 16})
