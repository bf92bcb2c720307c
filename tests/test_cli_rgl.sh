#!/bin/bash
# hetab tabulate to RGL tables (.bsdf), from the outside: files, reports, options, refusals.
# usage: test_cli_rgl.sh PROGRAM
. "$(dirname "$0")/cli_support.sh"

# parse FILE: the fields of a tensor file, by a parser that knows nothing of ours: name type shape.
parse() {
  /usr/bin/python3 - "$1" <<'PYTHON'
import struct, sys
b = open(sys.argv[1], "rb").read()
assert b[:14] == b"tensor_file\0\1\0"
at, end = 18, 0
for _ in range(struct.unpack_from("<I", b, 14)[0]):
    n, = struct.unpack_from("<H", b, at)
    name = b[at + 2:at + 2 + n].decode(); at += 2 + n
    ndim, dtype, offset = struct.unpack_from("<HBQ", b, at); at += 11
    shape = struct.unpack_from("<%dQ" % ndim, b, at); at += 8 * ndim
    size = {1: 1, 10: 4}[dtype]
    for s in shape: size *= s
    assert offset % 8 == 0 and offset >= end and offset + size <= len(b)
    end = offset + size
    print(name, dtype, *shape)
assert end == len(b)
PYTHON
}

fields() { parse "$1" >parsed && [ "$(cut -d' ' -f1 parsed | paste -sd' ')" = "$2" ]; }
shape() { grep -Eq "^$1 $2\$" parsed; }

# ---- linear sRGB -------------------------------------------------------------------------------

works "rgb" tabulate BBQAL2 -o a.bsdf --table-error 0.05
check "summary" has '^a\.bsdf: rgb, [0-9]+ incidences of [0-9]+ x [0-9]+ nodes, .* MB; relative L1 error at most 0\.0[0-9]+ \(0\.05 asked for\), bias'
check "specular note" has '^a\.bsdf: specular reflectance, at most .*, 0\.[0-9]+ % of the light, is in a\.specular\.csv'
check "no device" has '^BBQAL2 on the host'
check "fields" fields a.bsdf "description jacobian phi_i theta_i ndf sigma vndf luminance rgb"
check "rgb shape" shape rgb '10 1 ([0-9]+) 3 ([0-9]+) \2'
check "luminance shape" shape luminance '10 1 ([0-9]+) ([0-9]+) \2'
check "one azimuth" shape phi_i '10 1'
check "csv" [ "$(wc -l <a.specular.csv)" = 2822 ]
check "description" grep -aq "BBQAL2: sigma0 0.54 um, tau 6.5 um" a.bsdf

# ---- spectra -----------------------------------------------------------------------------------

works "spectral" tabulate BBQAL2 -o s.bsdf --bands spectral --wavelengths 500,600 --table-error 0.05 --json
check "json" json "(o := d['outputs'][0])['format'] == 'rgl' and o['table']['bands'] == 'spectral' \
  and 0 < o['table']['error_l1'] <= 0.05 == o['table']['table_error'] and o['table']['bytes'] > 1e4 \
  and o['specular']['file'] == 's.specular.csv' and not o['specular']['in_table'] and d['device'] is None"
check "spectral fields" fields s.bsdf "description jacobian phi_i theta_i ndf sigma vndf luminance wavelengths spectra"
check "spectra shape" shape spectra '10 1 ([0-9]+) 2 ([0-9]+) \2'

# ---- with other formats ------------------------------------------------------------------------

works "beside the others" tabulate BBQAL2 -o b.bsdf -o b.binary -o b.h5 --theta-i 0,45 --theta-r 0,45 \
  --phi 0,180 --table-error 0.1 --samples 100 --force
check "one csv for both" [ "$(ls b.* | paste -sd' ')" = "b.binary b.bsdf b.h5 b.specular.csv" ]
check "each is named" has '^b\.binary: specular reflectance, at most 0\.2.* is in b\.specular\.csv'
check "the same maximum" has '^b\.bsdf: specular reflectance, at most 0\.2'

# ---- who reads it ------------------------------------------------------------------------------

reads() { PYTHONPATH= /usr/bin/python3 "$scripts/../tests/tensor_file.py" --reader "$1" "$2"; }
check "an rgb file for Mitsuba" reads mitsuba-rgb a.bsdf
check "and powitacq_rgb" reads powitacq-rgb a.bsdf
refused() { ! reads "$@"; }
check "not for pbrt" refused pbrt a.bsdf
for reader in mitsuba-rgb mitsuba-spectral pbrt powitacq powitacq-rgb; do
  works "for $reader" tabulate NGGAL -o "$reader.bsdf" --for $reader --table-error 0.1 --wavelengths 400:700:10
  check "$reader reads it" reads $reader "$reader.bsdf"
  check "$reader: the summary says who loads it" has "^$reader.bsdf: loads in "
done
check "pbrt is named" has "powitacq_rgb; for pbrt-v4 take --for pbrt"
works "for pbrt, all that it asks for" tabulate NGGAL -o wide.bsdf --for pbrt --table-error 0.1 --wavelengths 360:830:10
check "it reads that" reads pbrt wide.bsdf
check "nothing is beyond" has "^wide.bsdf: loads in pbrt-v4, powitacq and Mitsuba 3's spectral variants\$"
works "for lidar" tabulate NGGAL -o lidar.bsdf --for powitacq --table-error 0.1 --wavelengths 905,1550
check "bands beyond are told" has 'outer bands stand for all beyond, the visible ones too$'
refuses "for nothing" 2 "--for is for .bsdf outputs" tabulate NGGAL -o x.h5 --for pbrt
refuses "for another" 2 "pbrt reads spectra" tabulate NGGAL -o x.bsdf --for pbrt --bands rgb

# ---- the delta ---------------------------------------------------------------------------------

cat >steel.yml <<'YAML'
sigma0_um: 0.03
tau_um: 3
index: {n: 2.9, k: 3.1}
YAML
works "a near mirror" tabulate steel.yml -o steel.bsdf --table-error 0.1
check "says what it lacks" has 'warning: the table lacks [789][0-9] % of the light.*--specular-cone 2.*steel.specular.csv.*hetab shader'
printf 'sigma0_um: 0.001\ntau_um: 0.05\nindex: Au\n' >mirror.yml
works "a mirror" tabulate mirror.yml -o mirror.bsdf --table-error 0.1
check "lacks all of it" has 'the table lacks 100 % of the light'
rm steel.bsdf
refuses "beside an old csv" 1 "steel.specular.csv" tabulate steel.yml -o steel.bsdf --specular-cone 3 --table-error 0.1
works "folded" tabulate steel.yml -o steel.bsdf --specular-cone 3 --table-error 0.1 --force --json
check "no csv is left" [ ! -e steel.specular.csv ]
check "it is in the table" json "d['outputs'][0]['specular']['in_table'] and d['outputs'][0]['specular']['cone_deg'] == 3"
check "and marked" fields steel.bsdf "description jacobian phi_i theta_i ndf sigma vndf luminance specular_cone_deg rgb"
works "conversions keep the mark" convert steel.bsdf marked.binary --json
works "and from MERL" convert marked.binary back.bsdf --table-error 0.1 --json
check "a folded delta is none" json "d['specular_max'] == 0"
check "RGL is marked again" fields back.bsdf "description jacobian phi_i theta_i ndf sigma vndf luminance specular_cone_deg rgb"
works "a folded MERL table" tabulate steel.yml -o two.binary --specular-cone 2 --samples 0
works "and an RGL table of its name" tabulate steel.yml -o two.bsdf --table-error 0.1
check "whose delta" [ -e two.specular.csv ]
works "is not taken for the first one's" convert two.binary two.h5 --theta-i 0,2 --theta-r 0,2 --json
check "which has its own" json "d['specular_max'] == 0"
refuses "a cone below two rows of MERL" 1 "take 0.044 or more" tabulate steel.yml -o c.binary --specular-cone 0.04
refuses "a cone below two nodes of RGL" 1 "take 0.0055 or more" tabulate steel.yml -o c.bsdf --specular-cone 0.005
refuses "a cone for HDF5" 2 "keeps the delta apart.* outputs" tabulate steel.yml -o c.h5 --specular-cone 2
works "tiny numbers" tabulate BBQAL2 -o tiny.bsdf --table-error 0.1
normal() { /usr/bin/python3 -c "
import csv
rho = [float(r['rho_s']) for r in csv.DictReader(open('tiny.specular.csv'))]
assert min(rho) == 0 and not [r for r in rho if 0 < r < 1e-30]"; }
check "are 0" normal
works "mono" tabulate BBQAL2 -o mono.binary --merl-colour mono --bands 550
check "is marked" grep -q '^550,85,0.[0-9]*,mono$' mono.specular.csv

# ---- refusals ----------------------------------------------------------------------------------

refuses "existing" 1 "a.bsdf" tabulate BBQAL2 -o a.bsdf --table-error 0.1
refuses "two names" 2 "given twice" tabulate BBQAL2 -o c.bsdf -o ./c.bsdf
refuses "table error" 2 "table-error" tabulate BBQAL2 -o c.bsdf --table-error 0
refuses "bands of a bsdf" 2 "neither rgb nor spectral" tabulate BBQAL2 -o c.bsdf --bands 550
refuses "bands without a bsdf" 2 "there is none" tabulate BBQAL2 -o c.h5 --bands rgb
refuses "rgb of one wavelength" 1 "400 to 700 nm" tabulate BBQAL2 -o c.bsdf --wavelengths 550
cat >needle.yml <<YAML
sigma0_um: 0.05
tau_um: 60
index: Al
wavelengths_nm: [550]
YAML
works "out of reach" tabulate needle.yml -o c.bsdf --bands spectral --table-error 0.0001
check "it says so" has 'warning: no table of any size keeps that error'
check "and writes the largest" [ -e c.bsdf -a -e c.specular.csv ]

summary
