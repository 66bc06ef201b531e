"""Numba's own pipeline gives the bits of the lean one."""

from __future__ import annotations

from collections import namedtuple

import numpy as np
import pytest

from lanewise.application import variable
from lanewise.dispatchers import jit
from lanewise.jit import StockKernel, instantiate, kernel, specialised
from lanewise.machine_code import MachineCode
from lanewise.simd import (
    LANES,
    any_lane,
    as_float,
    gather,
    lanes,
    lanes_vec3,
    load_lanes,
    rsqrt,
    store_lanes,
    to_uint,
    where,
)
from lanewise.vec3 import Vec3
from lanewise.view import View

Bodies = namedtuple("Bodies", "mass x strength enabled")


@specialised
def force(program):
    @kernel
    def softened(d, mass):
        r = rsqrt(d.x * d.x + d.y * d.y + d.z * d.z + 0.25)
        return d * (mass * r * r * (r if program == "gravity" else 1.0))

    return softened


@kernel
def nearest_third(x):
    while any_lane(x > 3.0):
        x = where(x > 3.0, x - 3.0, x)
    return x / 3.0


@kernel(strict=True)
def strictly(x):
    return (x + 1e8) - 1e8


@kernel
def accelerate(bodies, centre, count, out):
    n = bodies.x.size
    for i in range(0, n, LANES):
        x = load_lanes(bodies.x, i)
        total = lanes_vec3(0.0)
        for k in range(count):
            d = Vec3(x - as_float(k), lanes(0.5), 2.0 * nearest_third(x)) - centre
            total = total + force(d, gather(bodies.mass, to_uint(x)) * bodies.strength)
        store_lanes(out, i, where(bodies.enabled, total.x, 0.0))
        store_lanes(out, n + i, total.y / (1.0 + total.z))
        store_lanes(out, 2 * n + i, strictly(x))


def run(pipeline, program, monkeypatch):
    """What the kernel writes, as bits."""
    monkeypatch.setenv(variable("PIPELINE"), pipeline)
    rng = np.random.default_rng(3)
    bodies = Bodies(
        View(rng.random(20, np.float32)), View(20.0 * rng.random(64, np.float32)), 2.5, True
    )
    out = View(np.zeros(3 * 64, np.float32))
    call = instantiate(accelerate, program)
    call(bodies, Vec3(0.5, 1.5, -2.0), 3, out)
    assert isinstance(call, StockKernel if pipeline == "stock" else MachineCode)
    again = View(np.zeros_like(out.array))
    call.fixed()(bodies, Vec3(0.5, 1.5, -2.0), 3, again)
    np.testing.assert_array_equal(again.array, out.array)
    return out.array.view(np.uint32)


@pytest.mark.parametrize("program", ["gravity", "light"])
def test_both_pipelines_give_the_same_bits(program, tmp_path, monkeypatch):
    monkeypatch.setenv(variable("CACHE"), str(tmp_path))
    lean, stock = (run(pipeline, program, monkeypatch) for pipeline in ("lean", "stock"))
    np.testing.assert_array_equal(lean, stock)
    assert lean.any()
    # The stock one keeps nothing on disk, and takes nothing from there.
    assert len(list(tmp_path.rglob("*.kernel"))) == 1


def test_another_word_is_refused(monkeypatch):
    monkeypatch.setenv(variable("PIPELINE"), "fast")
    with pytest.raises(ValueError, match=r"PIPELINE must be lean or stock, got 'fast'"):
        instantiate(accelerate, "gravity")


@pytest.mark.parametrize("stock", [False, True])
@pytest.mark.parametrize("flags", [set(), {"contract", "nsz"}])
def test_a_kernel_has_the_fast_mathematics_that_it_is_given(flags, stock):
    dispatcher = jit(lambda x: x + 1.0, fast_math=flags, root=True, stock=stock)
    assert dispatcher.targetoptions["fastmath"] == flags
