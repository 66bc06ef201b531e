"""The sums of `alight.metrics.own_error` over large pictures, by machine code.

NumPy takes some hundred passes over planes of pixels for them. These loops take one for classes of
noisy pixels, and one for the products of errors, row by row. Small pictures do not
wait for machine code. Both say the same up to rounding where replicates are halved in one way.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from alight.core.maths import log
from alight.metrics.few_pixels import FewPixels
from alight.metrics.noisy_pixels import CLASSES, GROUPS, GUARD, PRECISE, no_sums
from alight.metrics.packets import (
    Place,
    add_to,
    around_of,
    class_of_pixels,
    half_of,
    inverse_square,
    known_of,
    mean_of,
    picture_of,
    samples_of,
)
from alight.metrics.surroundings import CELL
from alight.metrics.survey import BAND, Survey
from lanewise.jit import instantiate, kernel
from lanewise.simd import (
    LANES,
    WIDEST,
    any_lane,
    gather,
    lane_index,
    lanes,
    load_lanes,
    local_floats,
    local_uints,
    mask_bits,
    maximum,
    sqrt,
    store_lanes,
    trailing_zeros,
    where,
)
from lanewise.view import View

#: Of so many rows one is looked at, to see how unlike their surroundings pixels are.
ROWS = 4

#: What is kept of a noisy pixel: the rows of `noisy_pixels.no_sums`.
_SUMS = 9

#: Numbers that a row of pixels adds up, for each of its pixels: the products of errors over pixels,
#: their trace, and its square and fourth power at least.
_ALONG = 4

#: Pairs of channels, each above or on the diagonal.
_PAIRS = 6

#: r is 0.02 to 10^24, and its square no float32: products of two numbers of that size are added up
#: in parts of this size, squared.
_PARTS = 1e-6

#: The sums that are.
_OF_SQUARES = (2, 4, 7)

#: Room for a packet's numbers, each in a row of its own.
_THREE_ROWS, _NINE_ROWS, _ROWS_OF_SUMS = 3 * WIDEST, 9 * WIDEST, _SUMS * WIDEST


@kernel(strict=True)
def learn(picture, sums, totals):
    """First pass: sums over the noisy pixels, and the error of the others.

    Parameters
    ----------
    picture : Picture
    sums : View of float64
        As `noisy_pixels.no_sums`, its first axis last.
    totals : View of float64
        Error of the pixels that know their brightness; how unlike their surroundings they are,
        and of how many that is.
    """
    rows = local_floats(_THREE_ROWS)
    for y in range(picture.height):
        value, unlike, number = lanes(0.0), lanes(0.0), lanes(0.0)
        for start in range(0, picture.width, LANES):
            x = min(start, picture.width - LANES)
            place = Place(y, x, y * picture.width + x)
            known = known_of(picture, place) & (lane_index() + x >= start)
            group = (5 * (y // CELL) + (lane_index() + x) // CELL) % GROUPS
            for c in range(picture.channels):
                a = half_of(picture, place, c, 0, picture.replicates // 2)
                b = half_of(picture, place, c, picture.replicates // 2, picture.replicates)
                q2 = around_of(picture, place, c)
                knows_a, more_a = learn_half(picture, sums, known, group, q2, a, b)
                knows_b, more_b = learn_half(picture, sums, known, group, q2, b, a)
                value = value + (more_a + more_b)
                if y % ROWS == 0:
                    both = known & knows_a & knows_b
                    own_a = a.brightness * a.brightness + picture.epsilon
                    own_b = b.brightness * b.brightness + picture.epsilon
                    logs = log(own_a / q2) * log(own_b / q2)
                    unlike = unlike + where(both, logs, 0.0)
                    number = number + where(both, 1.0, 0.0)
        store_lanes(rows, 0, value)
        store_lanes(rows, LANES, unlike)
        store_lanes(rows, 2 * LANES, number)
        for i in range(3):
            for lane in range(LANES):
                totals[i] += rows[i * LANES + lane]


@kernel(strict=True)
def learn_half(picture, sums, known, group, q2, a, b):
    """Pixels that know themselves by A, and their error; the noisy ones go to `sums`."""
    epsilon = picture.epsilon
    own, total = a.brightness * a.brightness + epsilon, a.samples + b.samples
    error, noise = a.scatter / total, b.scatter / b.samples
    knows = error < PRECISE * maximum(own, q2)
    noisy = known & ~knows
    if any_lane(noisy):
        gather_pixels((sums, group, epsilon), noisy, error, own, q2, b)
    plain = inverse_square(maximum(b.brightness, GUARD * a.brightness), noise, epsilon)
    return knows, where(known & knows, error * plain, 0.0)


@kernel(strict=True)
def gather_pixels(into, noisy, error, own, q2, b):
    """`noisy_pixels.gather` of a packet."""
    sums, group, epsilon = into
    key = class_of_pixels(own, q2, error) * GROUPS + group
    inverse, noise = 1.0 / q2, b.scatter / b.samples
    r, rho, floor = error * inverse, b.brightness * sqrt(inverse), epsilon * inverse
    keys, rows = local_uints(WIDEST), local_floats(_ROWS_OF_SUMS)
    store_lanes(keys, 0, key)
    store_lanes(rows, 0, r)
    store_lanes(rows, LANES, r * rho)
    part, quiet = _PARTS * r, noise * inverse
    store_lanes(rows, 2 * LANES, part * (_PARTS * (rho * rho - quiet)))
    store_lanes(rows, 3 * LANES, r * floor)
    store_lanes(rows, 4 * LANES, part * part)
    store_lanes(rows, 5 * LANES, r * sqrt(r))
    store_lanes(rows, 6 * LANES, r * log(own * inverse))
    store_lanes(rows, 7 * LANES, part * (_PARTS * quiet))
    store_lanes(rows, 8 * LANES, where(rho < 0.0, r / floor, 0.0))
    bits = mask_bits(noisy)
    while bits != 0:
        lane = trailing_zeros(bits)
        bits &= bits - 1
        at = keys[lane] * _SUMS
        for i in range(_SUMS):
            sums[at + i] += rows[i * LANES + lane]


@kernel(strict=True)
def weight_of(factors, a, b, q2, epsilon):
    """What A's squared error is multiplied by in products with B's: as `own_error` has it."""
    total = a.samples + b.samples
    own_a, error_a = a.brightness * a.brightness + epsilon, a.scatter / total
    own_b, error_b = b.brightness * b.brightness + epsilon, b.scatter / total
    noise = b.scatter / b.samples
    plain = inverse_square(maximum(b.brightness, GUARD * a.brightness), noise, epsilon)
    quiet = maximum(b.brightness - sqrt(noise), 0.0)
    unsure = error_b >= PRECISE * own_b
    plain = where(unsure, maximum(sqrt(plain) / sqrt(quiet * quiet + epsilon), plain), plain)
    noisy = error_a >= PRECISE * maximum(own_a, q2)
    if any_lane(noisy):
        believed = gather(factors, class_of_pixels(own_a, q2, error_a)) / q2
        plain = where(noisy, believed, plain)
    return plain


@kernel(strict=True)
def multiply(picture, factors, cells, along, totals):
    """Second pass: products of both halves' errors.

    Parameters
    ----------
    picture : Picture
    factors : View of float32
        The weight of each class, times q^2.
    cells, along : View of float32
        Room for 13 and for 4 numbers in each pixel of a row, all 0.
    totals : View of float64
        Sum of the products over pixels, the three sums of `few_pixels.FewPixels`, the products
        pooled by cells, and the sum of the larger ones of both, band by band.
    """
    w = picture.width
    for y in range(picture.height):
        for start in range(0, w, LANES):
            x = min(start, w - LANES)
            place = Place(y, x, y * w + x)
            known = known_of(picture, place) & (lane_index() + x >= start)
            multiply_pixels(picture, factors, cells, along, place, known)
        for i in range(_ALONG):
            for x in range(w):
                totals[i] += along[i * w + x]
                along[i * w + x] = 0.0
        if y % CELL == CELL - 1 or y == picture.height - 1:
            for x in range(0, w, CELL):
                pool(cells, totals, w, x)
        if y % BAND == BAND - 1 or y == picture.height - 1:
            totals[_ALONG + 1] += max(totals[0], totals[_ALONG])
            totals[0] = 0.0
            totals[_ALONG] = 0.0


@kernel(strict=True)
def pool(cells, totals, width, first):
    """Add the products of a cell, and begin anew in its place."""
    last = min(first + CELL, width)
    known = 0.0
    for x in range(first, last):
        known += cells[2 * _PAIRS * width + x]
        cells[2 * _PAIRS * width + x] = 0.0
    # Pairs are 00, 10, 11, 20, 21, 22: off the diagonal, each stands for two.
    for i in range(_PAIRS):
        left, right = 0.0, 0.0
        for x in range(first, last):
            left += cells[i * width + x]
            right += cells[(_PAIRS + i) * width + x]
            cells[i * width + x] = 0.0
            cells[(_PAIRS + i) * width + x] = 0.0
        totals[_ALONG] += (
            left * right * (1.0 if i == 0 or i == 2 or i == 5 else 2.0) / max(known, 1.0)
        )


@kernel(strict=True)
def multiply_pixels(picture, factors, cells, along, place, known):
    """Add a packet of pixels to the rows."""
    half, last, w = picture.replicates // 2, picture.replicates, picture.width
    n, epsilon = last - 1.0, picture.epsilon
    # Of each channel: both halves' brightness, and the root of what its error is multiplied by.
    rows, inverse = local_floats(_NINE_ROWS), lanes(0.0)
    for c in range(picture.channels):
        a = half_of(picture, place, c, 0, half)
        b = half_of(picture, place, c, half, last)
        q2 = around_of(picture, place, c)
        by_a, by_b = weight_of(factors, a, b, q2, epsilon), weight_of(factors, b, a, q2, epsilon)
        # Where a pixel is not known, nothing is added.
        inverse = where(known, 1.0 / (a.samples + b.samples), 0.0)
        store_lanes(rows, 3 * c * LANES, a.brightness)
        store_lanes(rows, (3 * c + 1) * LANES, b.brightness)
        store_lanes(rows, (3 * c + 2) * LANES, sqrt(sqrt(by_a) * sqrt(by_b) * inverse))
    crossed, trace, square, pair = lanes(0.0), lanes(0.0), lanes(0.0), 0
    for c in range(picture.channels):
        for d in range(c + 1):
            scale = load_lanes(rows, (3 * c + 2) * LANES) * load_lanes(rows, (3 * d + 2) * LANES)
            left = covariance_of(picture, place, rows, (c, d, 0, 0, half)) * scale
            right = covariance_of(picture, place, rows, (c, d, 1, half, last)) * scale
            add_to(cells, pair * w + place.x, left)
            add_to(cells, (_PAIRS + pair) * w + place.x, right)
            twice, own, pair = (1.0 if c == d else 2.0), 0.5 * (left + right), pair + 1
            crossed = crossed + twice * left * right
            square = square + twice * own * own
            trace = trace + (own if c == d else 0.0 * own)
    whole = trace * trace
    square = (square - whole / n) * (n * n / ((n + 2.0) * (n - 1.0)))
    least = maximum(whole / (3.0 + 2.0 / n), square)
    add_to(cells, 2 * _PAIRS * w + place.x, where(known, 1.0, 0.0))
    add_to(along, place.x, crossed)
    add_to(along, w + place.x, trace)
    add_to(along, 2 * w + place.x, least)
    add_to(along, 3 * w + place.x, least * least)


@kernel(strict=True)
def covariance_of(picture, place, rows, which):
    """As `Half.scatter`, of two channels, whose brightness by this half is in `rows`."""
    c, d, half, first, last = which
    brightness_c = load_lanes(rows, (3 * c + half) * LANES)
    brightness_d = load_lanes(rows, (3 * d + half) * LANES)
    product = lanes(0.0)
    for r in range(first, last):
        left = mean_of(picture, place, r, c) - brightness_c
        right = mean_of(picture, place, r, d) - brightness_d
        product = product + left * right * samples_of(picture, place, r)
    return product * (1.0 / (last - first - 1))


@lru_cache(maxsize=2)
def _compiled(text: Callable) -> Callable:
    """Machine code; it is the same for all pictures."""
    return instantiate(text)


class Loops:
    """Both passes over one picture, with one epsilon.

    Parameters
    ----------
    seen : Survey
        Of at least 4 replicates, and `WIDEST` pixels wide.
    epsilon : float
        > 0.
    compiled : bool, default True
        False has the same text run by Python, for tests.
    """

    def __init__(self, seen: Survey, epsilon: float, compiled: bool = True):
        self._picture = picture_of(seen, epsilon)
        self._run = _compiled if compiled else lambda text: text

    def learn(self) -> tuple[np.ndarray, float, float, int]:
        """First pass: sums of classes, the other pixels' error, their unlikeness and its number."""
        sums, totals = np.zeros((CLASSES * GROUPS, _SUMS)), np.zeros(3)
        self._run(learn)(self._picture, View(sums), View(totals))
        sums[:, _OF_SQUARES] /= _PARTS**2
        sums = np.ascontiguousarray(sums.T).reshape(no_sums().shape)
        return sums, float(totals[0]), float(totals[1]), int(totals[2])

    def multiply(self, weights: np.ndarray, few: FewPixels) -> float:
        """Second pass: the sum of sigma^4 by products of halves, given the weights of classes."""
        w, totals = self._picture.width, np.zeros(_ALONG + 2)
        factors = View(np.ascontiguousarray(weights, np.float32))
        cells, along = (np.zeros(n * w, np.float32) for n in (2 * _PAIRS + 1, _ALONG))
        self._run(multiply)(self._picture, factors, View(cells), View(along), View(totals))
        _, *sums, _, spread = totals.tolist()
        few.add_sums(*sums)
        return spread
