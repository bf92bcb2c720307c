"""The five surfaces of Li & Torrance, Background Data for Validation of the He-Torrance Model, TR
PCG-05-02 (2005), and synthetic scans with their statistics: its own are not published."""
from collections import namedtuple

import numpy as np

Surface = namedtuple("Surface", "raw_sigma raw_tau sigma tau spread size fitted_slope a")
SURFACES = {  # um; Table 1, the captions of Tables 3 to 7 ("filter size"), Table 2
    "BBQAL1": Surface(2.58, 27.2, 0.72, 5.6, 0.039, 30, 0.144, 0.70),
    "BBQAL2": Surface(1.24, 30.5, 0.54, 6.5, 0.068, 26, 0.080, 0.37),
    "GGAL120": Surface(2.66, 41.6, 0.86, 5.6, 0.045, 34, 0.166, 0.44),
    "GGAL240": Surface(1.63, 24.0, 0.61, 4.7, 0.041, 28, 0.158, 0.44),
    "NGGAL": Surface(0.21, 11.7, 0.13, 5.4, 0.053, 34, 0.020, 0.0)}
SCANS, POINTS, SPACING_UM = 9, 4000, 0.1


def large_scale(s):
    """sigma and tau of what has to be added: at lag raw_tau the sum falls to 1/e."""
    large = np.sqrt(s.raw_sigma**2 - s.sigma**2)
    left = s.raw_sigma**2 / np.e - s.sigma**2 * np.exp(-(s.raw_tau / s.tau)**2)
    return large, s.raw_tau / np.sqrt(np.log(large**2 / left))


def profile(random, sigma, tau):
    """Autocorrelation exp(-(r / tau)^2), from white noise."""
    length = 2 * POINTS
    k = 2 * np.pi * np.fft.rfftfreq(length, SPACING_UM)
    spectrum = np.fft.rfft(random.standard_normal(length)) * np.exp(-(k * tau)**2 / 8)
    return sigma * np.fft.irfft(spectrum, length)[:POINTS] * np.sqrt(
        np.sqrt(np.pi) * tau / SPACING_UM)


def write_scans(path, s, seed):
    """Nine profiles of 4000 heights: both scales Gaussian, the sum with the raw sigma and tau."""
    random = np.random.default_rng(seed)
    scans = [profile(random, s.sigma, s.tau) + profile(random, *large_scale(s))
             for _ in range(SCANS)]
    x = np.arange(POINTS) * SPACING_UM
    np.savetxt(path, np.column_stack([x, *scans]), delimiter=",", fmt="%.7g", comments="",
               header="x_um," + ",".join(f"z{i + 1}_um" for i in range(SCANS)))
