#!/bin/bash
# Tests `hetab fit`: from measurements to parameters, files and sentences, and what it refuses.
# usage: test_cli_fit.sh PROGRAM
. "$(dirname "$0")/cli_support.sh"

# ---- measurements: BBQAL1 in the incidence plane, a = 0.05 (reflectance) and 2 % noise ----------

/usr/bin/python3 - >points.csv <<'PYTHON'
print("lambda_um,theta_i_deg,theta_r_deg,phi_deg")
for nm in (450, 550, 650):
    for theta_i in (10, 30, 50, 65):
        for theta_r in range(-80, 81, 4):
            print(f"{nm / 1000},{theta_i},{abs(theta_r)},{180 if theta_r > 0 else 0}")
PYTHON
"$program" eval BBQAL1 --method literal <points.csv >values.csv 2>err || fail "points: $(cat err)"
/usr/bin/python3 - <<'PYTHON'
import csv, math, random
random.seed(1)
rows = list(csv.DictReader(open("values.csv")))
def write(name, scale=1.0, negative=False, keep=lambda r: True, value=None):
    with open(name, "w") as out:
        print("wavelength_nm,theta_i_deg,theta_r_deg,phi_deg,f", file=out)
        for r in filter(keep, rows):
            f = (float(r["dd"]) + 0.05 / math.pi) * (1 + random.gauss(0, 0.02)) * scale
            f = value if value is not None else f
            print(f"{1000 * float(r['lambda_um']):.10g},{r['theta_i_deg']},{r['theta_r_deg']},"
                  f"{r['phi_deg']},{-f if negative else f:.9g}", file=out)
write("plane.csv")
write("negative.csv", negative=True)
write("missing.csv", value=math.nan)
write("below.csv", keep=lambda r: False)
with open("below.csv", "a") as out:
    print("550,10,95,180,1\n550,95,10,180,1", file=out)
PYTHON

slope="json \"abs(d['fits'][0]['estimates'][0]['value'] / (0.72 / 5.6) - 1) < 0.02\""
fit="fit plane.csv --index Al --tau 5.6"

# ---- results -----------------------------------------------------------------------------------

works "fit" $fit --constraint none
check "fit names its error" has 'error E [12]\.[0-9]+ %'
check "fit lists parameters" has '^  slope +0\.12[6-9]'
check "fit lists the diffuse part" has '^  a 550 nm +0\.0[345]'
check "fit lists incidences" has '^ +65 '
check "fit counts its starts" has '4 of 4 starts gave this answer'
works "fit as JSON" $fit --constraint none --json
check "slope in JSON" eval "$slope"
check "JSON has a fit" json "d['fits'][0]['stop'] == 'tolerance' and len(d['fits'][0]['estimates']) == 6"
check "a in JSON" json "all(abs(e['value'] - 0.05) < 0.02 for e in d['fits'][0]['estimates'][3:])"
check "intervals in JSON" json "all(e['low'] <= e['value'] <= e['high'] for e in d['fits'][0]['estimates'])"
check "correlation in JSON" json "len(d['fits'][0]['correlation']['matrix']) == 4"
works "fit with the constraint" $fit --ask-a 0.05 --json
check "ends on the constraint" json "d['fits'][0]['on_constraint'] and -1e-5 <= d['fits'][0]['margin'] < 1e-5"
check "says what a needs" json "any('a = 0.05 (reflectance) would need' in n for n in d['fits'][0]['notes'])"
check "excess" json "d['fits'][0]['incidences'][0]['excess'] > 0.04"
works "measurements from a pipe" fit <(cat plane.csv) --index Al --tau 5.6 --constraint none --json
check "nothing of a pipe is lost" eval "$slope"
works "float" $fit --constraint none --precision float --json
check "slope in float" eval "$slope"
works "one wavelength" $fit --constraint none --wavelengths 550 --theta-i 30,65 --plane --json
check "one wavelength's values" json "d['fits'][0]['values'] == 2 * 41"
works "each wavelength" $fit --constraint none --per-wavelength --json --csv each.csv
check "three fits" json "len(d['fits']) == 3"
check "three fits as CSV" test "$(wc -l <each.csv)" = 13
works "each wavelength as text" $fit --constraint none --per-wavelength
check "a row each" has '^ +450 .* tolerance'
works "bootstrap" $fit --constraint none --wavelengths 550 --bootstrap 50 --json
check "bootstrap intervals" json "d['fits'][0]['estimates'][0]['bootstrap_low'] < d['fits'][0]['estimates'][0]['bootstrap_high']"
works "bounds" $fit --constraint none --bounds slope=0.2:0.4 --wavelengths 550 --json
check "ends on its bound" json "d['fits'][0]['estimates'][0]['value'] == 0.2 and d['fits'][0]['estimates'][0]['end'] == 'lower bound'"
works "a-constant" $fit --constraint none --free slope,a-constant --weights relative --json
check "one a for all" json "len(d['fits'][0]['estimates']) == 4 and d['fits'][0]['estimates'][3]['wavelength_nm'] is None"
works "n free" fit plane.csv --index n=1.5 --free slope,n --tau 5.6 --wavelengths 550 --bounds n=1.1:8 --json
refuses "n out of range" 2 "bounds" fit plane.csv --index n=1.5 --free slope,n --tau 5.6 --bounds n=5:1

# ---- files -------------------------------------------------------------------------------------

works "files" $fit --constraint none --surface s.yaml --csv e.csv --points p.csv
check "surface tabulates" "$program" tabulate s.yaml -o s.h5 --theta-i 0:80:5 --theta-r 0:80:5 \
  --phi 0:180:3
check "surface holds the slope" grep -Eq '^sigma0_um: 0\.7' s.yaml
check "surface holds a for each wavelength" grep -Eq '^diffuse_reflectance: \[' s.yaml
check "CSV header" grep -q '^quantity,wavelength_nm,value,low,high,' e.csv
check "CSV rows" test "$(wc -l <e.csv)" = 7
check "points" test "$(wc -l <p.csv)" = "$(wc -l <plane.csv)"
/usr/bin/python3 - <<'PYTHON' && pass || fail "points: model off the measurements"
import csv, sys
rows = list(csv.DictReader(open("p.csv")))
big = [r for r in rows if float(r["measured"]) > 1]
sys.exit(not (big and all(abs(float(r["model"]) / float(r["measured"]) - 1) < 0.15 for r in big)))
PYTHON
# ---- numbers that are none ---------------------------------------------------------------------

numbers() {
  echo wavelength_nm,theta_i_deg,theta_r_deg,phi_deg,f
  for theta_r in 10 20 30; do echo 550,10,$theta_r,180,$1; done
}
numbers 1 >three.csv
works "three equal values" fit three.csv --index n=1.5 --tau 5 --json
check "what is not determined stays within its bounds" json "(lambda e: not e['determined'] and \
  0.005 <= e['low'] <= e['value'] <= e['high'] <= 1)(d['fits'][0]['estimates'][0])"
{ numbers 1; numbers 0 | sed '1d;s/550,10/550,20/'; } >dark.csv
works "an incidence without a logarithm" fit dark.csv --index n=1.5 --tau 5 --weights log --json
check "both incidences are there" json "[i['values'] for i in d['fits'][0]['incidences']] == [3, 0]"
numbers 1e308 >vast.csv
refuses "values beyond any surface" 1 'vast.csv:2: a BRDF of 1e\+308' fit vast.csv --index Al --tau 5
refuses "prediction beside such" 1 'vast.csv:2: a BRDF of 1e\+308' predict BBQAL1 --measurements vast.csv
numbers 1e-200 >faint.csv
refuses "values that square to nothing" 1 'next to 0' fit faint.csv --index Al --tau 5
refuses "existing file" 1 "exists: use --force" $fit --surface s.yaml
works "forced" $fit --constraint none --surface s.yaml --force
refuses "output is the input" 1 "is an output too" $fit --csv plane.csv --force
refuses "two outputs in one file" 2 "two outputs" $fit --csv x.csv --points ./x.csv
refuses "no such folder" 1 "nowhere" $fit --csv nowhere/x.csv
check "nothing written" test ! -e x.csv

# ---- what is refused ---------------------------------------------------------------------------

refuses "no measurements" 2 "no MEASUREMENTS" fit --index Al
refuses "two measurements" 2 "unexpected argument" fit plane.csv plane.csv --index Al
refuses "no index" 2 "no --index" fit plane.csv --tau 5
refuses "unknown index" 1 "no built-in metal 'Xx'" fit plane.csv --tau 5 --index Xx
refuses "n alone" 1 "'1.5' is neither n=N" fit plane.csv --tau 5 --index 1.5
refuses "malformed index" 1 "is neither n=N" fit plane.csv --tau 5 --index n=many
refuses "missing index file" 1 "cannot open" fit plane.csv --tau 5 --index none.yml
refuses "missing file" 1 "none.csv" fit none.csv --tau 5 --index Al
refuses "unknown parameter" 2 "'gloss' is none of" fit plane.csv --free slope,gloss --index Al
refuses "reversed bounds" 2 "the lower one first" $fit --bounds slope=0.5:0.1
refuses "malformed bounds" 2 "NAME=LOW:HIGH" $fit --bounds slope
refuses "bounds of what is not free" 2 "n is not free" $fit --bounds n=1.2:2
refuses "roughness not given" 1 "one of slope, sigma0 and tau" fit plane.csv --index Al
refuses "all of roughness" 1 "all three" $fit --sigma0 1
refuses "nothing free" 1 "nothing is free" $fit --free '' --slope 0.1
refuses "n of a metal" 1 "varies with the wavelength" $fit --free slope,n
refuses "wavelength not measured" 1 "no measurements at 500 nm" $fit --wavelengths 500
refuses "incidence not measured" 1 "theta_i = 20" $fit --theta-i 20
refuses "nothing left" 1 "no measurement is left" $fit --exclude-mirror 180
refuses "all negative" 1 "." fit negative.csv --index Al --tau 5.6
refuses "all missing" 1 "." fit missing.csv --index Al --tau 5.6
refuses "below the horizon" 1 "." fit below.csv --index Al --tau 5.6
refuses "surface of many fits" 2 "leave out --per-wavelength" $fit --per-wavelength --surface y.yaml
printf 'wavelength_nm,n,k\n600,1,6\n700,1,7\n' >far.csv
refuses "outside the index data" 1 "outside the index data" fit plane.csv --index far.csv --tau 5.6
works "extrapolated" fit plane.csv --index ./far.csv --extrapolate --tau 5.6 --constraint none

# ---- paints ------------------------------------------------------------------------------------

# both FILE WAVELENGTHS: FILE.astm and FILE.brdf
both() {
  for format in astm brdf; do
    works "$1.$format" fit "$1.$format" --index n=1.5 --tau 5 --csv "both.$format.csv" --force
  done
  check "two formats of one paint" cmp both.astm.csv both.brdf.csv
  check "wavelengths" test "$(grep -c '^diffuse_reflectance,' both.brdf.csv)" = "$2"
  check "converged" test "$(grep -c ',tolerance$' both.brdf.csv)" = $(($2 + 3))
}
both "$scripts/../tests/data/measurements/paint" 7
cayman=$scripts/../../shared/data/measurements/cornell-cayman # measured
[ ! -e "$cayman.brdf" ] || both "$cayman" 31

summary
