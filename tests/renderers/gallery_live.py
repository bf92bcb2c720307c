"""Renders the material he_torrance in Mitsuba 3, from near mirror to rough.

usage: gallery_live.py HETAB OUTPUT [--quick]

OUTPUT/mirror_to_rough.png: aluminium of one correlation length and five heights, each with its
delta; the model itself, no tables."""
import os
import sys

import mitsuba as mi
import numpy

TAU_UM, SIGMA0_UM = 5.0, (0.02, 0.06, 0.12, 0.3, 0.8)


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    hetab, output = sys.argv[1:3]
    sys.path.insert(0, os.path.join(os.path.dirname(hetab), "share/hetab/mitsuba"))
    mi.set_variant("llvm_ad_rgb")
    import gallery
    import he_torrance  # registers the material of that name
    scene = gallery.studio()
    abouts = [{"name": f"slope {s / TAU_UM:.3g}", "sigma0_um": s, "tau_um": TAU_UM}
              for s in SIGMA0_UM]
    for k, about in enumerate(abouts):
        scene[f"ball{k}"] = gallery.sphere(k, len(abouts), {
            "type": "he_torrance", "sigma0": about["sigma0_um"], "tau": TAU_UM, "material": "Al"})
    linear = gallery.render(mi.load_dict(scene), 1 if "--quick" in sys.argv else gallery.PASSES)
    small = numpy.array(mi.Bitmap(linear.astype("f4")).resample(
        [gallery.PNG_WIDTH, gallery.PNG_WIDTH * gallery.HEIGHT // gallery.WIDTH]))
    gallery.label(gallery.tone(small), abouts, os.path.join(output, "mirror_to_rough.png"))


main()
