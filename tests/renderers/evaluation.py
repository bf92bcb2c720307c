"""eval of a .bsdf against the model, incidence by incidence.

Viewers are drawn in the plane of direction cosines q, where an integral of f cos(theta) over
directions is one of f over the unit disc: a part all over the disc, the rest in Gaussians about the
mirror point that are about as wide as the lobe. Weights of 1 / density make the sums proportional
to integrals:

    L1   = integral of |table - model| cos dOmega / integral of model cos dOmega
    bias = integral of (table - model) cos dOmega / integral of model cos dOmega
"""
import math

import numpy

from model import WAVELENGTHS_NM

BOUNDED_DEG = tuple(range(0, 81, 5))
GRAZING_DEG = (85.0, 88.0, 89.0, 89.9)  # finite and not negative there; errors are reported
PAIRS = 100_000                         # of the bounded incidences together
WIDTHS = (0.4, 1.0)                     # Gaussians, in standard deviations of the lobe


def lobe_width(sigma0_um, tau_um):
    """Standard deviation of the lobe in q: the Beckmann limit of the series."""
    return 2 * math.sqrt(2) * sigma0_um / tau_um


def draw(random, theta_i, width, count):
    """(wi, wo, weight)[count]: unit vectors as single floats hold them, at random azimuths."""
    mirror = numpy.array([-math.sin(theta_i), 0.0])
    widths = [width * w for w in WIDTHS]
    drawn = 3 * count  # more than half of every component is inside the disc
    radius, turn = numpy.sqrt(random.random(drawn)), 2 * math.pi * random.random(drawn)
    q = numpy.stack([radius * numpy.cos(turn), radius * numpy.sin(turn)], axis=1)
    choice = random.integers(0, len(widths) + 1, drawn)
    for k, w in enumerate(widths):
        q[choice == k] = mirror + w * random.standard_normal((numpy.sum(choice == k), 2))
    q = q[(q * q).sum(axis=1) < 1][:count]
    distance2 = ((q - mirror) ** 2).sum(axis=1)
    density = 1 / math.pi + sum(numpy.exp(-distance2 / (2 * w * w)) / (2 * math.pi * w * w)
                                for w in widths)
    wo = numpy.column_stack([q, numpy.sqrt(1 - (q * q).sum(axis=1))])
    wi = numpy.broadcast_to([math.sin(theta_i), 0.0, math.cos(theta_i)], wo.shape)
    turn = 2 * math.pi * random.random(len(q))
    return (*(rotate(w, turn).astype("f4").astype("f8") for w in (wi, wo)), 1 / density)


def rotate(w, turn):
    cosine, sine = numpy.cos(turn), numpy.sin(turn)
    return numpy.stack([cosine * w[:, 0] - sine * w[:, 1], sine * w[:, 0] + cosine * w[:, 1],
                        w[:, 2]], axis=1)


class Pairs:
    """The pairs of a surface and what the model says of them, for every variant."""

    def __init__(self, model, width, seed=1):
        random = numpy.random.default_rng(seed)
        self.theta_deg = BOUNDED_DEG + GRAZING_DEG
        count = -(-PAIRS // len(BOUNDED_DEG))
        drawn = [draw(random, math.radians(t), width, count) for t in self.theta_deg]
        self.wi, self.wo, self.weight = (numpy.concatenate(arrays) for arrays in zip(*drawn))
        self.brdf = model.brdf(self.wi, self.wo)

    def compare(self, material, weights):
        """Errors at each incidence of a material; weights[channel][wavelength], of its colours."""
        expected = self.brdf if material.spectral else weights @ self.brdf
        value = material.eval(self.wi, self.wo, WAVELENGTHS_NM.tolist())
        difference = value / self.wo[:, 2] - expected
        shape = (len(expected), len(self.theta_deg), -1)
        error = (self.weight * difference).reshape(shape)
        total = (self.weight * expected).reshape(shape).sum(axis=2)
        return {"bad": int(numpy.sum(~(numpy.isfinite(value) & (value >= 0)))),
                "l1": numpy.abs(error).sum(axis=(0, 2)) / total.sum(axis=0),
                "l1_channel": (numpy.abs(error).sum(axis=2) / total).max(axis=0),
                "bias": error.sum(axis=(0, 2)) / total.sum(axis=0)}


def horizon_values(material):
    """Values and densities for directions at and below the horizon and at the poles."""
    edge = [[0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 1e-7], [1, 0, 1e-4], [0.6, 0, 0.8],
            [0.6, 0, -0.8], [0, 0, -1]]
    wi, wo = (numpy.array(w, "f8") for w in zip(*((a, b) for a in edge for b in edge)))
    values = material.eval(wi, wo, WAVELENGTHS_NM.tolist()).ravel()
    densities = [material.pdf(a, numpy.array(edge, "f8")) for a in edge]
    return numpy.concatenate([values, *densities])
