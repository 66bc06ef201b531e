"""Bugs that the laws of a family must find, one for each law."""

from tests.mutants.mutant import Mutant

LAWS_OF = "tests/laws/test_every_model.py::test_it_obeys_the_laws_of_its_family"

LAWS = (
    Mutant(
        "directions of the orthographic camera not of unit length",
        "cameras/orthographic.py",
        (
            (
                "lanes_vec3(0.0) + vector(table, FORWARD)",
                "lanes_vec3(1e-3) + vector(table, FORWARD)",
            ),
        ),
        f"{LAWS_OF}[cameras-orthographic]",
    ),
    Mutant(
        "rays of the pinhole camera through the middles of the film's halves",
        "cameras/pinhole.py",
        (("vector(table, FORWARD) + x *", "vector(table, FORWARD) + 0.5 * x *"),),
        f"{LAWS_OF}[cameras-pinhole]",
    ),
    Mutant(
        "rays of a lens as far apart behind it as in it",
        "cameras/thin_lens.py",
        (("normalize(table[FOCUS] * axis - lens)", "normalize(table[FOCUS] * axis)"),),
        f"{LAWS_OF}[cameras-thin_lens]",
    ),
    Mutant(
        "samples of a lens crowd at its centre",
        "cameras/thin_lens.py",
        (
            (
                "lens_x, lens_y = square_to_disk_concentric(u_lens)",
                "lens_x, lens_y = (c * u_lens[0] for c in square_to_disk_concentric(u_lens))",
            ),
        ),
        f"{LAWS_OF}[cameras-thin_lens]",
    ),
    Mutant(
        "weights of the tent filter 2 % too large",
        "filters/tent.py",
        (("lanes(1.0)", "lanes(1.02)"),),
        f"{LAWS_OF}[filters-tent]",
    ),
    Mutant(
        "the box filter to the right of its pixel",
        "filters/box.py",
        (("r * (2.0 * u2[0] - 1.0)", "r * (2.0 * u2[0] - 0.98)"),),
        f"{LAWS_OF}[filters-box]",
    ),
    Mutant(
        "tails of the Gaussian filter too long",
        "filters/inverse_cdf.py",
        (("sqrt(2.0 * minimum(u, 1.0 - u))", "2.0 * minimum(u, 1.0 - u)"),),
        f"{LAWS_OF}[filters-gaussian]",
    ),
    Mutant(
        "negative lobes of a filter counted as positive",
        "filters/mitchell.py",
        (
            (
                "polynomial(x / half, spec.b, spec.c), spec.radius, change)",
                "polynomial(x / half, spec.b, spec.c), spec.radius)",
            ),
        ),
        f"{LAWS_OF}[filters-mitchell]",
    ),
    Mutant(
        "the largest value of a checkerboard is that of one colour",
        "textures/checkerboard.py",
        (("(max(pair) for pair", "(min(pair) for pair"),),
        f"{LAWS_OF}[textures-checkerboard]",
    ),
    Mutant(
        "the mean of a sum of textures without one of them",
        "textures/add.py",
        (("_sum(average(self.a), average(self.b))", "_sum(average(self.a), average(self.a))"),),
        f"{LAWS_OF}[textures-add]",
    ),
    Mutant(
        "machine code that rounds towards zero for down",
        "instructions.py",
        (('(simd.floor, 1, "floor")', '(simd.floor, 1, "trunc")'),),
        "tests/laws/test_every_model.py"
        "::test_machine_code_sees_every_texture_as_the_python_text_does",
        package="lanewise",
    ),
    Mutant(
        "a bench that looks at one offset of a filter twice",
        "laws/filters.py",
        (("store_lanes(out, i + n, dy)", "store_lanes(out, i + n, dx)"),),
        "tests/laws/test_compiled_benches.py::test_of_filters",
    ),
    Mutant(
        "a bench that looks at one channel of a texture twice",
        "laws/textures.py",
        (("store_lanes(out, i + n, value.y)", "store_lanes(out, i + n, value.x)"),),
        "tests/laws/test_compiled_benches.py::test_of_textures",
    ),
    Mutant(
        "a bench of cameras without the lens",
        "laws/cameras.py",
        (("load_lanes(u, i + 2 * n), load_lanes(u, i + 3 * n)", "0.5, 0.5"),),
        "tests/laws/test_compiled_benches.py::test_of_cameras",
    ),
    Mutant(
        "bump maps that see heights beside a point by the point's own place",
        "bsdfs/normals/shading_normals.py",
        (("p=surface.p + shift", "p=surface.p + 0.0 * shift"),),
        f"{LAWS_OF}[textures-noise]",
    ),
    Mutant(
        "the box of a disk 10 % too small",
        "shapes/disk.py",
        (("half = np.hypot(", "half = 0.9 * np.hypot("),),
        f"{LAWS_OF}[shapes-disk]",
    ),
    Mutant(
        "dp/du of a sphere for half a turn",
        "shapes/sphere.py",
        (("Vec3(-TWO_PI * sine * s, TWO_PI * sine * c", "Vec3(-PI * sine * s, PI * sine * c"),),
        f"{LAWS_OF}[shapes-sphere]",
    ),
    Mutant(
        "the area of an ellipsoid as of a ball of its volume",
        "shapes/sphere.py",
        (("float(4.0 * np.pi * a * b * r_g)", "float(4.0 * np.pi * (a * b * c) ** (2.0 / 3.0))"),),
        f"{LAWS_OF}[shapes-sphere]",
    ),
    Mutant(
        "a cube without its last side",
        "shapes/cube.py",
        (("for side in sides())", "for side in sides()[:5])"),),
        f"{LAWS_OF}[shapes-cube]",
    ),
    Mutant(
        "points of a shining disk crowd at its edge",
        "shapes/disk.py",
        (
            (
                "x, y = square_to_disk_concentric(u2)\n    to_light",
                "x, y = square_to_disk_concentric((sqrt(u2[0]), u2[1]))\n    to_light",
            ),
        ),
        f"{LAWS_OF}[shapes-disk]",
    ),
    Mutant(
        "a hit disk has half the density of its samples",
        "shapes/disk.py",
        (("(1.0 / gather(tables.data, k + AREA)", "(0.5 / gather(tables.data, k + AREA)"),),
        f"{LAWS_OF}[shapes-disk]",
    ),
    Mutant(
        "u of a sphere twice around",
        "shapes/sphere.py",
        (("arctan2(q.y, q.x) * INV_TWO_PI", "arctan2(q.y, q.x) * INV_PI"),),
        f"{LAWS_OF}[shapes-sphere]",
    ),
    Mutant(
        "dp/du of a sphere 2 % too long",
        "shapes/sphere.py",
        (("Vec3(-TWO_PI * sine * s, TWO_PI * sine * c", "Vec3(-6.4 * sine * s, 6.4 * sine * c"),),
        f"{LAWS_OF}[shapes-sphere]",
    ),
    Mutant(
        "a hit disk has 0.3 % less density than its samples",
        "shapes/disk.py",
        (("(1.0 / gather(tables.data, k + AREA)", "(0.997 / gather(tables.data, k + AREA)"),),
        f"{LAWS_OF}[shapes-disk]",
    ),
    Mutant(
        "the normal of a disk's samples 0.05 % too short",
        "shapes/disk.py",
        (
            (
                "cosine = -dot(wi, gather_vec3(data, k))",
                "cosine = -0.9995 * dot(wi, gather_vec3(data, k))",
            ),
        ),
        f"{LAWS_OF}[shapes-disk]",
    ),
    Mutant(
        "a point light that BSDF sampling is thought to find",
        "lights/point.py",
        (("lanes_mask(True)", "lanes_mask(False)"),),
        f"{LAWS_OF}[lights-point]",
    ),
    Mutant(
        "a point light that falls with the distance alone",
        "lights/point.py",
        (("lanes_vec3(1.0) * falling", "lanes_vec3(1.0) * falling * distance"),),
        f"{LAWS_OF}[lights-point]",
    ),
    Mutant(
        "the power of a point light over half of the sphere",
        "lights/point.py",
        (("return 4.0 * PI * luminance", "return 2.0 * PI * luminance"),),
        f"{LAWS_OF}[lights-point]",
    ),
    Mutant(
        "light at a point softened near it",
        "lights/at_point.py",
        (("where(apart, 1.0 / squared, 0.0)", "where(apart, 1.0 / (squared + 4e-4), 0.0)"),),
        f"{LAWS_OF}[lights-point]",
    ),
    Mutant(
        "the mean of a spot 0.3 % too high",
        "lights/spot.py",
        (("0.5 * (1.0 - slope)", "0.5015 * (1.0 - slope)"),),
        f"{LAWS_OF}[lights-spot]",
    ),
    Mutant(
        "rays of a point light carry 0.4 % too much",
        "lights/point.py",
        (("lanes_vec3(1.0 / INV_FOUR_PI)", "lanes_vec3(1.004 / INV_FOUR_PI)"),),
        f"{LAWS_OF}[lights-point]",
    ),
    Mutant(
        "directions to a uniform sky crowd at its top",
        "lights/constant.py",
        (("square_to_uniform_sphere(u2)", "square_to_uniform_sphere((u2[0] * u2[0], u2[1]))"),),
        f"{LAWS_OF}[lights-constant]",
    ),
    Mutant(
        "the power of a uniform sky through half of the scene's disk",
        "lights/constant.py",
        (("return 4.0 * PI * PI * radius", "return 2.0 * PI * PI * radius"),),
        f"{LAWS_OF}[lights-constant]",
    ),
    Mutant(
        "a hit lamp has half the density of its samples",
        "lights/area.py",
        (("where(hit.cosine > 0.0, density, 0.0)", "where(hit.cosine > 0.0, 0.5 * density, 0.0)"),),
        f"{LAWS_OF}[lights-area]",
    ),
    Mutant(
        "a map whose mean is a tenth of a percent too high",
        "lights/environment_map.py",
        (("mean = [float((share", "mean = [1.001 * float((share"),),
        f"{LAWS_OF}[lights-environment]",
    ),
    Mutant(
        "the power of a lamp as if it shone straight ahead",
        "lights/area.py",
        (("return PI * area * luminance", "return 2.0 * PI * area * luminance"),),
        f"{LAWS_OF}[lights-area]",
    ),
    Mutant(
        "Rayleigh's phase function for a quarter of the sphere",
        "phases/rayleigh.py",
        (("0.75 * INV_FOUR_PI", "3.0 * INV_FOUR_PI"),),
        f"{LAWS_OF}[phases-rayleigh]",
    ),
    Mutant(
        "Rayleigh's cosines drawn uniformly",
        "phases/rayleigh.py",
        (("1.0 - where(c < 0.0, -mu, mu)", "1.0 - 0.5 * c + 0.0 * mu"),),
        f"{LAWS_OF}[phases-rayleigh]",
    ),
    Mutant(
        "media add light where they scatter, too",
        "integrators/interiors/collisions.py",
        (("absorbed = lanes_vec3(1.0) - albedo", "absorbed = lanes_vec3(1.0) + 0.0 * albedo"),),
        f"{LAWS_OF}[media-homogeneous]",
    ),
    Mutant(
        "flights half as long, with the weights of whole ones",
        "media/homogeneous.py",
        (
            (
                "distance = minimum(where(scattered, t, segment.length), FARTHEST)",
                "distance = minimum(where(scattered, 0.5 * t, segment.length), FARTHEST)",
            ),
        ),
        f"{LAWS_OF}[media-homogeneous]",
    ),
    Mutant(
        "shadow rays through media dimmed by the first channel",
        "media/homogeneous.py",
        (("exp(-extinction.y * distance)", "exp(-extinction.x * distance)"),),
        f"{LAWS_OF}[media-homogeneous]",
    ),
    Mutant(
        "a random walk of the hemisphere's density",
        "integrators/random_walk.py",
        (("f_cos * (1.0 / INV_FOUR_PI)", "f_cos * (0.5 / INV_FOUR_PI)"),),
        f"{LAWS_OF}[integrators-random_walk]",
    ),
    Mutant(
        "direct light with one more reflection",
        "integrators/direct.py",
        (("max_depth=MAX_DEPTH)", "max_depth=MAX_DEPTH + 1)"),),
        f"{LAWS_OF}[integrators-direct]",
    ),
    Mutant(
        "survivors of roulette as bright as before",
        "integrators/roulette.py",
        (("where(playing, beta / survival, beta)", "beta"),),
        f"{LAWS_OF}[integrators-path]",
    ),
    Mutant(
        "the openness of a point can be below 0",
        "integrators/ambient_occlusion.py",
        (("where(active & ~shut, path.beta, L)", "where(active & ~shut, path.beta, -path.beta)"),),
        f"{LAWS_OF}[integrators-ambient_occlusion]",
    ),
    Mutant(
        "black lifted by AgX's sigmoid",
        "tone_curves/agx.py",
        (("0.4298, 0.1191, -0.00232]", "0.4298, 0.1191, 0.00232]"),),
        f"{LAWS_OF}[tone_curves-agx]",
    ),
    Mutant(
        "Hable's curve does not begin at black",
        "tone_curves/hable.py",
        (("return top / bottom - NUMERATOR / DENOMINATOR", "return top / bottom"),),
        f"{LAWS_OF}[tone_curves-hable]",
    ),
    Mutant(
        "Narkowicz's toe of another curve than its inverse",
        "tone_curves/aces.py",
        (("(rgb * (2.43 * rgb + 0.59) + 0.14)", "(rgb * (2.43 * rgb + 0.59) + 0.15)"),),
        f"{LAWS_OF}[tone_curves-aces]",
    ),
    Mutant(
        "Reinhard's curve divides by the mean of the picture",
        "tone_curves/reinhard.py",
        (
            (
                "(rgb @ LUMINANCE))[..., None]",
                "(rgb @ LUMINANCE).mean() + 0.0 * rgb[..., 0])[..., None]",
            ),
        ),
        f"{LAWS_OF}[tone_curves-reinhard]",
    ),
    Mutant(
        "weights of relMSE with another epsilon than its own",
        "metrics/relmse_literature.py",
        (("reference**2 + np.float32(LITERATURE_EPSILON)", "reference**2 + np.float32(0.02)"),),
        f"{LAWS_OF}[metrics-relmse_literature]",
    ),
    Mutant(
        "SMAPE of the square of the sum",
        "metrics/smape.py",
        (("(np.abs(a) + np.abs(b) + epsilon)", "(np.abs(a) * np.abs(b) + epsilon)"),),
        f"{LAWS_OF}[metrics-smape]",
    ),
    Mutant(
        "an error map of one channel",
        "metrics/flip.py",
        (("    return _of(pair).error\n", "    return _of(pair).error[:, :1]\n"),),
        f"{LAWS_OF}[metrics-flip]",
    ),
    Mutant(
        "pictures on a display without their exposure",
        "metrics/model.py",
        (("* 2.0**self.exposure", "* 1.0"),),
        "tests/extension/test_users_metrics.py::test_what_a_display_shows_is_cut_at_its_exposure",
    ),
    Mutant(
        "a metric's map is not what is compared by",
        "view/contrast.py",
        (("METRICS[way], Pair(image, other)", "METRICS[way], Pair(other, other)"),),
        "tests/extension/test_users_metrics.py::test_the_view_compares_by_its_map",
    ),
    Mutant(
        "the reference's noise stays in squared errors",
        "lab/figures.py",
        ((" - self._noise[name]\n", "\n"),),
        "tests/lab/test_laws_of_blocks.py"
        "::test_figures_subtract_the_references_noise_pixel_by_pixel",
    ),
)
