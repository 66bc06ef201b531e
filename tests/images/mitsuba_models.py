"""Models that Mitsuba 3 lacks, as plug-ins for it: an independent second opinion on ours.

Both sample the hemisphere uniformly, whatever their shape: noisier than our own sampling, and free
of any mistake in it.
"""

from typing import Any


def register(mi: Any) -> None:
    """Make ``modified_phong`` and ``uniform_scatter`` known to Mitsuba; a variant must be set."""
    import drjit as dr

    class HemisphereBsdf(mi.BSDF):
        """Any one-sided BSDF without delta lobes; `value` is f, without the cosine."""

        def __init__(self, properties: Any) -> None:
            mi.BSDF.__init__(self, properties)
            self.properties = {name: properties[name] for name in properties.property_names()}
            flags = mi.BSDFFlags.DiffuseReflection | mi.BSDFFlags.FrontSide
            self.m_flags = flags
            self.m_components = [flags]

        def colour(self, name: str) -> Any:
            """Read a grey reflectance."""
            return mi.Color3f(self.properties[name])

        def value(self, to_camera: Any, to_light: Any) -> Any:
            raise NotImplementedError

        def sample(self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True) -> Any:
            direction = mi.warp.square_to_uniform_hemisphere(sample2)
            sample = mi.BSDFSample3f()
            sample.wo = direction
            sample.pdf = 0.5 * dr.inv_pi
            sample.eta = 1.0
            sample.sampled_type = mi.UInt32(+mi.BSDFFlags.DiffuseReflection)
            sample.sampled_component = 0
            active &= (si.wi.z > 0) & (direction.z > 0)
            weight = self.value(si.wi, direction) * direction.z * (2 * dr.pi)
            return sample, dr.select(active, weight, 0.0)

        def eval(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            active &= (si.wi.z > 0) & (wo.z > 0)
            return dr.select(active, self.value(si.wi, wo) * wo.z, 0.0)

        def pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return dr.select((si.wi.z > 0) & (wo.z > 0), 0.5 * dr.inv_pi, 0.0)

        def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)

        def to_string(self) -> str:
            return type(self).__name__

    class ModifiedPhong(HemisphereBsdf):
        """Lafortune and Willems (1994): rho_d / pi + rho_s (n + 2) / (2 pi) cos^n alpha."""

        def value(self, to_camera: Any, to_light: Any) -> Any:
            exponent = self.properties["exponent"]
            mirrored = mi.Vector3f(-to_camera.x, -to_camera.y, to_camera.z)
            cosine = dr.maximum(0.0, dr.dot(mirrored, to_light))
            lobe = dr.power(cosine, exponent) * ((exponent + 2) / (2 * dr.pi))
            return self.colour("diffuse") * dr.inv_pi + self.colour("specular") * lobe

    class UniformScatter(HemisphereBsdf):
        """The beginner's diffuse: rho / (2 pi cos theta)."""

        def value(self, to_camera: Any, to_light: Any) -> Any:
            return self.colour("reflectance") / (2 * dr.pi * dr.maximum(to_light.z, 1e-7))

    mi.register_bsdf("modified_phong", ModifiedPhong)
    mi.register_bsdf("uniform_scatter", UniformScatter)
