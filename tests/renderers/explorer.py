"""Checks the page of `hetab view SURFACE -o explorer.html` in headless Chromium; see
scripts/test_renderers.

usage: explorer.py HETAB FOLDER [SCREENSHOTS]

BRDF, delta and reflectances that the page computes are read back and compared with the printed
equations; prints how long the first picture took on the CPU's rasteriser. With SCREENSHOTS, a
folder, draws the page at 1280 and 390 pixels, light and dark."""
import json
import math
import os
import re
import subprocess
import sys

import numpy

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../src/python"))
import hetab
from browser import chromium, present

HETAB, FOLDER = sys.argv[1:3]
SURFACES = ((0.72, 5.6), (0.54, 6.5), (0.42, 1.9), (0.17, 5.0), (0.05, 60.0), (0.02, 3.0),
            (5.0, 20.0), (1.0, 1.0), (0.02, 0.2))
N, K, UM, PAIRS = 1.44, 0.6, 0.55, 450
BOUNDS = {"f": 5e-5, "rho_s": 5e-5, "rho_dd": 0.01, "bytes": 150_000}


def cases():
    """Points, and what goes to the page for them: most of the pairs about the lobe."""
    random, most = numpy.random.default_rng(3), math.radians(89.5)
    points, rows = [], []
    for sigma0, tau in SURFACES:
        width = min(1.0, 2 * sigma0 / tau + UM / tau)
        i = random.uniform(0, most, PAIRS)
        near = random.random(PAIRS) < 0.7
        r = numpy.clip(numpy.where(near, i + width * random.standard_normal(PAIRS),
                                   random.uniform(0, most, PAIRS)), 0, most)
        phi = numpy.where(near, math.pi + width * random.standard_normal(PAIRS),
                          random.uniform(0, 2 * math.pi, PAIRS))
        w = numpy.stack([numpy.sin(i), 0 * i, numpy.cos(i), numpy.sin(r) * numpy.cos(phi),
                         numpy.sin(r) * numpy.sin(phi), numpy.cos(r)], axis=1)
        w = w.astype("f4").astype("f8")
        these = numpy.zeros(PAIRS, hetab.POINT)
        for name, value in (("lambda_um", UM), ("sigma0_um", sigma0), ("tau_um", tau), ("n", N),
                            ("k", K), ("theta_i", numpy.arctan2(w[:, 0], w[:, 2])),
                            ("theta_r", numpy.arctan2(numpy.hypot(w[:, 3], w[:, 4]), w[:, 5])),
                            ("phi", numpy.arctan2(w[:, 4], w[:, 3]))):
            these[name] = value
        points.append(these)
        rows += [[sigma0, tau, UM, N, K, 0.0, *direction] for direction in w.tolist()]
    return numpy.concatenate(points), rows


def read_back(page, rows, samples):
    """What the page's own probe() says; (numbers, milliseconds of the first picture)."""
    with open(page, encoding="utf-8") as file:
        text = file.read()
    program = (f"<script>if (gl) {{ const said = document.createElement('pre'); said.id = 'said'; "
               f"pass(); said.textContent = JSON.stringify(probe({json.dumps(rows)}, {samples})); "
               "cancelAnimationFrame(pending); document.body.append(said); }</script>")
    probed = os.path.join(FOLDER, "probed.html")
    with open(probed, "w", encoding="utf-8") as file:
        file.write(text.replace("</body>", program + "</body>"))
    answer = chromium("--dump-dom", "file://" + os.path.abspath(probed))
    failure = re.search(r'data-failure="([^"]*)"', answer)
    if failure:
        sys.exit(f"explorer: {failure[1]}")
    first = re.search(r'data-first="(\d+)"', answer)
    return (numpy.array(json.loads(re.search(r'<pre id="said">([^<]*)</pre>', answer)[1])),
            int(first[1]) if first else None)


def shown(values):
    """Where h is above 1e-6 of its peak."""
    model = {}
    exec(hetab.shader("python"), model)
    h = [model["ln_h"](model["Numpy"], values["g"], x) for x in (values["x"], 0 * values["x"])]
    return (h[0] - h[1] > math.log(1e-6)) & (values["dd"] > 1e-12)


def screenshots(page, folder):
    os.makedirs(folder, exist_ok=True)
    for width, height in ((1280, 1180), (390, 2350)):
        for theme, flags in (("light", []), ("dark", ["--blink-settings=preferredColorScheme=0"])):
            path = os.path.join(os.path.abspath(folder), f"explorer-{width}-{theme}.png")
            chromium(f"--window-size={width},{height}", "--virtual-time-budget=6000", *flags,
                     f"--screenshot={path}", "file://" + os.path.abspath(page))


def main():
    if not present():
        print("skip: the explorer's test needs Debian's chromium")
        return
    page, missed = os.path.join(FOLDER, "explorer.html"), []
    subprocess.run([HETAB, "view", "BBQAL2", "-o", page, "--force", "--quiet"], check=True)
    points, rows = cases()
    found, _ = read_back(page, rows, 0)
    exact = hetab.evaluate(points, literal=True)
    visible, delta = shown(exact), exact["specular"] > 1e-6
    measured = {
        "f": numpy.abs(found[:, 0] / numpy.maximum(exact["dd"], 1e-300) - 1)[visible].max(),
        "rho_s": numpy.abs(found[:, 1] / numpy.maximum(exact["specular"], 1e-300) - 1)[delta].max(),
        "bytes": os.path.getsize(page)}
    if not numpy.isfinite(found).all():
        missed.append("NaN or infinite")
    angles, some = (0.0, 0.5, 1.0, 1.3), SURFACES[:4]
    few = [[s, t, UM, N, K, 0.0, math.sin(a), 0.0, math.cos(a), 0.0, 0.0, 1.0]
           for s, t in some for a in angles]
    found, first = read_back(page, few, 4096)
    truth = [hetab.reflectance(hetab.Surface(sigma0_um=s, tau_um=t, index={"n": N, "k": K},
                                             wavelengths_nm=[1e3 * UM]), angles)["dd"]["value"][0]
             for s, t in some]
    measured["rho_dd"] = numpy.abs(found[:, 3] / numpy.concatenate(truth) - 1).max()
    for name, value in measured.items():
        print(f"explorer, {name}: {value:.2g}, bound {BOUNDS[name]:g}")
        if not value <= BOUNDS[name]:
            missed.append(name)
    print(f"explorer, {visible.sum()} values on {len(SURFACES)} surfaces; first picture of 800 x 600 "
          f"{first} ms after the page was asked for")
    if len(sys.argv) > 3:
        screenshots(page, sys.argv[3])
    for what in missed:
        print(f"MISSED explorer: {what}")
    sys.exit(bool(missed))


main()
