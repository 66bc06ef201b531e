"""Write ``values.npz``, what Mitsuba says of the materials of `values`: ``python make_values.py``.

Each entry is (4, 240) float32: f cos theta_i in three channels, and the density. Entries of the
bump map are named by the place in the picture. Needs ``pip install mitsuba``, and a libLLVM.
"""

from pathlib import Path
from typing import Any

import numpy as np
import values

OUTPUT = Path(__file__).parent / "values.npz"


def ask(mi: Any, bsdf: Any, uv: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    """Evaluate in the plane z = 0, whose texture coordinates are metres; v runs along -y."""
    import drjit as dr

    wo, wi = values.directions()
    n = wo.shape[1]
    surface = dr.zeros(mi.SurfaceInteraction3f, n)
    surface.t = mi.Float(1.0)
    surface.n = mi.Normal3f(0.0, 0.0, 1.0)
    surface.dp_du, surface.dp_dv = mi.Vector3f(1.0, 0.0, 0.0), mi.Vector3f(0.0, -1.0, 0.0)
    surface.sh_frame.s = mi.Vector3f(1.0, 0.0, 0.0)
    surface.sh_frame.t = mi.Vector3f(0.0, 1.0, 0.0)
    surface.sh_frame.n = mi.Normal3f(0.0, 0.0, 1.0)
    surface.uv = mi.Point2f(*uv)
    surface.wi = mi.Vector3f(*(mi.Float(c) for c in wo))
    value, pdf = bsdf.eval_pdf(mi.BSDFContext(), surface, mi.Vector3f(*(mi.Float(c) for c in wi)))
    out = np.vstack([np.array(value).reshape(3, -1), np.array(pdf).reshape(1, -1)])
    return np.broadcast_to(out, (4, n)).astype(np.float32)


def bump_map(mi: Any) -> Any:
    """Heights in metres."""
    picture = mi.Bitmap(values.HEIGHTS.astype(np.float32)[..., None])
    texture = {"type": "bitmap", "bitmap": picture, "raw": True, "wrap_mode": "clamp"}
    matte = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.7, 0.4, 0.2]}}
    return mi.load_dict({"type": "bumpmap", "scale": 0.1, "arbitrary": texture, "bsdf": matte})


def main() -> None:
    """Ask for all."""
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    found = {}
    for name, (kind, content) in (values.MATERIALS | values.SHARED).items():
        bsdf = mi.load_string(f'<bsdf version="3.0.0" type="{kind}">{content}</bsdf>')
        found[name] = ask(mi, bsdf)
    for place in values.PLACES:
        found[f"bump {place}"] = ask(mi, bump_map(mi), place)
    np.savez_compressed(OUTPUT, **found)
    print(mi.__version__, {name: float(found[name][1].mean()) for name in found})


if __name__ == "__main__":
    main()
