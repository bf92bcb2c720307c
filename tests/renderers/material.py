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
        for a, b, c, x, y, z in zip(*columns(wi), *columns(wo)):
            point.wi = vector(a, b, c)
            values.extend(call(context, point, vector(x, y, z)))
        return numpy.array(values).reshape(len(wo), -1).T

    def pdf(self, wi, wo):
        vector, call, context = self.mi.Vector3f, self.bsdf.pdf, self.context
        point = self.interaction(wi)
        return numpy.array([call(context, point, vector(x, y, z)) for x, y, z in zip(*columns(wo))])

    def sample(self, wi, uniform):
        """Directions [count][3] of the samples that have a weight, of uniform[count][2]."""
        vector, call, context = self.mi.Point2f, self.bsdf.sample, self.context
        point, directions = self.interaction(wi), []
        for u, v in zip(*columns(uniform)):
            drawn, weight = call(context, point, 0.5, vector(u, v))
            if any(weight):
                w = drawn.wo
                directions += (w.x, w.y, w.z)
        return numpy.array(directions).reshape(-1, 3)


def columns(array):
    """Lists of plain numbers: a list of rows would cost more than the calls."""
    return [column.tolist() for column in array.T]
