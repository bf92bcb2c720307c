"""A .bsdf in Mitsuba's scalar variants, called direction by direction from numpy arrays."""
import numpy

LANES = 4  # wavelengths in a call of the spectral variants


class Material:
    def __init__(self, mi, path):
        self.mi = mi
        self.bsdf = mi.load_dict({"type": "measured", "filename": path})
        self.context = mi.BSDFContext()
        self.spectral = "spectral" in mi.variant()

    def interaction(self, wi, wavelengths=None):
        point = self.mi.SurfaceInteraction3f()
        point.wi = wi
        if self.spectral:
            point.wavelengths = [550.0] * LANES if wavelengths is None else wavelengths
        return point

    def eval(self, wi, wo, wavelengths):
        """[channel][pair]: f cos(theta_o); channels are the wavelengths, or linear sRGB."""
        if not self.spectral:
            return self.eval_lanes(wi, wo, None)
        count = len(wavelengths)
        padded = list(wavelengths) + [wavelengths[-1]] * (-count % LANES)
        groups = [self.eval_lanes(wi, wo, padded[first:first + LANES])
                  for first in range(0, count, LANES)]
        return numpy.concatenate(groups)[:count]

    def eval_lanes(self, wi, wo, wavelengths):
        vector, call, context = self.mi.Vector3f, self.bsdf.eval, self.context
        point = self.interaction([0, 0, 1], wavelengths)
        values = []
        for towards, away in zip(wi.tolist(), wo.tolist()):
            point.wi = towards
            values.append(list(call(context, point, vector(away))))
        return numpy.array(values).T

    def pdf(self, wi, wo):
        vector, call, context = self.mi.Vector3f, self.bsdf.pdf, self.context
        point = self.interaction(wi)
        return numpy.array([call(context, point, vector(away)) for away in wo.tolist()])

    def sample(self, wi, uniform):
        """Directions [count][3] of the samples that have a weight, of uniform[count][2]."""
        vector, call, context = self.mi.Point2f, self.bsdf.sample, self.context
        point = self.interaction(wi)
        drawn = (call(context, point, 0.5, vector(u)) for u in uniform.tolist())
        return numpy.array([(s.wo.x, s.wo.y, s.wo.z) for s, weight in drawn if any(weight)])
