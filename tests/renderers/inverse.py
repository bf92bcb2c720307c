"""sigma0 and tau of a surface, found from its picture with the material he_torrance in Mitsuba 3.

usage: inverse.py HETAB OUTPUT [--quick]

OUTPUT/inverse.png: the picture, what the search started from, what it found, and its way there.
Exits with 1 if what it found is not what the picture was made with, within 2 %."""
import itertools
import os
import sys

import drjit as dr
import mitsuba as mi
import numpy

TRUTH, START = (0.06, 2.0), (0.1, 1.0)  # sigma0, tau in um: part of the light is in the delta
KEYS = ("ball.bsdf.sigma0.value", "ball.bsdf.tau.value")
SIZE, SHOWN, SAMPLES, STEPS, WITHIN = 64, 192, 64, 25, 0.02


def studio(sigma0, tau, size=SIZE):
    import gallery
    look = mi.ScalarTransform4f().look_at
    return mi.load_dict({
        "type": "scene", "integrator": {"type": "path", "max_depth": 2, "hide_emitters": True},
        "camera": {"type": "perspective", "fov": 29,
                   "to_world": look([0, 0, 4.6], [0, 0, 0], [0, 1, 0]),
                   "film": {"type": "hdrfilm", "width": size, "height": size}},
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": 0.05}},
        "key": gallery.softbox([-4, 5, 4], [0, 0, 0], 2.4, 2.4, [9.0, 8.6, 8.0]),
        "rim": gallery.softbox([6, 1, 1], [0, 0, 0], 1.0, 6.0, [3.0, 3.6, 4.4]),
        "ball": {"type": "sphere", "bsdf": {"type": "he_torrance", "sigma0": sigma0, "tau": tau,
                                            "material": "Cu"}}})


def search(scene, target, steps):
    """Gauss and Newton's steps in ln sigma0 and ln tau, from derivatives of the picture by each:
    `path` has the delta's right, `prb` does not. Errors are relative, of the picture made coarse;
    they and each derivative have noises of their own, or the least square would be where the noise
    is."""
    parameters, at, way, seeds = mi.traverse(scene), numpy.log(START), [START], itertools.count()

    def coarse(picture):
        blocks = mi.TensorXf(picture)[:, :, :3]
        return sum(blocks[i::2, j::2] for i in range(2) for j in range(2)) / 4.0

    def seen(by=None):
        """The picture, or its derivative by the logarithm of a parameter."""
        for key, value in zip(KEYS, numpy.exp(at)):
            parameters[key] = dr.opaque(mi.Float, float(value))
        if by:
            dr.enable_grad(parameters[by])
        parameters.update()
        picture = coarse(mi.render(scene, parameters, spp=SAMPLES, seed=next(seeds)))
        if not by:
            return numpy.array(picture)
        dr.forward(parameters[by])
        return numpy.array(dr.grad(picture)) * float(dr.detach(parameters[by])[0])

    goal = numpy.array(coarse(target))
    for _ in range(steps):
        slopes = numpy.stack([(seen(key) / (goal + 0.02)).ravel() for key in KEYS])
        error = ((seen() - goal) / (goal + 0.02)).ravel()
        step = numpy.linalg.solve(slopes @ slopes.T, slopes @ error)
        at = at - step * min(1.0, 0.25 / abs(step).max())
        way.append(tuple(numpy.exp(at)))
    return numpy.array(way)


def draw(pictures, way, path):
    import gallery
    plt, dpi = gallery.plt, 100
    figure, axes = plt.subplots(1, 4, figsize=(10.6, 2.9), dpi=dpi,
                                gridspec_kw={"width_ratios": [1, 1, 1, 1.25]})
    for axis, (words, (sigma0, tau), picture) in zip(axes, pictures):
        axis.imshow(gallery.tone(picture))
        axis.set_title(f"{words}\n$\\sigma_0$ {sigma0:.3g} µm   $\\tau$ {tau:.3g} µm", fontsize=10)
        axis.axis("off")
    for values, truth, name in zip(way.T, TRUTH, ("$\\sigma_0$", "$\\tau$")):
        axes[3].plot(values / truth, label=name)
    axes[3].axhline(1.0, color="0.6", linewidth=0.8)
    axes[3].set(xlabel="step", title="found / true", yscale="log", yticks=[0.5, 1, 1.5, 2],
                yticklabels=["0.5", "1", "1.5", "2"])
    axes[3].minorticks_off()
    axes[3].legend(frameon=False)
    figure.subplots_adjust(left=0.01, right=0.99, top=0.8, bottom=0.17, wspace=0.12)
    figure.savefig(path)
    gallery.Image.open(path).convert("RGB").save(path, optimize=True)


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    hetab, output = sys.argv[1:3]
    sys.path.insert(0, os.path.join(os.path.dirname(hetab), "share/hetab/mitsuba"))
    mi.set_variant("llvm_ad_rgb")
    import he_torrance  # registers the material of that name
    quick = "--quick" in sys.argv
    shot = lambda roughness: numpy.array(mi.render(studio(*roughness, SHOWN), spp=128))[:, :, :3]
    target = mi.render(studio(*TRUTH), spp=1024, seed=1000)
    way = search(studio(*START), target, 3 if quick else STEPS)
    found = tuple(way[-10:].mean(axis=0))
    print("sigma0 {:.4f} um, tau {:.3f} um found; {} and {} are right".format(*found, *TRUTH))
    pictures = [(words, at, shot(at)) for words, at in (
        ("the picture", TRUTH), ("start", START), ("found", found))]
    draw(pictures, way, os.path.join(output, "inverse.png"))
    wrong = max(abs(a / b - 1.0) for a, b in zip(found, TRUTH))
    if wrong > WITHIN and not quick:
        sys.exit(f"MISSED inverse: {100 * wrong:.1f} % off")


main()
