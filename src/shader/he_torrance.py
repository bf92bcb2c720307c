"""The He-Torrance reflectance model, whole, in one file. Written by hetab @VERSION@.

@ERROR@

Directions are unit vectors away from the surface, z its normal. Values are BRDFs in 1/sr without a
cosine; the specular delta is apart, as its reflectance. Lengths are in um."""
import base64
import json
import math

import numpy

# Coefficients of cubic B-splines: row 0 of A over s, the others of r over s and t.
TABLE = numpy.frombuffer(base64.b64decode("@TABLE@"), "<f4").reshape(@COUNT@ + 1, @COUNT@)
CELLS, SOFT_G, ROOT = @CELLS@, @SOFT_G@, @ROOT@
SOFT_V, MOST_T = @SOFT_V@, @MOST_T@
# Four neighbours side by side: a look-up reads one such run of each of four rows.
RUNS = numpy.ascontiguousarray(numpy.lib.stride_tricks.sliding_window_view(TABLE, 4, axis=1))

#: n and k of the built-in metals at 400, 410 ... 700 nm
METALS = json.loads("""@METALS@""")
#: {count: [[wavelength in nm, r, g, b], ...]}: linear sRGB under D65 from a few wavelengths
COLOUR_NODES = json.loads("""@COLOUR_NODES@""")
#: The surface that this file was made for, or None
SURFACE = json.loads("""@SURFACE@""")


class Numpy:
    """Arithmetic on numbers and numpy arrays; a renderer brings another."""
    sqrt, exp, log, cos, sin = numpy.sqrt, numpy.exp, numpy.log, numpy.cos, numpy.sin
    minimum, maximum, where = numpy.minimum, numpy.maximum, numpy.where

    @staticmethod
    def detach(x):
        return x

    @staticmethod
    def cell(place):
        """The interval of a place, as a number to compute with and as an index."""
        cell = numpy.minimum(numpy.floor(place), CELLS - 1)
        return cell, numpy.asarray(cell, "i4")

    @staticmethod
    def run(row, column):
        values = RUNS[row, column]
        return [values[..., k] for k in range(4)]

    @staticmethod
    def repeat(state, go_on, step):
        while numpy.any(go_on(*state)):
            on = go_on(*state)
            state = [numpy.where(on, new, old) for new, old in zip(step(*state), state)]
        return state


# ---- the series ------------------------------------------------------------------------------

def spline(N, place):
    """Index of the first of four coefficients, and their weights."""
    cell, index = N.cell(place)
    f = place - cell
    e = 1.0 - f
    return index, (e * e * e / 6.0, (4.0 - 3.0 * f * f * (1.0 + e)) / 6.0,
                   (4.0 - 3.0 * e * e * (1.0 + f)) / 6.0, f * f * f / 6.0)


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]


def ln_h(N, g, x):
    """ln of h(g, x) = e^-g sum_{m>=1} g^(m-1) / (m! m) e^(-x/m)."""
    g = N.maximum(g, 1e-15)
    v = x / (1.0 + g)
    i, along_s = spline(N, N.exp(ROOT * N.log(g / (g + SOFT_G))) * CELLS)
    j, along_t = spline(N, N.minimum(v / (v + SOFT_V) / MOST_T, 1.0) * CELLS)
    a = dot(along_s, N.run(0 * i, i))
    r = dot(along_s, [dot(along_t, N.run(i + (1 + k), j)) for k in range(4)])
    return a - v * (1.0 + r) - 2.0 * N.log(1.0 + g)


# ---- factors ---------------------------------------------------------------------------------

ERFC = (-1.2655122251, 1.0000236810, 0.3740919417, 0.0967843387, -0.1862887576, 0.2788698618,
        -1.1352067528, 1.4885184139, -0.8221534986, 0.1708730440)


def erfc(N, u):
    """Of u >= 0, relative error 3e-7: t e^(polynomial in t - u^2), t = 1 / (1 + u/2)."""
    t = 1.0 / (1.0 + 0.5 * u)
    p = ERFC[-1]
    for c in ERFC[-2::-1]:
        p = p * t + c
    return t * N.exp(p - u * u)


class Direction:
    """mu = cos(theta), s = sin(theta), S / mu (Eqs. 15-17), K (Eq. 22)."""

    def __init__(self, N, mu, s, tau_2sigma):
        self.mu = N.maximum(mu, 1e-9)
        self.s = s
        u = N.minimum(tau_2sigma * self.mu / N.maximum(s, 1e-9), 1e4)
        tail = erfc(N, u)
        a = 1.0 - 0.5 * tail
        self.shadow_over_cos = a / (
            self.mu * a + N.exp(-u * u) * s / (2.0 * math.sqrt(math.pi) * tau_2sigma))
        self.k = s / self.mu * tail


def ratio2(N, k_sum):
    """sigma^2 / sigma0^2 = 1 / (1 + W), W e^W = k_sum^2 / (8 pi) (Eqs. 20-21). The last of Newton's
    steps has the derivative of W."""
    l = 2.0 * N.log(N.maximum(k_sum, 1e-18)) - math.log(8.0 * math.pi)
    fixed = N.detach(l)
    e = N.exp(N.minimum(fixed, 1.0))
    w = N.where(fixed > 1.0, fixed - N.log(N.maximum(fixed, 1.0)), e / (1.0 + e))
    for _ in range(2):
        w = w * (1.0 + fixed - N.log(w)) / (1.0 + w)
    return 1.0 / (1.0 + w * (1.0 + l - N.log(w)) / (1.0 + w))


def fresnel(N, cos2, n, k):
    """Unpolarised reflectance |F|^2 of n + ik at cos^2 of the angle (Eq. 12)."""
    e1, nk = (n - 1.0) * (n + 1.0) - k * k, n * k
    c = N.sqrt(cos2)
    re = e1 + cos2
    m = N.sqrt(re * re + 4.0 * nk * nk + 1e-30)
    large = N.sqrt(0.5 * (m + N.where(re > 0.0, re, -re)))
    small = nk / N.maximum(large, 1e-15)
    a, b = N.where(re > 0.0, large, small), N.where(re > 0.0, small, large)
    difference = (e1 + b * b) / N.maximum(a + c, 1e-15)
    sin2, t = 1.0 - cos2, 2.0 * a * c
    u = m * cos2 + sin2 * sin2
    f = (difference * difference + b * b) * u / N.maximum((cos2 + m + t) * (u + t * sin2), 1e-30)
    return N.minimum(f, 1.0)


# ---- the model -------------------------------------------------------------------------------

class Pair:
    """What two directions of one roughness have in common at every wavelength."""

    def __init__(self, N, wi, wo, sigma0_um, tau_um):
        tau_2sigma = tau_um / (2.0 * sigma0_um)
        i = Direction(N, wi[2], N.sqrt(wi[0] * wi[0] + wi[1] * wi[1]), tau_2sigma)
        r = Direction(N, wo[2], N.sqrt(wo[0] * wo[0] + wo[1] * wo[1]), tau_2sigma)
        x, y, mu = wi[0] + wo[0], wi[1] + wo[1], i.mu + r.mu
        self.lateral2, self.mu2 = x * x + y * y, mu * mu
        self.ratio2 = ratio2(N, i.k + r.k)
        self.cos2 = N.minimum(0.25 * (self.mu2 + self.lateral2), 1.0)
        self.shadow = i.shadow_over_cos * r.shadow_over_cos * self.ratio2


def waves(sigma0_um, tau_um, lambda_um):
    """(2 pi sigma0 / lambda)^2 and (pi tau / lambda)^2."""
    g, x = 2.0 * math.pi * sigma0_um / lambda_um, math.pi * tau_um / lambda_um
    return g * g, x * x


def directional_diffuse(N, pair, sigma0_um, tau_um, lambda_um, n, k):
    """f_dd (Eq. 8), 1/sr."""
    wave_g, wave_x = waves(sigma0_um, tau_um, lambda_um)
    h = N.exp(ln_h(N, wave_g * pair.mu2 * pair.ratio2, wave_x * pair.lateral2))
    return (fresnel(N, pair.cos2, n, k) * pair.cos2 * pair.cos2 * (4.0 / math.pi) * wave_g * wave_x
            * pair.shadow * h)


def specular(N, i, sigma0_um, tau_um, lambda_um, n, k):
    """rho_s (Eq. 10) of a Direction: the delta's reflectance."""
    wave_g, _ = waves(sigma0_um, tau_um, lambda_um)
    shadow = i.shadow_over_cos * i.mu
    return (fresnel(N, i.mu * i.mu, n, k) * shadow * shadow
            * N.exp(-4.0 * wave_g * i.mu * i.mu * ratio2(N, 2.0 * i.k)))


def brdf(wi, wo, sigma0_um, tau_um, lambda_um, n, k, diffuse_reflectance=0.0):
    """f_dd + f_ud in 1/sr; wi and wo as (x, y, z), numbers or arrays."""
    pair = Pair(Numpy, wi, wo, sigma0_um, tau_um)
    dd = directional_diffuse(Numpy, pair, sigma0_um, tau_um, lambda_um, n, k)
    above = (wi[2] > 0.0) & (wo[2] > 0.0)
    return numpy.where(above, dd + diffuse_reflectance / math.pi, 0.0)


def specular_reflectance(wi, sigma0_um, tau_um, lambda_um, n, k):
    """rho_s: the weight of the delta in the mirror direction (-x, -y, z) of wi."""
    i = Direction(Numpy, wi[2], numpy.sqrt(wi[0] * wi[0] + wi[1] * wi[1]),
                  tau_um / (2.0 * sigma0_um))
    return specular(Numpy, i, sigma0_um, tau_um, lambda_um, n, k)


# ---- sampling --------------------------------------------------------------------------------
# Of f_dd: two lobes of the series about the mirror point with g held, at the mirror direction and
# nearer to the normal, and the cosine. Samples beyond the horizon are turned about the mirror point.

COSINE, SECOND, MANY = 0.15, 0.4, 30.0


def over_unity(N, g):
    """g / (1 - e^-g)."""
    return N.where(g < 0.05, 1.0 + g * (0.5 + g / 12.0), g / (1.0 - N.exp(-N.maximum(g, 0.05))))


def normal_quantile(N, u):
    """Of u in (0, 1): Giles's single-precision inverse error function."""
    y = 2.0 * u - 1.0
    w = -N.log(N.maximum((1.0 - y) * (1.0 + y), 1e-12))
    centre, tail = w - 2.5, N.sqrt(N.maximum(w, 5.0)) - 3.0
    p = q = 0.0
    for c in (2.81022636e-08, 3.43273939e-07, -3.5233877e-06, -4.39150654e-06, 0.00021858087,
              -0.00125372503, -0.00417768164, 0.246640727, 1.50140941):
        p = p * centre + c
    for c in (-0.000200214257, 0.000100950558, 0.00134934322, -0.00367342844, 0.00573950773,
              -0.0076224613, 0.00943887047, 1.00167406, 2.83297682):
        q = q * tail + c
    return math.sqrt(2.0) * y * N.where(w < 5.0, p, q)


def draw_term(N, g, u):
    """m of Poisson's distribution without 0; many: its first four cumulants (Cornish-Fisher)."""
    few = N.minimum(g, MANY)
    p = over_unity(N, few) * N.exp(-few)
    m, _, _ = N.repeat((1.0 + 0.0 * p, p, p), lambda m, p, c: (u > c) & (m < 100.0),
                       lambda m, p, c: (m + 1.0, p * few / (m + 1.0), c + p * few / (m + 1.0)))
    z, root = normal_quantile(N, N.minimum(N.maximum(u, 1e-7), 1.0 - 1e-7)), N.sqrt(g)
    many = g + root * z + (z * z - 1.0) / 6.0 + (z - z * z * z) / (72.0 * root)
    return N.where(g < MANY, m, N.maximum(many, 1.0))


class Lobes:
    """How f_dd is sampled at one incidence and wavelength."""

    def __init__(self, N, wi, i, sigma0_um, tau_um, lambda_um):
        self.N, self.wi, self.mu = N, wi, i.mu
        wave_g, self.wave_x = waves(sigma0_um, tau_um, lambda_um)
        part = wave_g * ratio2(N, 2.0 * i.k)
        slope = 2.0 * sigma0_um / tau_um
        turned = N.minimum(i.mu + 2.0 * slope * i.s, 1.0) + i.mu
        self.g = part * 4.0 * i.mu * i.mu, wave_g * turned * turned * N.sqrt(part / wave_g)

    def sample(self, u, v, w):
        """(wo, whether there is one) of three numbers in [0, 1)."""
        N, wi = self.N, self.wi
        first = (1.0 - COSINE) * (1.0 - SECOND)
        lobes, second = u < 1.0 - COSINE, u >= first
        rest = N.where(second, (u - first) / ((1.0 - COSINE) * SECOND), u / first)
        m = draw_term(N, N.where(second, self.g[1], self.g[0]), rest)
        radius = N.where(lobes, N.sqrt(-m * N.log(1.0 - v) / self.wave_x), N.sqrt(v))
        x, y = radius * N.cos(2.0 * math.pi * w), radius * N.sin(2.0 * math.pi * w)
        out = N.where(lobes & (self.beyond(x, y)), -1.0, 1.0)
        x, y = (N.where(lobes, out * x - wi[0], x), N.where(lobes, out * y - wi[1], y))
        z2 = 1.0 - x * x - y * y
        return (x, y, N.sqrt(N.maximum(z2, 0.0))), z2 > 0.0

    def beyond(self, x, y):
        """Whether an offset from the mirror point is beyond the horizon."""
        x, y = x - self.wi[0], y - self.wi[1]
        return x * x + y * y >= 1.0

    def density(self, wo):
        """With which sample() returns wo, 1/sr."""
        N = self.N
        x, y = wo[0] + self.wi[0], wo[1] + self.wi[1]
        at = self.wave_x * (x * x + y * y)
        first, second = (over_unity(N, g) * N.exp(ln_h(N, g, at)) for g in self.g)
        series = (1.0 - SECOND) * first + SECOND * second
        turned = N.where(self.beyond(-x, -y), 2.0, 1.0)
        return wo[2] / math.pi * (COSINE + (1.0 - COSINE) * turned * self.wave_x * series)
