"""A Mitsuba BSDF that adds to a .bsdf what a table cannot hold: the specular delta of the model.

    {"type": "with_specular", "table": {"type": "measured", ...}, "reflectance": "x.specular.csv"}

The file is what `hetab tabulate` writes beside a .bsdf. In linear sRGB, written over arrays: for
llvm_ad_rgb and cuda_ad_rgb."""
import drjit as dr
import mitsuba as mi
import numpy

NODES = 361  # of the reflectance in theta


def read_reflectance(path, weights):
    """[3][NODES], linear sRGB, equally spaced from 0 to 90 degrees."""
    table = numpy.genfromtxt(path, delimiter=",", names=True)
    bands = [table[table["wavelength_nm"] == nm] for nm in numpy.unique(table["wavelength_nm"])]
    theta = numpy.linspace(0, 90, NODES)
    rho_s = [numpy.interp(theta, band["theta_i_deg"], band["rho_s"]) for band in bands]
    return numpy.clip(weights @ rho_s, 0, 1)


class WithSpecular(mi.BSDF):
    weights = None  # [3][wavelength], of linear sRGB

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        self.table = props["table"]
        reflectance = read_reflectance(props["reflectance"], self.weights).astype("f4")
        self.channels = [mi.Float(channel) for channel in reflectance]
        specular = mi.BSDFFlags.DeltaReflection | mi.BSDFFlags.FrontSide
        self.m_components = [self.table.flags(), int(specular)]
        self.m_flags = self.table.flags() | int(specular)

    def reflectance(self, wi):
        """Linear in theta between the nodes."""
        place = dr.safe_acos(wi.z) * (2 / dr.pi) * (NODES - 1)
        left = dr.clip(mi.UInt32(place), 0, NODES - 2)
        t = place - left
        return mi.Color3f(*(dr.fma(t, dr.gather(mi.Float, c, left + 1),
                                   (1 - t) * dr.gather(mi.Float, c, left))
                            for c in self.channels))

    def chance(self, rho):
        """That the specular reflection is sampled; where it is negligible, never."""
        mean = dr.mean(rho)
        return dr.select(mean > 1e-5, dr.clip(mean, 0.02, 0.95), 0)

    def sample(self, ctx, si, sample1, sample2, active=True):
        active &= si.wi.z > 0
        rho = self.reflectance(si.wi)
        chance = self.chance(rho)
        mirrored = active & (sample1 < chance)
        result, weight = self.table.sample(ctx, si, sample1, sample2, active & ~mirrored)
        weight = dr.select(mirrored, rho / chance, weight / (1 - chance))
        result.pdf = dr.select(mirrored, chance, result.pdf * (1 - chance))
        result.wo[mirrored] = mi.Vector3f(-si.wi.x, -si.wi.y, si.wi.z)
        result.eta = 1.0
        result.sampled_type[mirrored] = mi.UInt32(int(mi.BSDFFlags.DeltaReflection))
        result.sampled_component[mirrored] = 1
        return result, weight & active

    def eval(self, ctx, si, wo, active=True):
        return self.table.eval(ctx, si, wo, active)

    def pdf(self, ctx, si, wo, active=True):
        return self.table.pdf(ctx, si, wo, active) * (1 - self.chance(self.reflectance(si.wi)))

    def eval_pdf(self, ctx, si, wo, active=True):
        return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)

    def to_string(self):
        return f"WithSpecular[{self.table}]"


def with_specular(path):
    """The .bsdf at path with its delta."""
    stem = path.removesuffix(".bsdf")
    return {"type": "with_specular", "reflectance": stem + ".specular.csv",
            "table": {"type": "measured", "filename": path}}


def register(weights):
    """For the variant that was set when this module was imported."""
    WithSpecular.weights = weights
    mi.register_bsdf("with_specular", WithSpecular)
