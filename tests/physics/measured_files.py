"""Tensor files of metals that are known, as a laboratory would measure them.

Nothing here is that of the reader: densities are integrated and inverted on a fine grid.
"""

import struct

import numpy as np

#: How many parts a texel is cut into for integrals.
FINE = 8


def write(path, fields):
    """A tensor file, field after field."""
    kinds = {"float32": 10, "uint8": 1}
    at = 12 + 2 + 4 + sum(2 + len(n) + 2 + 1 + 8 + 8 * a.ndim for n, a in fields.items())
    head, body = b"tensor_file\x00" + bytes([1, 0]) + struct.pack("<I", len(fields)), b""
    for name, array in fields.items():
        head += struct.pack("<H", len(name)) + name.encode() + struct.pack("<H", array.ndim)
        head += bytes([kinds[array.dtype.name]]) + struct.pack("<Q", at + len(body))
        head += struct.pack(f"<{array.ndim}Q", *array.shape)
        body += array.tobytes()
    path.write_bytes(head + body)
    return path


def directions(u, v):
    theta, phi = np.pi / 2 * u**2, (2 * v - 1) * np.pi
    x, y = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi)
    return np.stack([x, y, np.cos(theta) + 0 * phi], axis=-1)


def lattice(height, width):
    return np.meshgrid(np.linspace(0, 1, width), np.linspace(0, 1, height))


def area_seen(w, ax, ay):
    """Projected area of the facets of GGX."""
    return 0.5 * (
        w[..., 2] + np.sqrt((ax * w[..., 0]) ** 2 + (ay * w[..., 1]) ** 2 + w[..., 2] ** 2)
    )


def facet_density(m, ax, ay):
    return 1 / (
        np.pi * ax * ay * ((m[..., 0] / ax) ** 2 + (m[..., 1] / ay) ** 2 + m[..., 2] ** 2) ** 2
    )


def fresnel(cosine, eta, k):
    """Unpolarised reflectance of a metal, by complex numbers."""
    n = np.asarray(eta) + 1j * np.asarray(k)
    cosine = np.clip(cosine, 0, 1)[..., None]
    inner = np.sqrt(n**2 - (1 - cosine**2))
    s = (cosine - inner) / (cosine + inner)
    p = (n**2 * cosine - inner) / (n**2 * cosine + inner)
    return 0.5 * (abs(s) ** 2 + abs(p) ** 2)


def refined(values):
    """A bilinear table, read in steps of 1 / FINE of a texel."""
    for axis in (0, 1):
        old = np.arange(values.shape[axis])
        new = np.linspace(0, old[-1], old[-1] * FINE + 1)
        values = np.apply_along_axis(lambda row, x=new, o=old: np.interp(x, o, row), axis, values)
    return values


def cumulated(values):
    steps = 0.5 * (values[..., 1:] + values[..., :-1])
    return np.concatenate([np.zeros((*values.shape[:-1], 1)), np.cumsum(steps, axis=-1)], axis=-1)


def warped(density, u):
    """Where points u of the square come to, if they are spread like a bilinear density."""
    fine = refined(density)
    rows = cumulated(cumulated(fine)[:, -1])
    y = np.interp(u[..., 1] * rows[-1], rows, np.linspace(0, 1, len(rows)))
    found = np.zeros_like(u)
    found[..., 1] = y
    for index in np.ndindex(y.shape):
        at = y[index] * (len(fine) - 1)
        i = min(int(at), len(fine) - 2)
        along = cumulated(fine[i] + (at - i) * (fine[i + 1] - fine[i]))
        x = np.linspace(0, 1, len(along))
        found[(*index, 0)] = np.interp(u[(*index, 0)] * along[-1], along, x)
    return found


def metal(
    alpha, eta, k, thetas, phis=(0.0,), facets=(65, 65), colors=24, alpha_y=None, wavelengths=None
):
    """The fields of a file; eta and k a channel, or with wavelengths one of each."""
    ax, ay = alpha, alpha_y or alpha
    isotropic = len(phis) <= 2
    u, v = lattice(*facets)
    m = directions(u, v)
    jacobian = u * np.sin(np.pi / 2 * u**2)
    side = lattice(2 if isotropic else facets[0], facets[1])
    ground = directions(*side)
    square = np.stack(lattice(colors, colors), axis=-1)
    vndf = np.zeros((len(phis), len(thetas), *facets))
    light = np.zeros((len(phis), len(thetas), len(eta), colors, colors))
    for i, phi in enumerate(phis):
        for j, theta in enumerate(thetas):
            wo = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
            vndf[i, j] = facet_density(m, ax, ay) * np.maximum(m @ wo, 0) * jacobian
            place = warped(vndf[i, j].astype(np.float32).astype(float), square)
            wm = directions(place[..., 0], place[..., 1])
            cosine = wm @ wo
            wi = 2 * cosine[..., None] * wm - wo
            masking = np.maximum(wi[..., 2], 0) / np.maximum(area_seen(wi, ax, ay), 1e-9)
            light[i, j] = np.moveaxis(fresnel(cosine, eta, k) * masking[..., None], -1, 0)
    fields = {
        "theta_i": np.array(thetas), "phi_i": np.array(phis), "ndf": facet_density(ground, ax, ay),
        "sigma": area_seen(ground, ax, ay), "vndf": vndf, "luminance": light.mean(axis=2),
        ("rgb" if wavelengths is None else "spectra"): light,
    }  # fmt: skip
    if wavelengths is not None:
        fields["wavelengths"] = np.array(wavelengths)
    made = {name: np.ascontiguousarray(array, "<f4") for name, array in fields.items()}
    made["description"] = np.frombuffer(b"a metal", np.uint8)
    made["jacobian"] = np.ones(1, np.uint8)
    return made
