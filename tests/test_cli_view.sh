#!/bin/bash
# `hetab view` as its users meet it: pictures of surfaces and of every kind of table, and bad input.
# usage: test_cli_view.sh PROGRAM
. "$(dirname "$0")/cli_support.sh"
readback=$(dirname "$program")/tests/exr_readback
grid="--theta-i 0:90:31 --theta-r 0:90:46 --phi 0:180:37"

# Width and height of a PNG, by its header.
png_size() {
  /usr/bin/python3 -c "
import struct, sys
d = open('$1', 'rb').read()
assert d[:8] == b'\x89PNG\r\n\x1a\n' and d[-8:-4] == b'IEND'
print(*struct.unpack('>II', d[16:24]))"
}

# ---- pictures ----------------------------------------------------------------------------------

works "surface" view BBQAL2 -o a.png --size 640 --wavelength 550
check "prints the file" has '^a.png$'
check "size" test "$(png_size a.png | cut -d' ' -f1)" = 640
works "the same again" view BBQAL2 -o b.png --size 640 --wavelength 550 --quiet
check "quiet" test ! -s out
check "the same bytes" cmp a.png b.png
works "darker" view BBQAL2 -o b.png --size 640 --wavelength 550 --exposure -2 --force --json
check "json" json "d['input'] == 'BBQAL2' and d['file'] == 'b.png'"
check "other bytes" sh -c '! cmp -s a.png b.png'
for what in lobes maps sphere; do
  works "$what" view BBQAL2 -o $what.png --what $what --theta-i 20,50 --wavelength 550 --size 640
  check "$what is a PNG" png_size $what.png
done
printf 'name: "\\u4e2d <&> %%s \\e[31m name that goes on and on and on and on, beyond the page"\n' >odd.yml
printf 'sigma0_um: 0.3\ntau_um: 3\nindex: Au\n' >>odd.yml
works "odd name" view odd.yml -o odd.png --what lobes --wavelength 550 --size 640

works "tables" tabulate BBQAL2 $grid -o t.h5 -o t.binary -o t.bsdf --table-error 0.1 --quiet
for table in t.h5 t.binary t.bsdf; do
  works "$table" view $table -o $table.exr --theta-i 0,40 --size 640
done
works "nearest" view t.binary -o nearest.exr --theta-i 0,40 --size 640 --nearest
works "surface's data" view BBQAL2 -o s.exr --theta-i 0,40 --size 640
works "one wavelength of a table" view t.h5 -o w.exr --wavelength 555 --what lobes

# ---- the tables' pictures are the surface's ----------------------------------------------------

cat >compare.py <<'PY'
import numpy as np, sys
from exr_parts import load
one, other, most = load(sys.argv[1]), load(sys.argv[2]), float(sys.argv[3])
assert list(one) == list(other) and len(one) == 5
for name in one:  # relative L1
    a, b = one[name]["G"], other[name]["G"]
    error = np.sum(abs(a - b)) / np.sum(a)
    if not error < most:
        sys.exit("%s: %g" % (name, error))
PY
if [ -x "$readback" ]; then
  for file in s t.h5 t.binary t.bsdf nearest; do
    check "$file: tinyexr" sh -c "'$readback' $file.exr $file.bin >$file.txt"
  done
  # Relative L1 of the worst part; measured 0.0018, 0.0004, 0.051 and 0.025.
  check "HDF5 looks like the surface" /usr/bin/python3 compare.py s t.h5 0.005
  check "MERL looks like the surface" /usr/bin/python3 compare.py s t.binary 0.002
  check "RGL looks like the surface" /usr/bin/python3 compare.py s t.bsdf 0.1
  check "nearest looks like the surface" /usr/bin/python3 compare.py s nearest 0.05
else
  skip "tinyexr: $readback is not built"
fi

# ---- bad input ---------------------------------------------------------------------------------

refuses "no input" 2 "no SURFACE or FILE" view -o x.png
refuses "no output" 2 "no output" view BBQAL2
refuses "two inputs" 2 "unexpected argument 'b'" view a b -o x.png
refuses "unknown ending" 2 "x.jpg: .*\.png, \.exr or \.html" view BBQAL2 -o x.jpg
refuses "only an ending" 2 "ends in" view BBQAL2 -o .png
refuses "existing output" 1 "a.png exists: use --force" view BBQAL2 -o a.png
refuses "missing folder" 1 "none/x.png" view BBQAL2 -o none/x.png
mkdir folder.png
refuses "a folder" 1 "directory" view BBQAL2 -o folder.png
refuses "unknown surface" 1 "NOSUCH" view NOSUCH -o x.png
refuses "missing table" 1 "none.h5" view none.h5 -o x.png
refuses "grazing incidence" 1 "below 90" view BBQAL2 -o x.png --theta-i 90
refuses "five incidences" 1 "1 to 4" view BBQAL2 -o x.png --theta-i 0:80:5
refuses "no incidence" 1 "theta_i" view BBQAL2 -o x.png --theta-i tilted
refuses "two wavelengths" 2 "one wavelength" view BBQAL2 -o x.png --wavelength 500,600
refuses "a wavelength of RGB" 1 "linear sRGB" view t.binary -o x.png --wavelength 550
refuses "a wavelength beyond the table" 1 "400 to 700 nm" view t.h5 -o x.png --wavelength 900
refuses "tiny page" 2 "outside 640" view BBQAL2 -o x.png --size 10
head -c 1000 t.h5 >cut.h5
refuses "truncated HDF5" 1 "cut.h5" view cut.h5 -o x.png
head -c 1000 t.binary >cut.binary
refuses "truncated MERL" 1 "cut.binary" view cut.binary -o x.png
head -c 1000 t.bsdf >cut.bsdf
refuses "truncated RGL" 1 "cut.bsdf" view cut.bsdf -o x.png
/usr/bin/python3 - <<'PY'
import h5py
data = bytearray(open("t.binary", "rb").read())
data[12 + 8 * 5000:12 + 8 * 5001] = b"\xff" * 8  # a NaN
open("nan.binary", "wb").write(data)
open("nan.h5", "wb").write(open("t.h5", "rb").read())
with h5py.File("nan.h5", "r+") as f:
    f["brdf"][3, :, :, :] = float("nan")
PY
refuses "NaN in a MERL table" 1 "nan.binary" view nan.binary -o x.png
refuses "NaN in an HDF5 table" 1 "nan.h5" view nan.h5 -o x.png
echo "not a table" >text.binary
refuses "text for a table" 1 "text.binary" view text.binary -o x.png
cp t.h5 same.png
refuses "input for output" 1 "an output too" view ./same.png -o same.png --force
"$program" view BBQAL2 -o /dev/full 2>err >out
check "a device" test $? = 2
check "nothing was written" test ! -e x.png

summary
