"""A sphere of the material under a uniform white sky: every pixel is a directional reflectance.

With parallel rays the pixel at distance r from the centre sees the sphere at theta = asin(r)."""
import math

import numpy

PIXELS = 48
SAMPLES = 1024
RINGS_DEG = (0, 15, 30, 45, 60, 70, 80)  # a ring between each two
SUB = 8                                  # points of a pixel, per axis, of the expected values


def render(mi, bsdf):
    """[PIXELS][PIXELS][3], linear sRGB."""
    view = mi.ScalarTransform4f().look_at(origin=[0, 0, 3], target=[0, 0, 0], up=[0, 1, 0])
    white = {"type": "d65"} if "spectral" in mi.variant() else {"type": "rgb", "value": 1.0}
    scene = mi.load_dict({
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 3},
        "sensor": {"type": "orthographic", "to_world": view,
                   "film": {"type": "hdrfilm", "width": PIXELS, "height": PIXELS,
                            "rfilter": {"type": "box"}, "component_format": "float32"},
                   "sampler": {"type": "independent", "sample_count": SAMPLES}},
        "sky": {"type": "constant", "radiance": white},
        "ball": {"type": "sphere", "bsdf": bsdf}})
    return numpy.array(mi.render(scene))[:, :, :3]


def incidences_deg():
    """[PIXELS][PIXELS][SUB * SUB] at points of the pixels; NaN beside the sphere."""
    x = (numpy.arange(PIXELS * SUB) + 0.5) / (PIXELS * SUB) * 2 - 1
    r2 = (x * x)[:, None] + x * x
    theta = numpy.degrees(numpy.arcsin(numpy.sqrt(numpy.where(r2 < 1, r2, numpy.nan))))
    blocks = theta.reshape(PIXELS, SUB, PIXELS, SUB).transpose(0, 2, 1, 3)
    return blocks.reshape(PIXELS, PIXELS, SUB * SUB)


def compare(picture, theta_deg, reflectance, views):
    """Relative errors of the rings' means in views[][3] of the colours, and the brightest pixel on
    the sphere beside the most that the model reflects; reflectance[3][theta] is what to expect."""
    picture = picture @ views.T
    theta = incidences_deg()
    inside = numpy.isfinite(theta).all(axis=2)
    expected = numpy.stack([numpy.interp(theta, theta_deg, channel).mean(axis=2)
                            for channel in views @ reflectance], axis=2)
    middle = theta.mean(axis=2)
    rings = [inside & (middle >= a) & (middle < b) for a, b in zip(RINGS_DEG, RINGS_DEG[1:])]
    errors = [picture[ring].mean(axis=0) / expected[ring].mean(axis=0) - 1 for ring in rings]
    return {"rings": numpy.array(errors), "brightest": float(picture[inside].max()),
            "reflects": float((views @ reflectance).max())}
