#!/bin/bash
# OpenEXR tables as their users meet them: written by `hetab tabulate`, read by OpenEXR's tools and
# by tinyexr, and compared with the HDF5 table of the same surface.
# usage: test_cli_exr.sh PROGRAM
colour=$(realpath "$(dirname "$0")/../src/model/colour.c")
. "$(dirname "$0")/cli_support.sh"
readback=$(dirname "$program")/tests/exr_readback
grid="--theta-i 0:90:7 --theta-r 0:90:37 --phi 0:180:19"
cat >needle.yml <<YAML
name: needle
sigma0_um: 0.05
tau_um: 200
index: Al
YAML

# ---- writing -----------------------------------------------------------------------------------

works "one run, two tables" tabulate BBQAL2 $grid -o a.h5 -o rgb.exr
check "summary names the part" has 'rgb.exr: specular reflectance.*part specular_reflectance'
works "the same again" tabulate BBQAL2 $grid -o again.exr -o again.h5
check "the same bytes" sh -c 'cmp rgb.exr again.exr && cmp a.h5 again.h5'
works "spectral" tabulate BBQAL2 $grid -o spectral.exr --bands spectral --quiet
check "quiet" test ! -s out
works "double arithmetic" tabulate BBQAL2 $grid -o double.exr --bands spectral --precision double
works "by wavelength, in half" tabulate BBQAL2 $grid -o half.exr --exr-parts wavelength \
  --exr-type half --json
check "json" json "d['outputs'][0]['format'] == 'exr' and d['outputs'][0]['saturated'] == 0 and \
d['outputs'][0]['error']['max_sampled'] < 1e-5"
works "needle, in half" tabulate needle.yml $grid -o needle.exr --exr-type half --samples 0
check "saturation is told" has 'needle.exr: [0-9]+ pixels above 65504 .* take --exr-type float'
works "some wavelengths, spectral" tabulate BBQAL2 $grid -o few.exr --bands spectral \
  --wavelengths 450.5,633

cat >steel.yml <<YAML
sigma0_um: 0.03
tau_um: 3
index: {n: 2.9, k: 3.1}
wavelengths_nm: [550]
YAML
works "folded" tabulate steel.yml -o folded.exr -o folded.h5 --bands spectral --specular-cone 2 --json
check "the HDF5 file keeps the delta apart" json "[o['specular']['in_table'] for o in d['outputs']] == [True, False]"
works "atlas" tabulate BBQAL2 $grid -o atlas.exr --exr-layout atlas
check "atlas: where the delta is" has 'atlas.exr: .* is in the attributes specular_reflectance_R, _G and _B$'
check "atlas: readers" has 'atlas.exr: loads in OpenImageIO, OpenCV and shaders'
works "atlas of a needle, in float" tabulate needle.yml $grid -o sharp.exr --exr-layout atlas --exr-type float --samples 0
works "atlas of one incidence, uneven" tabulate BBQAL2 -o one.exr --exr-layout atlas --theta-i 30 \
  --theta-r 0,1,5,30,89 --phi 180 --samples 0
works "atlas, folded" tabulate steel.yml -o steel.exr --exr-layout atlas --specular-cone 2 --wavelengths 400:700:10
refuses "too narrow a cone for the grid" 1 "take 1 or more" tabulate steel.yml -o b.exr --specular-cone 0.9

# ---- bad input ---------------------------------------------------------------------------------

refuses "existing output" 1 "rgb.exr exists: use --force" tabulate BBQAL2 $grid -o rgb.exr
works "force" tabulate BBQAL2 $grid -o rgb.exr --force
refuses "missing folder" 1 "none/a.exr" tabulate BBQAL2 $grid -o none/a.exr
refuses "parts by wavelength in colour" 2 "take --bands spectral" tabulate BBQAL2 -o b.exr \
  --exr-parts wavelength --bands rgb
refuses "spectral atlas" 2 "atlas holds R, G and B" tabulate BBQAL2 -o b.exr --exr-layout atlas --bands spectral
refuses "needle in half" 1 "above 65504.*--exr-type float" tabulate needle.yml $grid -o b.exr --exr-layout atlas
refuses "atlas of a huge grid" 1 "16560 x 16470 pixels .*textures" tabulate BBQAL2 -o b.exr --exr-layout atlas \
  --theta-i 0:90:900 --theta-r 0:90:549 --phi 0:180:552
refuses "existing atlas" 1 "atlas.exr exists: use --force" tabulate BBQAL2 $grid -o atlas.exr --exr-layout atlas
refuses "a layout without its file" 2 "--exr-layout is for .exr" tabulate BBQAL2 -o b.h5 --exr-layout atlas
for command in "convert atlas.exr b.h5" "view atlas.exr -o b.png" "audit atlas.exr" "eval atlas.exr"; do
  refuses "$command" 1 "atlas.exr.* no (table|surface)" $command
done
refuses "colour of one wavelength" 1 "400 to 700 nm" tabulate BBQAL2 -o b.exr --wavelengths 550
refuses "absurd size" 1 "GiB of memory" tabulate BBQAL2 -o b.exr --theta-i 0:90:300 \
  --theta-r 0:90:300 --phi 0:180:721 --exr-parts wavelength
refuses "too many parts" 1 "5000 parts" tabulate BBQAL2 -o b.exr --theta-i 0:90:5000
refuses "unknown bands" 2 "--bands: 'mono'" tabulate BBQAL2 -o b.exr --bands mono
check "nothing was written" test ! -e b.exr

# ---- OpenEXR's own tools -----------------------------------------------------------------------

if command -v exrheader >/dev/null && command -v exrinfo >/dev/null; then
  for file in rgb spectral double half needle few atlas sharp one steel; do
    check "$file: exrheader" exrheader $file.exr
    check "$file: exrinfo" sh -c "exrinfo -s $file.exr | grep -q '^ part 1: '" # its status is any number
  done
  exrheader rgb.exr >out
  check "surface" has '^surface .*"BBQAL2"'
  check "roughness" has '^sigma0_um \(type double\): 0\.54$'
  check "error" has '^error_max_sampled \(type double\): [1-9].*e-06$'
  check "zip" has '^compression .*: zip'
  check "float" has 'R, 32-bit floating-point'
  check "parts" test "$(grep -c '^name ' out)" = 8
  exrheader half.exr >out
  check "half" has 'T.550,000000nm, 16-bit floating-point'
  check "spectral layout" has '^spectralLayoutVersion .*"1.0"'
else
  skip "exrheader, exrinfo: OpenEXR's tools are not installed"
fi

# ---- another reader ----------------------------------------------------------------------------

cat >compare.py <<'PY'
import h5py, numpy as np, re, sys
from exr_parts import load
def channel(nm):
    return "T." + ("%.6f" % nm).replace(".", ",") + "nm"
h5 = h5py.File("a.h5")
brdf, rho, nm, deg = (h5[k][:] for k in ("brdf", "specular_reflectance", "wavelength", "theta_i"))
def part(of, value):
    return (of % value).replace(".", "_")
names = [part("theta_i_%05.2fdeg", d) for d in deg]
def spectral():
    parts = load("spectral")
    return list(parts) == names + ["specular_reflectance"] and all(
        np.array_equal(parts[n][channel(l)], brdf[b, i])
        for i, n in enumerate(names) for b, l in enumerate(nm)) and all(
        np.array_equal(parts["specular_reflectance"][channel(l)][0], rho[b].astype("f4"))
        for b, l in enumerate(nm))
def double():
    parts = load("double")
    worst = max(np.max(abs(parts[n][channel(l)] - brdf[b, i]) / np.maximum(brdf[b, i], 1e-9))
                for i, n in enumerate(names) for b, l in enumerate(nm))
    return 0 < worst < 1e-5
def half():
    parts = load("half")
    return all(np.array_equal(parts[part("wavelength_%.2fnm", l)][channel(l)],
                              brdf[b].reshape(-1, brdf.shape[3]).astype("f2").astype("f4"))
               for b, l in enumerate(nm))
def weights():  # the published observer and illuminant, the published matrix, summed here
    text = open(sys.argv[2]).read()
    table = np.array([[float(v) for v in row.split(",")] for row in
                      re.findall(r"\{([-+0-9.e, ]+)\},", text.split("observer_d65[BANDS][4]")[1])[:31]])
    d65 = np.array([0.950470, 1, 1.088830])
    xyz = table[:, :3] * table[:, 3:]
    xyz *= d65 / xyz.sum(axis=0)
    to_rgb = np.array([[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560],
                       [0.0556434, -0.2040259, 1.0572252]])
    return xyz @ (to_rgb / (to_rgb @ d65)[:, None]).T  # white is (1, 1, 1)
def close(plane, spectrum, c, rounding=0, step=1e-38):  # a float's rounding and least number
    wanted = np.tensordot(weights()[:, c], spectrum.astype("f8"), 1)
    scale = np.tensordot(abs(weights()[:, c]), spectrum.astype("f8"), 1)
    return np.all(abs(plane - wanted) <= 1e-7 * scale + rounding * abs(wanted) + step)
def rgb():
    parts = load("rgb")
    return all(close(parts[n]["RGB"[c]], brdf[:, i], c) for c in range(3)
               for i, n in enumerate(names)) and all(
        close(parts["specular_reflectance"]["RGB"[c]][0], rho, c) for c in range(3))
def atlas():
    (planes,), (rows, columns) = load("atlas").values(), brdf.shape[2:]
    across, text = 4, open("atlas.txt").read()
    tiles = {c: planes[c].reshape(2, rows, across, columns).swapaxes(1, 2).reshape(-1, rows, columns)
             for c in "RGB"}  # 7 and one left over
    return all(close(tiles["RGB"[c]][i], brdf[:, i], c, 2**-11, 2**-25) for c in range(3)
               for i in range(len(deg))) and not any(tiles[c][len(deg):].any() for c in "RGB") and all(
        f" {a}\n" in text for a in ("tiles_across double 4", "specular_reflectance_R floatvector 7",
                                   "specular_delta string not in the BRDF", "theta_i_deg floatvector 7"))
def sharp():
    return max(p.max() for p in load("sharp").popitem()[1].values()) > 65504
def one():
    return load("one").popitem()[1]["G"].shape == (5, 1)
def steel():
    text = open("steel.txt").read()
    return "specular_cone_deg double 2\n" in text and "specular_delta string folded into the BRDF\n" in text
def needle():
    parts = load("needle")
    return max(p[c].max() for p in parts.values() for c in p) == 65504
def folded():  # what the lobe adds to the table without it reflects rho_s; polar integration here
    h5, parts = h5py.File("folded.h5"), load("folded")
    theta, phi = (np.radians(h5[k][:]) for k in ("theta_r", "phi"))
    fine, worst = np.linspace(0, np.pi / 2, 18001), 0
    for i, deg in enumerate(h5["theta_i"][:]):
        if deg > 85:
            continue
        lobe = parts[part("theta_i_%05.2fdeg", deg)][channel(550)] - h5["brdf"][0, i].astype("f8")
        ring = 2 * np.trapz(lobe, phi, axis=1)
        energy = np.trapz(np.interp(fine, theta, ring) * np.sin(fine) * np.cos(fine), fine)
        worst = max(worst, abs(energy / h5["specular_reflectance"][0, i] - 1))
    print("  energy of the folded lobe, worst:", worst)
    marked = "specular_cone_deg double 2\n" in open("folded.txt").read()
    return worst < 0.003 and marked and not parts["specular_reflectance"][channel(550)].any()
def few():
    parts = load("few")
    return list(parts[names[0]]) == ["T.450,500000nm", "T.633,000000nm"]
sys.exit(not globals()[sys.argv[1]]())
PY
if [ -x "$readback" ]; then
  for file in rgb spectral double half needle few folded atlas sharp one steel; do
    check "$file: tinyexr" sh -c "'$readback' $file.exr $file.bin >$file.txt"
    check "$file: values" /usr/bin/python3 compare.py $file "$colour"
  done
else
  skip "tinyexr: $readback is not built"
fi

summary
