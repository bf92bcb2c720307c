#!/bin/bash
# Tests `hetab predict` as its users meet it. usage: test_cli_predict.sh PROGRAM
. "$(dirname "$0")/cli_support.sh"

data=$(realpath "$scripts/../tests/data/measurements")
cat >s.yml <<'END'
sigma0_um: 0.5
tau_um: 5
index: Al
sigma0_bounds_um: [0.46, 0.53]
END

# ---- curves and bounds -------------------------------------------------------------------------

works "predict" predict BBQAL2 --non-uniformity 0.1 --theta-i 20,60
check "predict prints the bounds" has 'sigma0 0.54 um \(0.486 to 0.594\), tau 6.5 um'
check "predict has a row per incidence" test "$(grep -c '^ *550 ' out)" = 2
works "bounds of the surface's file" predict s.yml
check "bounds of the file are used" has 'sigma0 0.5 um \(0.46 to 0.53\)'
works "options over the file" predict s.yml --sigma0 0.4:0.6 --tau 4:5.5
check "options win" has 'sigma0 0.5 um \(0.4 to 0.6\), tau 5 um \(4 to 5.5\)'
works "bounds of the preset" predict BBQAL2
check "Table 1's non-uniformity" has 'sigma0 0.54 um \(0.50328 to 0.57672\)'
works "the slope's spread" predict BBQAL2 --slope-spread 6.8% --theta-i 20,60
check "carried by sigma0" has 'sigma0 0.54 um \(0.50328 to 0.57672\), tau 6.5 um$'
check "says so" has 'varied: sigma0 at fixed tau'
works "the slope's bounds" predict BBQAL2 --slope 0.08:0.1 --theta-i 30
check "at this tau" has 'sigma0 0.54 um \(0.52 to 0.65\)'
works "by tau" predict NGGAL --slope-spread 5.3% --theta-i 30 --vary tau --json
check "bounds of tau" json "abs(d['tau_um']['low'] - 5.4 / 1.053) < 1e-9 and d['sigma0_um']['low'] == d['sigma0_um']['high']"
cp out by-tau.json
works "both" predict NGGAL --slope-spread 5.3% --theta-i 30 --vary both --json --html both.html
check "both are there" json "d['with_tau'] == json.load(open('by-tau.json'))['curves'] and \
  max(d['curves'][0]['high']) > 1.01 * max(d['with_tau'][0]['high'])"
check "both are drawn" grep -q 'stroke-dasharray.*</svg>' both.html
refuses "two spreads" 2 'keep one' predict BBQAL2 --slope-spread 3% --slope 0.1:0.2
refuses "a percentage of nothing" 2 'not a number' predict BBQAL2 --slope-spread %
refuses "tau twice" 2 'leave out' predict BBQAL2 --slope-spread 3% --vary tau --tau 6:7
works "no bounds" predict BBQAL2-fit --theta-i 30 --json
check "no bounds, no width" json "d['curves'][0]['low'] == d['curves'][0]['f'] == d['curves'][0]['high']"
works "no bounds, in words" predict BBQAL2-fit --theta-i 30
check "says that there are none, and how to give them" has 'no bounds: .*--slope-spread'
works "predict --json" predict s.yml --json --theta-i 30 --wavelengths 450,650 --step 1
check "JSON holds curves in order" json "len(d['curves']) == 2 and len(d['theta_r_deg']) == 181 and \
  all(l <= f <= h for c in d['curves'] for l, f, h in zip(c['low'], c['f'], c['high']))"
check "the lobe is on the mirror side" json "all(25 < c['peak_theta_r_deg'] < 40 for c in d['curves'])"
check "rho_s has bounds" json "all(c['rho_s']['low'] <= c['rho_s']['high'] for c in d['curves'])"

# The nominal curve is what eval says, the ends of the interval lie within the bounds.
works "predict --csv" predict s.yml --theta-i 40 --step 5 --csv c.csv --quiet
check "quiet is quiet" test ! -s out
for sigma0 in 0.46 0.5 0.53; do
  awk -F, -v s=$sigma0 'NR == 1 {print "lambda_um,theta_i_deg,theta_r_deg,phi_deg,sigma0_um"; next}
    {print $1 / 1000 "," $2 "," $3 "," $4 "," s}' c.csv | "$program" eval s.yml >eval-$sigma0.csv
done
cat >compare.py <<'END'
import csv
def column(path, name):
    return [float(row[name]) for row in csv.DictReader(open(path))]
f, low, high = (column("c.csv", n) for n in ("f", "low", "high"))
assert len(f) == 37
for value, expected in zip(f, column("eval-0.5.csv", "total")):
    assert abs(value - expected) <= 1e-6 * expected + 1e-12
for end in ("0.46", "0.53"):
    for value, l, h in zip(column(f"eval-{end}.csv", "total"), low, high):
        assert l * (1 - 1e-5) - 1e-12 <= value <= h * (1 + 1e-5) + 1e-12
END
check "curves are the model's" /usr/bin/python3 compare.py
export OCL_ICD_VENDORS=$work/nowhere/
works "literal needs no device" predict s.yml --theta-i 30 --step 10 --method literal
unset OCL_ICD_VENDORS

# Scans of 0.9, 1 and 1.1 times one profile: the non-uniformity is 0.1.
awk 'BEGIN {print "x_um,z1_um,z2_um,z3_um"; srand(1)
  for (i = 0; i < 1000; i++) {
    z = 0.9 * z + rand() - 0.5
    printf "%.1f,%.6f,%.6f,%.6f\n", i / 10, 0.9 * z, z, 1.1 * z}}' >scans.csv
works "a surface from scans" roughness scans.csv --surface scanned.yaml --index Al --quiet
works "its bounds" predict scanned.yaml --theta-i 30 --json
check "the spread travels with the surface" json "abs(d['sigma0_um']['high'] / d['sigma0_um']['value'] - 1.1) < 1e-4 \
  and abs(d['sigma0_um']['low'] / d['sigma0_um']['value'] - 0.9) < 1e-4"

# ---- measured points ---------------------------------------------------------------------------

# A measurement of a surface whose sigma0 is within the bounds, with a value too many above.
awk 'BEGIN {
  print "lambda_um,theta_i_deg,theta_r_deg,phi_deg,sigma0_um"
  for (i = 20; i <= 40; i += 20)
    for (r = 10; r <= 70; r += 10)
      for (p = 0; p <= 180; p += 90) print "0.55," i "," r "," p ",0.51"
}' | "$program" eval s.yml >measured.csv
works "measured points" predict s.yml --measurements measured.csv --json
check "all of the model's points lie within" json "d['measured']['hemisphere']['points'] == 42 and \
  d['measured']['hemisphere']['fraction_within'] == 1 and d['measured']['plane']['points'] == 28"
check "incidences are those measured" json "[c['theta_i_deg'] for c in d['curves']] == [20, 40]"
sed '2,$s/,0.51,\(.*\),\([^,]*\),\([^,]*\),\([^,]*\)$/,0.51,\1,9,\3,\4/' measured.csv >high.csv
works "points above" predict s.yml --measurements high.csv
check "points above are counted" has 'hemisphere: 42 points, 0 \(0.0 %\) within the bounds, 0 below, 42 above'
works "formats" predict s.yml --measurements "$data/synthetic.astm" --theta-i 45 --html p.html --csv p.csv
check "a page" grep -q '<h2>550 nm</h2>' p.html
check "its dots" test "$(grep -o '<circle' p.html | wc -l)" -ge 5
check "rows of points" test "$(awk -F, '$9 != ""' p.csv | wc -l)" = 11
works "a table as a measurement" tabulate s.yml -o s.h5 --theta-i 0:80:5 --theta-r 0:85:18 --phi 0:180:7 --wavelengths 550 --quiet
works "predict against a table" predict s.yml --measurements s.h5 --json
check "a table of the surface lies within its bounds" json "d['measured']['hemisphere']['points'] > 300 and \
  d['measured']['hemisphere']['fraction_within'] == 1"
works "a paint" predict s.yml --measurements "$data/paint.brdf" --json
check "all of a paint's points" json "d['measured']['hemisphere']['points'] == 320"

# ---- the page of a fit -------------------------------------------------------------------------

works "fit --html" fit "$data/synthetic.brdf" --index n=1.5 --tau 5 --html fit.html --quiet
check "a section per wavelength" test "$(grep -c '<section><h2>' fit.html)" = 3
check "measured points are drawn" test "$(grep -o '<circle cx' fit.html | wc -l)" -gt 60
check "hemispheres side by side" test "$(grep -o 'caption>[0-9.]*° fit, ' fit.html | wc -l)" = 9
check "it is XML inside" /usr/bin/python3 -c 'import re, xml.dom.minidom as d
for s in re.findall(r"<figure>.*?</figure>", open("fit.html").read(), re.S): d.parseString(s)'
refuses "fit: existing page" 1 "exists" fit "$data/synthetic.brdf" --index n=1.5 --tau 5 --html fit.html

# ---- mistakes ----------------------------------------------------------------------------------

refuses "no surface" 2 "no SURFACE" predict
refuses "two surfaces" 2 "unexpected argument" predict a b
refuses "unknown surface" 1 "no preset 'Unobtainium'" predict Unobtainium
refuses "no interval" 2 "'0.5' is no interval" predict s.yml --sigma0 0.5
refuses "interval backwards" 2 "no interval" predict s.yml --tau 6:4
refuses "two bounds" 2 "keep one" predict s.yml --sigma0 0.4:0.6 --non-uniformity 0.1
refuses "non-uniformity of 1" 2 "outside" predict s.yml --non-uniformity 1
refuses "value outside its bounds" 1 "not within 0.6 to 0.7" predict s.yml --sigma0 0.6:0.7
refuses "grazing incidence" 1 "90 degrees is out of range" predict s.yml --theta-i 90
refuses "no such file" 1 "missing.brdf: cannot open" predict s.yml --measurements missing.brdf
echo "1 2" >bad.brdf
refuses "malformed file" 1 "bad.brdf:1" predict s.yml --measurements bad.brdf
refuses "no common incidence" 1 "no measurement at any" predict s.yml --measurements measured.csv --theta-i 55
refuses "existing file" 1 "exists: use --force" predict s.yml --csv c.csv
works "overwriting" predict s.yml --csv c.csv --force --quiet
refuses "one file for two" 2 "both write" predict s.yml --csv x --html x
refuses "output over input" 1 "is an output too" predict s.yml --measurements measured.csv --csv measured.csv --force
refuses "no folder" 1 "nowhere" predict s.yml --html nowhere/x.html

summary
