"""Five spheres in a studio, rendered from .bsdf files; see scripts/gallery.

usage: gallery.py HETAB FOLDER OUTPUT [--quick] SURFACE...     FOLDER has SURFACE-rgb.bsdf
with its SURFACE-rgb.specular.csv.

Writes OUTPUT/spheres.exr (linear) and OUTPUT/spheres.png.
"""
import json
import os
import sys

import matplotlib
import mitsuba as mi
import numpy

from model import Model

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from PIL import Image

WIDTH, HEIGHT = 1600, 600
PASSES, SAMPLES = 4, 64
SPACING = 2.45                   # between the centres of spheres of radius 1
EXPOSURE, SHOULDER = 1.1, 0.4
LABEL_SPACING = 0.194             # of the picture's width


def transform():
    return mi.ScalarTransform4f()


def softbox(origin, target, width, height, radiance):
    placed = transform().look_at(origin=origin, target=target, up=[0, 1, 0.01])
    return light(placed @ transform().scale([width / 2, height / 2, 1]), radiance)


def light(to_world, radiance):
    return {"type": "rectangle", "to_world": to_world,
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}},
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": radiance}}}


def studio():
    """Everything but the spheres. y is up, the camera looks along -z."""
    return {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 7, "hide_emitters": False},
        "camera": {"type": "perspective", "fov": 21.5, "fov_axis": "x",
                   "to_world": transform().look_at(origin=[0, 4.6, 33], target=[0, 0.62, 0],
                                                   up=[0, 1, 0]),
                   "film": {"type": "hdrfilm", "width": WIDTH, "height": HEIGHT,
                            "rfilter": {"type": "gaussian"}, "component_format": "float32"},
                   "sampler": {"type": "multijitter", "sample_count": SAMPLES}},
        "air": {"type": "constant", "radiance": {"type": "rgb", "value": [0.30, 0.34, 0.40]}},
        "rim": softbox([11, 5, -6], [0, 1, 0], 2.0, 9, [4.2, 5.8, 8.6]),
        "top": softbox([0, 8.5, -7], [0, 0, 0], 18, 1.4, [3.6, 3.7, 3.9]),
        "fill": softbox([10, 3, 16], [0, 1, 0], 5, 9, [0.42, 0.44, 0.5]),
        "key": softbox([-7.5, 10.5, 8.5], [0, 0.8, 0], 6.5, 5, [10.5, 9.8, 8.6]),
        "floor": {"type": "rectangle",
                  "to_world": transform().rotate([1, 0, 0], -90) @ transform().scale([90, 90, 1]),
                  "bsdf": {"type": "roughplastic", "alpha": 0.14, "distribution": "ggx",
                           "diffuse_reflectance": {"type": "rgb", "value": [0.16, 0.16, 0.17]}}},
    }


def sphere(k, count, bsdf):
    return {"type": "sphere", "radius": 1.0, "bsdf": bsdf,
            "center": [(k - (count - 1) / 2) * SPACING, 1.0, 0.0]}


def render(scene, passes):
    total = 0
    for seed in range(passes):
        total = total + numpy.array(mi.render(scene, seed=seed), dtype="f8")[:, :, :3]
        print(f"\rgallery: pass {seed + 1} of {passes}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    return total / passes


def tone(linear):
    """Display values in [0, 1]: straight below SHOULDER, then bending towards the lights."""
    x = numpy.maximum(EXPOSURE * linear, 0)
    room = 1 - SHOULDER
    bent = SHOULDER + room * (1 - numpy.exp(-numpy.maximum(x - SHOULDER, 0) / (1.6 * room)))
    x = numpy.where(x < SHOULDER, x, bent)
    return numpy.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def label(picture, abouts, path):
    height, width = picture.shape[:2]
    figure = plt.figure(figsize=(width / 100, height / 100), dpi=100)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.imshow(picture, interpolation="nearest")
    axes.axis("off")
    for k, about in enumerate(abouts):
        x = width * (0.5 + (k - (len(abouts) - 1) / 2) * LABEL_SPACING)
        axes.text(x, 0.86 * height, about["name"], color="0.92", fontsize=18, ha="center",
                  weight="bold")
        axes.text(x, 0.925 * height, rf"$\sigma_0$ {about['sigma0_um']:g} µm   $\tau$ "
                  rf"{about['tau_um']:g} µm", color="0.66", fontsize=15, ha="center")
    figure.savefig(path)
    Image.open(path).convert("RGB").save(path, optimize=True)


def write(linear, abouts, output):
    mi.Bitmap(linear.astype("f4")).write(os.path.join(output, "spheres.exr"))
    label(tone(linear), abouts, os.path.join(output, "spheres.png"))


def main():
    arguments = [a for a in sys.argv[1:] if a != "--quick"]
    if len(arguments) < 4:
        sys.exit(__doc__)
    if "DRJIT_LIBLLVM_PATH" not in os.environ:
        sys.exit("gallery: Debian's libllvm19 could not be downloaded, and rendering needs it")
    quick = len(arguments) < len(sys.argv) - 1
    hetab, folder, output, *surfaces = arguments
    models = [Model(hetab, surface) for surface in surfaces]
    mi.set_variant("llvm_ad_rgb")
    sys.path.insert(0, os.path.join(os.path.dirname(hetab), "share/hetab/mitsuba"))
    import he_torrance  # registers the material of that name
    scene = studio()
    for k, surface in enumerate(surfaces):
        path = os.path.join(folder, f"{surface}-rgb.bsdf")
        scene[surface] = sphere(k, len(surfaces), {"type": "he_torrance", "filename": path})
    linear = render(mi.load_dict(scene), 1 if quick else PASSES)
    write(linear, [json.loads(m.run("surfaces", m.surface, "--json")) for m in models], output)


if __name__ == "__main__":
    main()
