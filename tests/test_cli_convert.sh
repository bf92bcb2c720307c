#!/bin/bash
# Tests `hetab convert` as its users meet it.
# usage: test_cli_convert.sh PROGRAM
. "$(dirname "$0")/cli_support.sh"

small="--theta-i 0:90:19 --theta-r 0:90:19 --phi 0:180:19"

works "a table to convert" tabulate NGGAL -o a.binary --quiet
works "MERL to HDF5" convert a.binary a.h5 $small
check "says the format" has '^a\.h5: HDF5, 3 channels of linear sRGB$'
check "states the error" has 'error added by the conversion: L1 [0-9.e+-]+ %, bias [+-]'
check "rgb is no spectrum" /usr/bin/python3 -c '
import h5py, sys
f = h5py.File("a.h5")
sys.exit(not ("wavelength" not in f and f["brdf"].dims[0].label == "channel" and
              f["channel"].shape == (3,) and f["brdf"].shape == (3, 19, 19, 19) and
              f["brdf"].dims[1][0].name == "/theta_i" and "sigma0_um" not in f.attrs and
              f["specular_reflectance"].shape == (3, 19) and f["brdf"][:].min() >= 0))'
works "MERL to MERL" convert a.binary again.binary
check "whose error it is" has 'L1 [0-9.]+ % in readers that take the nearest cell, bias'
works "MERL to RGL" convert a.binary a.bsdf --json
check "JSON" json "d['from'] == 'merl' and d['to'] == 'rgl' and d['srgb_out'] is True and \
0 <= d['error_l1'] < 0.01 and d['filled'] == 0"
check "the specular reflectance is beside both" test -s a.specular.csv
works "the same, told" convert a.binary a.bsdf --force
check "says who loads it" has "^  loads in Mitsuba 3's rgb variants and powitacq_rgb\$"
works "RGL to MERL" convert a.bsdf b.binary --quiet
check "quiet" test ! -s out
check "its size" test "$(stat -c %s b.binary)" = 34992012
check "specular beside it" cmp a.specular.csv b.specular.csv
works "the same seed" convert a.bsdf c.binary --json --seed 3
mv out first
works "again" convert a.bsdf c.binary --json --seed 3 --force
check "the same report" cmp out first
check "the same file" cmp b.binary c.binary

refuses "no output" 2 "give an input and an output" convert a.binary
refuses "too many" 2 "unexpected argument 'c'" convert a b c
refuses "existing output" 1 "a\.bsdf.*(exists|force)" convert a.binary a.bsdf
touch d.specular.csv
refuses "existing file beside the output" 1 "d\\.specular\\.csv" convert a.bsdf d.binary
check "then nothing is written" test ! -e d.binary
works "a table without a delta" tabulate GGAL120 -o rough.h5 $small --quiet --wavelengths 400:700:10
/usr/bin/python3 -c '
import h5py
h5py.File("rough.h5", "r+")["specular_reflectance"][:] = 0'
refuses "a delta that is another table's" 1 "d\\.specular\\.csv.*move it away" \
  convert rough.h5 d.binary --force
check "then nothing is written either" test ! -e d.binary -a -e d.specular.csv
works "no delta" convert rough.h5 none.binary --quiet
check "no file of it" test -e none.binary -a ! -e none.specular.csv
refuses "a name that is all ending, as everywhere" 1 "choose the ending" convert a.bsdf .binary
works "a spectral table" tabulate BBQAL2 -o spectral.h5 $small --quiet
works "to colour" convert spectral.h5 colour.bsdf --srgb --json --table-error 0.05
check "counts the components of this table, not of those tried" json "0 < d['clamped'] < 500"
refuses "unknown ending" 1 "x\.exr.*\.bsdf" convert a.binary x.exr
refuses "no such input" 1 "none\.h5" convert none.h5 x.binary
refuses "itself" 1 "one file" convert a.binary a.binary --force
refuses "bad grid" 1 "theta_i" convert a.binary x.h5 --theta-i 0:100:3
works "few incidences of linear sRGB" convert a.binary few.h5 -q \
  --theta-i 0,30,60 --theta-r 0:90:181 --phi 0:180:181
works "and their audit" audit few.h5 --json --max-excess 0.01 --max-asymmetry 1 \
  --max-error 1e3 --against NGGAL
check "by its channels, with the delta" json "
(lambda r: [c['channel'] for c in r['channels']] == ['red', 'green', 'blue'] and
 r['against']['specular']['beside_table'] and
 all(abs(c['rho_dh'][t] / c['fresnel'][t] - 1) < 0.01 for c in r['channels'] for t in range(3)))(d['results'][0])"
works "and repair" audit few.h5 -q --max-excess 0.01 --max-asymmetry 1 \
  --repair mended.h5 --scale-energy --no-reference

# A delta folded in as a lobe: its energy, for look-ups and for readers that interpolate linearly.
printf 'name: steel\nsigma0_um: 0.03\ntau_um: 3\nindex: {n: 2.5, k: 3.4}\nwavelengths_nm: 550\n' >steel.yml
cat >folded.py <<'END'
import h5py, hetab, numpy, sys
deg = numpy.append(numpy.arange(0.5, 85, 4.1), 85)
t = numpy.radians(deg)
truth = hetab.reflectance(hetab.Surface("steel.yml"), t)["dh"][0]
wi = numpy.stack([numpy.sin(t), 0 * t, numpy.cos(t)], 1)
found = {name: hetab.open_table(name).albedo(wi)[0][:, 0] for name in ("steel.bsdf", "steel.h5")}
f = h5py.File("steel.h5")
i, r, p = (f[a][:] for a in ("theta_i", "theta_r", "phi"))
fine = numpy.radians((numpy.arange(7200) + 0.5) / 80)
weights = numpy.sin(fine) * numpy.cos(fine) * numpy.radians(1 / 80)
rows = 2 * numpy.trapz(f["brdf"][0], numpy.radians(p))
found["linear"] = numpy.interp(deg, i, [weights @ numpy.interp(fine, numpy.radians(r), row) for row in rows])
print({name: abs(albedo / truth - 1).max() for name, albedo in found.items()})
sys.exit(not (f.attrs["specular_cone_deg"] == 2 and not f["specular_reflectance"][:].any() and
              all(abs(albedo / truth - 1).max() < 0.01 for albedo in found.values())))
END
works "steel, its delta folded in" tabulate steel.yml --bands spectral --specular-cone 2 -o steel.bsdf -q
works "to HDF5" convert steel.bsdf steel.h5 -q
check "keeps its energy within 1 %" with_library env PYTHONPATH="$scripts/../src/python" \
  HETAB_LIBRARY="$(dirname "$program")/libhetab.so" /usr/bin/python3 folded.py
works "and back" convert steel.h5 return.bsdf -q --table-error 0.05
check "the file says so" sh -c '/usr/bin/python3 "$PYTHONPATH/tensor_file.py" return.bsdf | grep -q specular_cone_deg'
refuses "nodes that lose it" 1 "lobe of 2 degrees, which phi nodes 1 degrees apart at 180 would lose: take at most 0\.042" \
  convert steel.bsdf x.h5 --phi 0:180:181
refuses "thetas that lose it" 1 "theta_r nodes 3 degrees apart would lose: take at most 2" \
  convert steel.bsdf x.h5 --theta-r 0:90:31
works "a lobe between the nodes" convert a.binary coarse.h5 --theta-i 0:90:31 --theta-r 0:90:31 --phi 0:180:31
grid=$(grep -oE -- '--theta-i 0:90:[0-9]+ --theta-r 0:90:[0-9]+ --phi 0:180:[0-9]+' out)
# shellcheck disable=SC2086 # options
works "the grid proposed" convert a.binary finer.h5 --json $grid
check "holds it" json "d['error_l1'] < 0.053 and d['proposed'] == [0, 0, 0]"
check "which is finer" test "${grid##*:}" -gt 31

# Where its delta is subnormal, the ratio to the next incidence's overflows.
faint="--theta-i 0:80:3 --theta-r 0:80:3 --phi 0:180:5"
# shellcheck disable=SC2086 # options
works "a faint delta" tabulate BBQAL2 --method literal --samples 0 -q -o faint.h5 $faint
# shellcheck disable=SC2086
works "stays finite" convert faint.h5 kept.h5 -q --pairs 20 $faint

head -c 100000 a.binary >short.binary
head -c 3000 a.bsdf >short.bsdf
head -c 20000 a.h5 >short.h5
: >empty.binary
for broken in short.binary short.bsdf short.h5 empty.binary; do
  refuses "damaged $broken" 1 "$broken" convert $broken x.h5 $small
done
check "no output of what was refused" test ! -e x.h5 -a ! -e x.binary -a ! -e x.exr
refuses "a directory" 1 "." convert . x.h5

summary
