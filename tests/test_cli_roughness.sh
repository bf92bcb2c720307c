#!/bin/bash
# Tests of `hetab roughness`: files of every format written by other programs, the numbers against
# numpy, its outputs, and bad input.
# usage: test_cli_roughness.sh PROGRAM
heights=$(realpath -m "$(dirname "$0")/../../shared/data/heights/npl-edm.csv")
. "$(dirname "$0")/cli_support.sh"

# ---- X3P files as ISO 5436-2 describes them, by Python's zipfile and hashlib --------------------

cat >x3p.py <<'END'
import hashlib, struct, zipfile
import numpy as np

NS = 'xmlns:p="http://www.opengps.eu/2008/ISO5436_2"'

def axis(name, kind, data="D", increment=None, offset=None):
    text = f"<C{name}><AxisType>{kind}</AxisType><DataType>{data}</DataType>"
    text += "" if increment is None else f"<Increment>{increment!r}</Increment>"
    text += "" if offset is None else f"<Offset>{offset!r}</Offset>"
    return text + f"</C{name}>"

def write(path, axes, sizes, data=None, valid=None, datum=None, feature="SUR", md5=None, doctype="",
          level=6, checksum=True, after="", folder=""):
    files = {}
    record = "<MatrixDimension>" + "".join(f"<Size{a}>{n}</Size{a}>" for a, n in zip("XYZ", sizes))
    record += "</MatrixDimension>"
    if datum is None:
        files["bindata/data.bin"] = data
        record += "<DataLink><PointDataLink>bindata/data.bin</PointDataLink><MD5ChecksumPointData>"
        record += (md5 or hashlib.md5(data).hexdigest().upper()) + "</MD5ChecksumPointData>"
        if valid is not None:
            files["bindata/valid.bin"] = valid
            record += "<ValidPointsLink>bindata/valid.bin</ValidPointsLink><MD5ChecksumValidPoints>"
            record += hashlib.md5(valid).hexdigest() + "</MD5ChecksumValidPoints>"
        record += "</DataLink>"
    else:
        record += "<DataList>" + "".join(f"<Datum>{d}</Datum>" for d in datum) + "</DataList>"
    xml = f"""<?xml version="1.0" encoding="UTF-8"?>{doctype}
<p:ISO5436_2 {NS}><Record1><Revision>ISO5436 - 2000</Revision><FeatureType>{feature}</FeatureType>
<Axes>{axes}</Axes></Record1><Record2><Comment>{"long " * 500}</Comment></Record2>
<Record3>{record}</Record3>{after}<Record4><ChecksumFile>md5checksum.hex</ChecksumFile></Record4>
</p:ISO5436_2>""".encode()
    files["main.xml"] = xml
    if checksum:
        files["md5checksum.hex"] = (hashlib.md5(xml).hexdigest() + " *main.xml\n").encode()
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=level) as archive:
        for name, content in files.items():
            archive.writestr(folder + name, content)

rng = np.random.default_rng(1)
bump = np.exp(-2 * (np.arange(-20, 21) / 6.0) ** 2)

def smooth(shape):
    z = rng.standard_normal((shape[0] + 40, shape[1] + 40))
    z = np.apply_along_axis(lambda r: np.convolve(r, bump, "valid"), 1, z)
    z = np.apply_along_axis(lambda r: np.convolve(r, bump, "valid"), 0, z)
    return 3e-7 * z / z.std()

grid = axis("X", "I", increment=5e-7) + axis("Y", "I", increment=5e-7)
END

cat >make.py <<'END'
import struct
from x3p import *
z = smooth((60, 80)) + 1e-5
z[7, 11] = z[40, 2] = np.nan
np.save("map.npy", z * 1e6)
invalid = np.isnan(z)
valid = np.packbits(~invalid.ravel(), bitorder="little").tobytes()
filled = np.where(invalid, 0, z)
write("double.x3p", grid + axis("Z", "A", "D"), (80, 60, 1), z.astype("<f8").tobytes())
write("float.x3p", grid + axis("Z", "A", "F"), (80, 60, 1), z.astype("<f4").tobytes())
write("int16.x3p", grid + axis("Z", "A", "I", 1e-10, 1e-5), (80, 60, 1),
      np.round((filled - 1e-5) / 1e-10).astype("<i2").tobytes(), valid)
write("int32.x3p", grid + axis("Z", "A", "L", 1e-14, 1e-5), (80, 60, 1),
      np.round((filled - 1e-5) / 1e-14).astype("<i4").tobytes(), valid)
with open("map.txt", "w") as out:
    out.write("# Channel: Z\n# Width: 40 um\n# Height: 30 um\n# Value units: m\n")
    out.write("".join("\t".join("" if np.isnan(v) else f"{v:.12g}" for v in row) + "\n" for row in z))
with open("map.sdf", "w", newline="\r\n") as out:
    out.write("aISO-1.0\nManufacID = test\nCreateDate = 010120200000\nModDate = 010120200000\n"
              "NumPoints = 80\nNumProfiles = 60\nXscale = 5e-07\nYscale = 5e-07\nZscale = 1e-12\n"
              "Zresolution = -1\nCompression = 0\nDataType = 7\nCheckType = 0\n*\n")
    for row in z:
        out.write(" ".join("BAD" if np.isnan(v) else f"{v * 1e12:.9f}" for v in row) + "\n")
    out.write("*\n\n*\n")

def sdf(name, kind, z_scale, values):  # ISO 25178-71, binary
    head = struct.pack("<8s10s12s12sHHddddbbb", b"bISO-1.0", b"test", b"", b"", 80, 60, 5e-7, 5e-7,
                       z_scale, 0, 0, kind, 0)
    open(name, "wb").write(head + values.tobytes())

sdf("double.sdf", 7, 1, z.astype("<f8"))
sdf("int16.sdf", 5, 1e-10, np.where(invalid, -2 ** 15, np.round((filled - 1e-5) / 1e-10)).astype("<i2"))

def sur(name, magic=b"DIGITAL SURF", points=80 * 60, comment=b"a note"):  # Digital Surf
    step = 1e-8
    raw = np.round(filled * 1e6 / step).astype("<i4")
    least = int(raw[~invalid].min())
    raw[invalid] = least - 2
    head = struct.pack("<12s4H30s30s5H2IH4iI3f", magic, 0, 1, 100, 2, b"", b"", 0, 0, 0, 1, 0, 0, 0, 32,
                       least, int(raw.max()), 80, 60, points, 0.5, 0.5, step)
    head += b"".join(name.ljust(16) for name in (b"X", b"Y", b"Z") + 2 * (b"\xb5m", b"\xb5m", b"\xb5m"))
    head = head.ljust(334, b"\0") + struct.pack("<2H", len(comment), 0)
    open(name, "wb").write(head.ljust(512, b"\0") + comment + raw.tobytes())

sur("map.sur")
sur("compressed.sur", b"DSCOMPRESSED")
sur("numbers.sur", points=7)
open("cut.sur", "wb").write(open("map.sur", "rb").read()[:9000])
open("head.sur", "wb").write(open("map.sur", "rb").read()[:300])

# Zygo's ASCII, as prysm's write_zygo_ascii has it: phases in wave * scale * obliquity / 32768
phase = np.where(invalid, 2147483647, np.round(filled / (0.5 * 633e-9 / 32768))).astype(int)
with open("zygo.dat", "w") as out:
    out.write('Zygo ASCII Data File - Format 2\n0 0 0 0 "Fri Nov 11 11:11:11 2011"\n0 0 0 0 0 0\n')
    out.write('0 0 80 60\n"%81s"\n"%39s"\n"%39s"\n0 0.5 6.33e-07 0 1 0 5e-07 1321009871\n' % ("", "", ""))
    out.write('80 60 0 0 0 0 "%9s"\n0 0 0 0 0 0 0 0 0 0\n1 1 20 2 0 0 0 0 0\n0 "%12s"\n1 0\n"%7s"\n' % ("", "", ""))
    out.write("#\n#\n")
    for row in phase.reshape(-1, 10):
        out.write(" ".join(map(str, row)) + "\n")
    out.write("#\n")
open("cut.dat", "w").write(open("zygo.dat").read()[:9000])
open("nocamera.dat", "w").write(open("zygo.dat").read().replace(" 5e-07 ", " 0 "))

line = smooth((60, 3000))[0]
x = np.arange(3000) * 2.5e-7
np.savetxt("line.csv", np.c_[x * 1e3, line * 1e9], delimiter=",", header="x_mm,z_nm", comments="",
           fmt="%.12g")
profile = axis("X", "I", increment=2.5e-7) + axis("Y", "I", increment=1.0)
write("line.x3p", profile + axis("Z", "A", "D"), (3000, 1, 1), line.astype("<f8").tobytes(),
      feature="PRF")
write("list.x3p", profile + axis("Z", "A", "D"), (3000, 1, 1), feature="PRF",
      datum=["" if i == 5 else repr(float(v)) for i, v in enumerate(line)])
absolute = axis("X", "A", "D") + axis("Y", "I", increment=1.0) + axis("Z", "A", "F")
mixed = b"".join(struct.pack("<df", a, b) for a, b in zip(x, line))
write("places.x3p", absolute, (3000, 1, 1), mixed, feature="PRF", checksum=False)
write("listed.x3p", absolute, (3000, 1, 1), feature="PRF",
      datum=[f"{float(a)!r};{float(b)!r}" for a, b in zip(x, line)])

data = z.astype("<f8").tobytes()
full = grid + axis("Z", "A", "D")
write("folder.x3p", full, (80, 60, 1), data, folder="scan 17/")
write("offset.x3p", full.replace("</CX>", "<Offset/></CX>"), (80, 60, 1), data)
write("md5.x3p", full, (80, 60, 1), data, md5="0" * 32)
write("short.x3p", full, (80, 60, 1), data[:-8])
write("long.x3p", full, (80, 60, 1), data + b"12345678")
write("huge.x3p", full, (2 ** 20, 2 ** 20, 1), data)
write("layers.x3p", full, (80, 30, 2), data)
write("negative.x3p", full, (-80, -60, 1), data)
write("cloud.x3p", full, (80, 60, 1), data, feature="PCL")
write("type.x3p", grid + axis("Z", "A", "Q"), (80, 60, 1), data)
write("step.x3p", axis("X", "I", increment=0.0) + axis("Y", "I", increment=1e-6) +
      axis("Z", "A", "D"), (80, 60, 1), data)
write("metres.x3p", axis("X", "I", increment=5e3) + axis("Y", "I", increment=5e3) +
      axis("Z", "A", "D"), (80, 60, 1), data)
write("few.x3p", profile + axis("Z", "A", "D"), (9, 1, 1), feature="PRF", datum=["1e-7"] * 8)
write("word.x3p", profile + axis("Z", "A", "D"), (2, 1, 1), feature="PRF", datum=["1e-7", "one"])
write("late.x3p", "", (9, 1, 1), feature="PRF", datum=[""] * 9, after=profile + axis("Z", "A", "D"))
write("wider.x3p", profile + axis("Z", "A", "D"), (3000, 1, 1), feature="PRF",
      datum=["1e-7"] * 3000, after=axis("X", "A", "D"))
write("doctype.x3p", full, (80, 60, 1), data,
      doctype='<!DOCTYPE a [<!ENTITY b "bbbb"><!ENTITY c "&b;&b;&b;">]>')
write("bomb.x3p", full, (4096, 4096, 1), bytes(8 * 4096 * 4096), level=9)
with zipfile.ZipFile("empty.x3p", "w") as archive:
    archive.writestr("readme", "nothing")
with zipfile.ZipFile("broken.x3p", "w") as archive:
    archive.writestr("main.xml", "<a><b></a>")
whole = open("double.x3p", "rb").read()
open("cut.x3p", "wb").write(whole[:len(whole) // 2])
flipped = bytearray(whole)
flipped[300] ^= 0xff
open("flipped.x3p", "wb").write(flipped)
END
/usr/bin/python3 make.py || fail "make.py"

# sigma and rms slope of the levelled map, over rows and columns, by numpy; and one format's numbers
# are another's.
cat >compare.py <<'END'
import json, sys
import numpy as np
z = np.load("map.npy")
y, x = np.indices(z.shape)
good = ~np.isnan(z)
a = np.c_[np.ones(good.sum()), x[good], y[good]]
z[good] -= a @ np.linalg.lstsq(a, z[good], rcond=None)[0]
sigma = np.r_[np.nanstd(z, axis=1), np.nanstd(z, axis=0)]
slope = np.r_[np.sqrt(np.nanmean(np.diff(z, axis=1) ** 2, axis=1)),
              np.sqrt(np.nanmean(np.diff(z, axis=0) ** 2, axis=0))] / 0.5
d = json.load(open("out"))
raw = d["raw"]
tolerance = float(sys.argv[1])
ok = len(d["scans"]) == 140 and sum(s["missing"] for s in d["scans"]) == 4
for key, values in ("sigma_um", sigma), ("rms_slope", slope):
    found = np.array([s[key]["value"] for s in raw["scans"]])
    ok &= np.allclose(found, values, rtol=tolerance)
    ok &= abs(raw[key]["average"] / values.mean() - 1) < tolerance
    ok &= abs(raw[key]["deviation"] / values.std(ddof=1) - 1) < 10 * tolerance
ok &= abs(raw["non_uniformity"] / (sigma.std(ddof=1) / sigma.mean()) - 1) < 10 * tolerance
sys.exit(not ok)
END
for case in double.x3p:1e-9 float.x3p:1e-3 int16.x3p:1e-3 int32.x3p:1e-6 map.txt:1e-6 map.sdf:1e-6 \
    double.sdf:1e-9 int16.sdf:1e-3 map.sur:1e-6 zygo.dat:1e-3 folder.x3p:1e-9 offset.x3p:1e-9; do
  works "${case%:*}" roughness "${case%:*}" --json --quiet --outliers 0
  check "${case%:*} against numpy" /usr/bin/python3 compare.py "${case#*:}"
done

# The profile, in five dresses: sigma, tau and the statistics behind the filter agree.
works "line.csv" roughness line.csv --cutoff 30 --json
cp out line.json
same='
import json, sys
a, b = json.load(open("line.json")), json.load(open("out"))
sys.exit(any(abs(a[c][k]["average"] / b[c][k]["average"] - 1) > float(sys.argv[1])
             for c in ("raw", "small") for k in ("sigma_um", "tau_um", "slope", "rms_slope")))'
for file in line.x3p list.x3p places.x3p listed.x3p; do
  works "$file" roughness $file --cutoff 30 --json
  check "$file is line.csv" /usr/bin/python3 -c "$same" 1e-3
done

# Behind the filter: the convolution, its weights renormalised at the ends, written out.
filtered='
import json, sys
import numpy as np
x, z = np.loadtxt("line.csv", delimiter=",", skiprows=1).T
x, z = x * 1e3, z * 1e-3
z -= np.polyval(np.polyfit(x, z, 1), x)
cutoff, alpha = 30, np.sqrt(np.log(2) / np.pi)
weights = np.exp(-np.pi * ((x[:, None] - x) / (alpha * cutoff)) ** 2)
small = (z - weights @ z / weights.sum(axis=1))[60:-60]
step = np.sqrt(np.mean(np.diff(small) ** 2)) / 0.25
small -= small.mean()
c = np.correlate(small, small, "full")[len(small) - 1:] / (small @ small)
k = np.argmax(c < np.exp(-1))
tau = (k - 1 + (c[k - 1] - np.exp(-1)) / (c[k - 1] - c[k])) * 0.25
d = json.load(open("out"))["small"]
one = d["scans"][0]
sys.exit(not (one["points"] == len(small) and
              all(abs(d[key]["average"] / value - 1) < 1e-6 for key, value in
                  (("sigma_um", small.std()), ("tau_um", tau), ("rms_slope", step),
                   ("skewness", np.mean(small ** 3) / small.std() ** 3),
                   ("kurtosis", np.mean(small ** 4) / small.std() ** 4)))))'
works "line.csv again" roughness line.csv --cutoff 30 --json --outliers 0
check "the filter against numpy" /usr/bin/python3 -c "$filtered"
works "list.x3p, text" roughness list.x3p
check "the missing point is counted" has '3000 heights, 0.25 um apart, 1 missing, 0 outliers'

# ---- spellings of text, and pipes ---------------------------------------------------------------

works "line.csv as it is" roughness line.csv --csv plain.csv
sed 's/[^,]*/"&"/g' line.csv >quoted.csv
sed '1s/.*/X [MM],Z [NM]/' line.csv >upper.csv
for spelled in quoted.csv upper.csv; do
  works "$spelled" roughness $spelled --force --csv spelled.csv
  check "$spelled reads as line.csv" cmp <(sed "s/$spelled/line.csv/" spelled.csv) plain.csv
done
works "a pipe" roughness <(cat line.csv) --csv piped.csv
check "nothing of a pipe is lost" cmp <(sed 's,/dev/fd/[0-9]*,line.csv,' piped.csv) plain.csv
sed 's/\./,/g;s/,/;/' line.csv >comma.csv
printf 'x [um],z [nm],z [nm]\n0,3,4\n' >single.csv
refuses "one place" 1 '1 x 2 heights: a scan has at least 2' roughness single.csv
refuses "decimal commas" 1 'with a decimal point' roughness comma.csv
head -c 300 /dev/zero >zeros.bin
refuses "binary" 1 'neither X3P, nor SDF, nor .sur, nor text' roughness zeros.bin

# ---- bad X3P ------------------------------------------------------------------------------------

refuses "wrong md5" 1 'checksum of bindata/data.bin' roughness md5.x3p
works "wrong md5, on request" roughness md5.x3p --ignore-checksums -q
refuses "compressed .sur" 1 'without compression' roughness compressed.sur
refuses "numbers of a .sur" 1 'do not agree' roughness numbers.sur
refuses "cut .sur" 1 'where 80 x 60 heights need' roughness cut.sur
refuses "head of a .sur" 1 'no room for the header' roughness head.sur
refuses "cut Zygo" 1 'phases, where its header says 4800' roughness cut.dat
refuses "Zygo without calibration" 1 'camera is not calibrated' roughness nocamera.dat
refuses "short data" 1 'has 38392 bytes, where 4800 points need 38400' roughness short.x3p
refuses "long data" 1 '38408 bytes, more than the 38400' roughness long.x3p
refuses "huge dimensions" 1 'at most 2\^27' roughness huge.x3p
refuses "layers" 1 'several layers' roughness layers.x3p
refuses "negative dimensions" 1 'X is -80' roughness negative.x3p
refuses "point cloud" 1 "'PCL'" roughness cloud.x3p
refuses "unknown type" 1 'CZ is none of I, L, F, D' roughness type.x3p
refuses "no increment" 1 'Increment of CX' roughness step.x3p
refuses "not in metres" 1 'are the units right' roughness metres.x3p
refuses "list too short" 1 '8 points in its DataList' roughness few.x3p
refuses "a word for a number" 1 'Datum is no number' roughness word.x3p
refuses "a list before its axes" 1 'Record1 has to come before' roughness late.x3p
refuses "axes that change behind their list" 1 'Record1 has to come before' roughness wider.x3p
refuses "doctype" 1 'document type' roughness doctype.x3p
refuses "zip bomb" 1 '200 times its size' roughness bomb.x3p
refuses "no main.xml" 1 'no main.xml' roughness empty.x3p
refuses "malformed xml" 1 'main.xml:1: mismatched tag' roughness broken.x3p
refuses "cut archive" 1 'cut off' roughness cut.x3p
refuses "damaged archive" 1 '.' roughness flipped.x3p

# ---- other bad input ----------------------------------------------------------------------------

refuses "no scan" 2 'no SCAN' roughness
refuses "no such file" 1 'none.csv: cannot open' roughness none.csv
refuses "a folder" 1 'Is a directory' roughness .
: >empty.csv
refuses "empty" 1 'no heights' roughness empty.csv
printf 'x_um,z_um\n' >names.csv
for i in $(seq 0 99); do echo "$i,1.5"; done >>names.csv
refuses "constant" 1 'no roughness to measure' roughness names.csv
refuses "constant, filtered" 1 'no roughness to measure' roughness names.csv --cutoff 20
{ echo z_um; yes nan | head -n 200; } >nan.csv
refuses "nothing but nan" 1 'no roughness to measure' roughness nan.csv --spacing 1
refuses "z without spacing" 1 'give --spacing' roughness nan.csv
head -c 100000 /dev/urandom >noise.csv
refuses "noise" 1 '.' roughness noise.csv
refuses "unit" 1 'parsec' roughness map.txt --unit parsec
refuses "cut-off too short" 1 'give a cut-off from 2.5 to' roughness line.csv --cutoff 1
refuses "cut-off too long" 1 'give a cut-off from 2.5 to 375' roughness line.csv --cutoff 740
for bad in 0 -3 long nan ''; do
  refuses "cut-off '$bad'" 2 'neither a length in um nor auto' roughness line.csv --cutoff "$bad"
done
awk 'BEGIN { print "x_um,z_um"; for (i = 0; i < 2000; i++) { x = i + 0.3 * sin(i); print x "," sin(x / 9) } }' \
  >uneven.csv
refuses "unequal steps" 1 'unequally spaced: .*--resample' roughness uneven.csv
works "resampled" roughness uneven.csv --resample 0.5 --level none --json
check "resampled sine" json "abs(d['raw']['sigma_um']['average'] - 0.7071) < 0.005 and \
d['scans'][0]['spacing_um'] == 0.5"
refuses "negative spacing" 2 'outside' roughness line.csv --spacing -1
refuses "surface without index" 2 'needs --index' roughness line.csv --surface s.yaml
refuses "unknown index" 1 'Nowhere' roughness line.csv --surface s.yaml --index Nowhere
refuses "bad constant" 1 'neither n=N' roughness line.csv --surface s.yaml --index 1.5,x
refuses "input as output" 1 'is an output too' roughness line.csv --csv line.csv --force
refuses "one output twice" 2 'two outputs' roughness line.csv --csv a --html a
refuses "existing output" 1 'exists: use --force' roughness line.csv --csv map.txt
check "nothing written" test ! -e s.yaml -a ! -e a

# ---- outputs ------------------------------------------------------------------------------------

works "all outputs" roughness line.csv map.sdf --cutoff 10 --csv all.csv --html all.html \
  --surface all.yaml --index Al
check "text has both components" has '^Unfiltered, levelled'
check "text has the small scale" has '^Small scale, behind the Gaussian filter with cut-off 10 um'
check "two slopes, two names" has 'sigma/tau +rms slope'
check "the averages" has '^  average '
check "the non-uniformity" has 'non-uniformity .*: 0\.[0-9]+'
columns='
import csv, sys
rows = list(csv.DictReader(open("all.csv")))
raw, small = ([r for r in rows if r["component"] == c] for c in ("raw", "small"))
sys.exit(not (len(raw) == 141 and 0 < len(small) <= 141 and raw[0]["scan"] == "line.csv" and
              raw[1]["scan"] == "map.sdf row 1" and all(
                  abs(float(r["slope"]) - float(r["sigma_um"]) / float(r["tau_um"])) < 1e-8 and
                  float(r["sigma_um_error"]) > 0 for r in rows)))'
check "csv" /usr/bin/python3 -c "$columns"
page='
import sys, xml.dom.minidom
text = open("all.html").read().split("</head>")[1].replace("</html>", "")
xml.dom.minidom.parseString(text)
sys.exit(not (text.count("<svg viewBox") == 5 and "nan" not in text.lower().replace("scan", "")))'
check "html is well-formed, with its plots" /usr/bin/python3 -c "$page"
check "the surface has its bounds" grep -Eq '^# sigma0_um: \[0\.[0-9]+, 0\.[0-9]+\]' all.yaml
works "the surface tabulates" tabulate all.yaml -o all.h5 --method literal --samples 0 --quiet \
  --theta-i 0:60:3 --theta-r 0:60:3 --phi 0:180:3 --wavelengths 550
works "index by name" roughness line.csv --surface nk2.yaml --index n=1.5,k=0.1 --quiet
works "constant index" roughness line.csv --surface nk.yaml --index 1.5,0.1 --quiet
check "quiet" test ! -s out
check "constant index in the surface" grep -qx 'index: {n: 1.5, k: 0.1}' nk.yaml
/usr/bin/python3 - <<'END' # one scale, and with a large one
import numpy as np
z = np.convolve(np.random.default_rng(3).standard_normal(4120),
                np.exp(-2 * (np.arange(-60, 61) * 0.25 / 4) ** 2), "valid")
x = np.arange(4000) * 0.25
for name, large in (("one", 0), ("two", 1)):
    np.savetxt(f"{name}.csv", np.c_[x, 0.3 * z / z.std() + large * np.sin(x / 50)], delimiter=",",
               header="x_um,z_um", comments="")
END
works "auto" roughness two.csv --cutoff auto --json --html auto.html
check "auto shows the scan" json "len(d['cutoff_scan']['trials']) > 20 and d['cutoff_um'] > 0 and \
d['small'] and d['cutoff_scan']['trials'][0]['cutoff_um'] < d['cutoff_um']"
check "auto plots it" grep -q 'Slope against cut-off' auto.html
works "one scale" roughness one.csv --cutoff auto --json --html one.html --surface one.yml --index Cu
check "no cut-off" json "d['cutoff_um'] is None and d['small'] is None and \
len(d['cutoff_scan']['trials']) > 20 and any('No large scale' in n for n in d['notes'])"
check "its surface is the unfiltered one" json "abs(float([l.split()[1] for l in open('one.yml') \
if l.startswith('sigma0_um')][0]) / d['raw']['sigma_um']['average'] - 1) < 1e-3"
check "none on the page" grep -q 'none is chosen' one.html
works "one scale, printed" roughness one.csv --cutoff auto
check "none chosen" has 'chosen: none'
printf 'z_nm\n%s\n' "$(seq 1 500 | awk '{print 100*sin($1/7)}')" >plain.csv
works "unit of the spacing" roughness plain.csv --spacing 0.5 --json --level none
check "nm to um" json "abs(d['raw']['sigma_um']['average'] - 0.0707) < 0.001 and \
d['scans'][0]['spacing_um'] == 0.5 and d['small'] is None and d['cutoff_scan'] is None and \
d['raw']['non_uniformity'] is None"

# ---- published rows -----------------------------------------------------------------------------

printf 'scan,sigma_um\n1,0.50\n2,0.54\n3,0.55\naverage,0.53\ndeviation,0.03\n' >rows.csv
works "rows" roughness --rows rows.csv
check "the average" has '^  average +0\.53$'
check "the non-uniformity with two digits" has '^  non-uniformity +0\.05$'
check "what agrees is counted" has '^2 of 2 stated numbers agree to the digit$'
sed -i s/0.03/0.01/ rows.csv
"$program" roughness --rows rows.csv >out 2>err
check "a differing row, status 3" test $? = 3 -a ! -s err
check "a differing row is named" has 'deviation, sigma_um: 0\.01 stated, 0\.026457.*: DIFFERS'

# The report's Tables 3 to 7: of the 35 summaries 31 agree, 4 are within the rounding of their rows;
# of the 45 slopes four of Table 4 are errors of the print. Table 1 takes its slopes from its own row.
"$program" roughness --json --rows "$scripts"/../tests/data/report/table[1-7].csv >out 2>err
check "the report's tables, status 3" test $? = 3 -a ! -s err
cat >report.py <<'END'
import collections, json
d = json.load(open("out"))
own = [c for c in d["checks"] if c["table"] == c["against"] and c["table"] >= 2]
summaries = [c for c in own if not c["row"].isdigit()]
slopes = [c for c in own if c["row"].isdigit()]
count = lambda checks: dict(collections.Counter(c["verdict"] for c in checks))
assert count(summaries) == {"agrees": 31, "within rounding": 4}, count(summaries)
assert count(slopes) == {"agrees": 39, "within rounding": 2, "differs": 4}, count(slopes)
wrong = [(d["tables"][c["table"]]["name"][-10:], c["row"]) for c in d["checks"] if c["verdict"] == "differs"]
assert wrong == [("table4.csv", r) for r in "4567"], wrong
between = [c for c in d["checks"] if c["table"] == 0 and c["against"] > 0]
assert [c["against"] for c in between] == sorted([2, 3, 4, 5, 6] * 4)
odd = [c for c in between if c["verdict"] == "follows from its own row"]
assert [(c["row"], c["column"], c["stated"]) for c in odd] == [("GGAL120", "slope", 0.154)]
assert all(c["verdict"] in ("agrees", "within rounding") for c in between if c not in odd)
END
check "each number is explained" /usr/bin/python3 report.py
refuses "no rows" 1 'a header such as' roughness --rows empty.csv

# ---- long profiles: one made here, and a measured one where ../shared has it ---------------------

# Levelled, not filtered, against numpy: the autocorrelation as a sum of products.
measured='
import json, sys
import numpy as np
x, z = np.loadtxt(sys.argv[1], delimiter=",", skiprows=1).T
z -= np.polyval(np.polyfit(x, z, 1), x)
c = np.correlate(z, z, "full")[len(z) - 1:] / (z @ z)
k = np.argmax(c < np.exp(-1))
tau = (k - 1 + (c[k - 1] - np.exp(-1)) / (c[k - 1] - c[k])) * 0.25
slope = np.sqrt(np.mean(np.diff(z) ** 2)) / 0.25
raw = json.load(open("out"))["raw"]
ok = all(abs(raw[key]["average"] / value - 1) < 1e-6 for key, value in
         (("sigma_um", z.std()), ("tau_um", tau), ("slope", z.std() / tau), ("rms_slope", slope)))
ok &= len(sys.argv) < 3 or (abs(z.std() - 0.560) < 5e-4 and abs(tau - 11.3) < 0.05 and abs(slope - 0.106) < 5e-4)
ok &= len(sys.argv) < 3 or abs(raw["slope"]["average"] - 0.0495) < 5e-5
sys.exit(not ok)'
awk 'BEGIN { # sparks leave craters: an exponential autocorrelation
  srand(2); print "x_um,z_um"
  for (i = 0; i < 22401; i++)
    printf "%.2f,%.9f\n", i / 4, z = 0.98 * z + 0.11 * (rand() + rand() + rand() + rand() - 2)
}' >long.csv
works "long profile" roughness long.csv --json
check "long profile against numpy" /usr/bin/python3 -c "$measured" long.csv
if [ -f "$heights" ]; then
  works "measured profile" roughness "$heights" --json
  check "measured profile against numpy" /usr/bin/python3 -c "$measured" "$heights" published
fi

summary
