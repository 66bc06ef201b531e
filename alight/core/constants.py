"""Numbers that kernels share. Python floats here become float32 inside a kernel."""

PI = 3.14159265358979323846
TWO_PI = 2.0 * PI
HALF_PI = 0.5 * PI
INV_PI = 1.0 / PI
INV_TWO_PI = 0.5 / PI
INV_FOUR_PI = 0.25 / PI

INFINITY = float("inf")

#: Largest float32 below one: random numbers are clamped to it, so that u < 1 always holds.
ONE_MINUS_EPSILON = 1.0 - 2.0**-24

#: Half the distance from 1 to the next float32 (the "u" of error analysis).
MACHINE_EPSILON = 2.0**-24

#: Weights of red, green and blue in the luminance Y of linear sRGB (Rec. 709 primaries, D65).
LUMINANCE = (0.212671, 0.715160, 0.072169)


def gamma(n: int) -> float:
    """Bound of the relative error of ``n`` float32 operations in a row.

    Higham 2002, Accuracy and Stability of Numerical Algorithms, lemma 3.1.
    """
    return n * MACHINE_EPSILON / (1.0 - n * MACHINE_EPSILON)
