#!/bin/bash
# Tests the program as its users meet it: every command, every bad input, pipes and terminals,
# interruption and full disks. Prints a line per failed or skipped check, then the counts.
# usage: test_cli.sh PROGRAM
. "$(dirname "$0")/cli_support.sh"

small="--theta-i 0:90:7 --theta-r 0:90:7 --phi 0:180:7 --wavelengths 550"

# ---- help and mistakes -------------------------------------------------------------------------

works "help" --help
check "help lists commands" has '^  tabulate '
works "version" --version
check "version names the program" has '^hetab [0-9]+\.[0-9]+\.[0-9]+$'
for command in tabulate eval devices surfaces bench reflectance audit roughness fit predict \
  convert view; do
  works "$command --help" $command --help
  check "$command --help has usage" has "^Usage: hetab $command "
  check "$command --help fits 80 columns" test "$(wc -L <out)" -le 80
  refuses "$command: unknown option" 2 "unknown.*'--nonsense'. Try 'hetab $command --help'" \
    $command --nonsense
done

refuses "no command" 2 "no command given. Try 'hetab --help'"
refuses "unknown command" 2 "unknown command 'frob'" frob
refuses "unknown letter" 2 "unknown option '-x'" tabulate -x
refuses "missing argument" 2 "'--device' needs an argument" eval --device
refuses "argument to a flag" 2 "'--quiet' takes no argument" tabulate --quiet=yes
refuses "bad choice" 2 "'half' is none of float\|double" eval --precision half
refuses "bad number" 2 "'many' is not a number" tabulate --samples many
refuses "number out of range" 2 "outside 0 to 9" tabulate --compress 10
refuses "fraction for a count" 2 "not a whole number" tabulate --samples 1.5
refuses "negative tolerance" 2 "tolerance" tabulate BBQAL2 -o a.h5 --tolerance -1
printf 'sigma0_um: 300\ntau_um: 4000\nindex: Cu\nwavelengths_nm: 550\n' >nm.yml
works "nanometres for um" tabulate nm.yml -o nm.h5 --theta-i 0:60:3 --theta-r 0:60:3 --phi 0:180:3 --samples 0
check "are suspected" has 'sigma0_um is 300.*nanometres'
refuses "a per cent for a share" 2 'outside .* 1 per cent is 0.01 or 1%' tabulate BBQAL2 -o a.bsdf --table-error 1
refuses "a table of terabytes" 1 'it needs 2.24e\+05 GB: ask for less \(fewer angles' \
  tabulate BBQAL2 -o a.h5 --theta-i 0:90:100000 --theta-r 0:90:100000
refuses "nan tolerance" 2 "tolerance" tabulate BBQAL2 -o a.h5 --tolerance nan
refuses "no surface" 2 "no SURFACE" tabulate -o a.h5
refuses "no output" 2 "no output" tabulate BBQAL2
refuses "two surfaces" 2 "unexpected argument 'b'" tabulate a b -o a.h5
refuses "devices with an argument" 2 "unexpected" devices x

"$program" --help >/dev/full 2>err
one_line "full standard output" $? 1 "standard output: No space left"
"$program" shader --language glsl >/dev/full 2>err
one_line "of more than a buffer" $? 1 "standard output: No space left"
"$program" --help >&- 2>err
one_line "closed standard output" $? 1 "standard output"

# ---- devices and surfaces ----------------------------------------------------------------------

works "devices" devices
works "devices --json" devices --json
check "devices as JSON" json "d[0]['number'] == 0 and d[0]['name'] and d[0]['compute_units'] > 0"
mkdir no-vendors
OCL_ICD_VENDORS=$work/no-vendors/ "$program" devices >out 2>err
one_line "no device" $? 1 "pocl-opencl-icd"
OCL_ICD_VENDORS=$work/no-vendors/ "$program" tabulate BBQAL2 -o none.h5 >out 2>err
one_line "tabulate without a device" $? 1 "pocl-opencl-icd"
echo libnothing.so.9 >no-vendors/gone.icd
OCL_ICD_VENDORS=$work/no-vendors/gone.icd "$program" devices >out 2>err
one_line "a driver without its library" $? 1 "no-vendors/gone.icd' is there but does not start: libnothing.so.9"
rm no-vendors/gone.icd
POCL_CACHE_DIR=/proc/nowhere "$program" devices >out 2>err
status=$?
if [ $status = 0 ]; then
  skip "a driver without its cache folder: the first is not PoCL"
else
  one_line "a driver without its cache folder" $status 1 "a driver is there but offers none: .*POCL_CACHE_DIR"
fi
if [ -n "${ASAN_OPTIONS:-}" ]; then
  skip "a driver in little memory: AddressSanitizer takes terabytes of addresses"
else
  (ulimit -v 150000 && "$program" tabulate BBQAL2 -o none.h5 >out 2>err)
  one_line "a driver in little memory" $? 1 "is there but does not start: .*ulimit -v"
  for kb in 450000 600000; do # of 810,000
    (ulimit -v $kb && XDG_CACHE_HOME=$work/none$kb POCL_CACHE_DIR=$work/cold$kb \
      "$program" reflectance BBQAL2 --theta-i 0 >out 2>err)
    one_line "a compiler in $kb kB" $? 1 "compiling kernels takes .*ulimit -v"
  done
fi
export OCL_ICD_VENDORS=$work/no-vendors/
works "literal needs no device" tabulate BBQAL2 $small -o hostonly.h5 --method literal
unset OCL_ICD_VENDORS
refuses "unknown device" 1 "." tabulate BBQAL2 -o none.h5 --device 99
refuses "unknown device name" 1 "quantum" eval --device quantum
check "nothing written without a device" test ! -e none.h5

works "surfaces" surfaces
check "surfaces lists presets" has '^  BBQAL1 '
check "surfaces lists metals" has '^  Au '
works "surfaces --json" surfaces --json
check "surfaces as JSON" json "len(d['presets']) >= 5 and len(d['metals']) >= 10"
refuses "unknown surface" 1 "no preset or metal 'Unobtainium'" surfaces Unobtainium
works "preset as YAML" surfaces BBQAL2
cp out mine.yml
works "preset as JSON" surfaces BBQAL2 --json
check "bands as JSON" json "len(d['bands']) == 31 and d['sigma0_um'] > 0"
works "metal as CSV" surfaces Au
cp out Au.csv
check "metal has 31 values" test "$(wc -l <Au.csv)" = 32
works "metal as JSON" surfaces Au --json
check "metal values as JSON" json "len(d['values']) == 31 and d['citation']"

# ---- tabulate ----------------------------------------------------------------------------------

works "tabulate" tabulate BBQAL2 $small -o a.h5 -o b.hdf5
check "both files" test -s a.h5 -a -s b.hdf5
check "the same data" h5diff a.h5 b.hdf5
check "summary has the table" has '^a\.h5 +343 '
check "summary tells of the specular term" has 'a.h5: specular reflectance.*specular_reflectance'
works "the printed YAML" tabulate mine.yml $small -o mine.h5 --quiet
check "quiet" test ! -s out
check "the YAML is the preset" h5diff a.h5 mine.h5 /brdf
works "json" tabulate BBQAL2 $small -o a.h5 --force --json
check "json keys" json "d['surface'] and d['device'] and d['method'] == 'rows' and \
d['outputs'][0]['format'] == 'hdf5' and d['outputs'][0]['entries'] == 343 and \
d['outputs'][0]['error']['max_sampled'] < 1e-4 and d['outputs'][0]['error']['bad'] == 0"
works "no samples" tabulate BBQAL2 $small -o a.h5 --force --json --samples 0
check "no samples, no error" json "d['outputs'][0]['error'] is None"
for method in series literal; do
  works "method $method" tabulate BBQAL2 $small -o $method.h5 --method $method
  check "$method agrees" h5diff -p 1e-4 a.h5 $method.h5 /brdf
done
works "double" tabulate BBQAL2 $small -o double.h5 --precision double --compress 5
check "double elements" grep -q H5T_IEEE_F64LE <(h5dump -H -d /brdf double.h5)
works "double arithmetic, float file" tabulate BBQAL2 $small -o mixed.h5 --precision double \
  --element float
rounded='
import h5py, sys
error = [h5py.File(f + ".h5").attrs for f in ("double", "mixed")]
sys.exit(not (error[0]["error_max_sampled"] < 1e-8 and 6e-8 <= error[1]["error_max_sampled"] < 7e-8 and
              0 < error[1]["error_compared"] <= error[1]["error_samples"]))'
check "the stored error is the file's" /usr/bin/python3 -c "$rounded"
check "float elements" grep -q H5T_IEEE_F32LE <(h5dump -H -d /brdf mixed.h5)

printf 'sigma0_um: 0.05\ntau_um: 60\nindex: {n: 0.7, k: 0}\nwavelengths_nm: 550\n' >needle.yml
works "a needle inside glass" tabulate needle.yml -o needle.h5
check "few entries to compare are said to be few" has 'needle.h5: warning: only [0-9] of the 2000 entries .* 1e-9 / sr'
check "total reflection takes double" has '^needle on .* double$'

works "merl" tabulate BBQAL2 -o m.binary --samples 200
check "merl size" test "$(stat -c %s m.binary)" = 34992012
check "specular beside it" test "$(wc -l <m.specular.csv)" = $((31 * 91 + 1))
check "specular header" grep -qx 'wavelength_nm,theta_i_deg,rho_s' m.specular.csv
check "summary tells of the omission" has 'm.binary: specular reflectance, at most 0\.[0-9]+, 0\.[0-9]+ % of the light, is in m.specular.csv'
works "merl mono with a cone" tabulate BBQAL2 -o mono.binary --merl-colour mono --bands 550 \
  --specular-cone 2 --samples 200 --json
check "cone in json" json "d['outputs'][0]['specular']['in_table'] is True and \
d['outputs'][0]['specular']['file'] == 'mono.binary' and 'clamped' in d['outputs'][0]"
check "a folded delta has no csv" [ ! -e mono.specular.csv ]
printf 'sigma0_um: 0.03\ntau_um: 3\nindex: Cu\nwavelengths_nm: 400:700:10\n' >smooth.yml
works "a folded delta as it is read" tabulate smooth.yml -o sc.binary --specular-cone 2 --samples 0
check "incidence by incidence" has 'truncating readers see it: 0\.999, .* 1\.04[0-9] of rho_s at 0, 30, .* 88 degrees'
check "and the remedy" has 'warning: that reflects more light than falls in: take a wider --specular-cone'
works "a wider cone" tabulate smooth.yml -o sc.binary --specular-cone 5 --samples 0 --force
check "needs no warning" eval "has 'truncating readers see it: 1\.000, ' && ! has warning"
works "the same as JSON" tabulate smooth.yml -o sc.binary --specular-cone 2 --samples 0 --force --json
check "the delta as read" json "(lambda r: r['theta_i_deg'][-1] == 88 and 1.03 < r['read'][-1] / r['rho_s'][-1] < 1.06)(
 d['outputs'][0]['delta_as_read'])"
refuses "colour of one wavelength" 1 'not 550 nm alone; set .*--merl-colour mono --bands 550; .bsdf: --for pbrt' \
  tabulate smooth.yml -o x.binary --wavelengths 550
refuses "colour of invisible ones" 1 'not 905 to 1550 nm in steps of up to 645 nm; ask for' \
  tabulate smooth.yml -o x.binary --wavelengths 905,1550

mkdir linked elsewhere
echo old >elsewhere/s.csv
chmod 640 elsewhere/s.csv
ln -s ../elsewhere/s.csv linked/l.specular.csv
works "merl through a link" tabulate BBQAL2 -o linked/l.binary --samples 0 --quiet --force
check "the linked sidecar" test -L linked/l.specular.csv -a "$(wc -l <elsewhere/s.csv)" = $((31 * 91 + 1))
check "its permissions" test "$(stat -c %a elsewhere/s.csv)" = 640

# ---- refused outputs: nothing computed, nothing harmed -----------------------------------------

echo precious >old.h5
echo precious >old.binary
echo precious >lone.specular.csv
mkdir folder.h5 locked
refuses "existing h5" 1 "old.h5 exists.*--force" tabulate BBQAL2 -o old.h5
refuses "existing second output" 1 "old.binary exists" tabulate BBQAL2 -o new.h5 -o old.binary
refuses "existing specular file" 1 "lone.specular.csv exists" tabulate BBQAL2 -o lone.binary
works "the same beside another format" tabulate BBQAL2 -o pair.bsdf --quiet
works "its specular file serves both" tabulate BBQAL2 -o pair.binary --samples 0 --quiet
refuses "an option of no output" 2 "--theta-i is for .h5 and .exr outputs" tabulate BBQAL2 -o o.bsdf --theta-i 0
refuses "unknown extension" 2 "a.png: .*\.h5, \.hdf5, \.exr, \.binary or \.bsdf" tabulate BBQAL2 -o a.png
refuses "only an extension" 2 "ends in" tabulate BBQAL2 -o .h5
refuses "same output twice" 2 "twice" tabulate BBQAL2 -o n.h5 -o ./n.h5
refuses "one sidecar of two" 2 "would both write ./q.specular.csv" tabulate BBQAL2 -o q.binary \
  -o ./q.BINARY
touch target.binary; ln -s target.binary link.binary
refuses "a link and its target" 2 "twice" tabulate BBQAL2 -o link.binary -o target.binary
rm link.binary target.binary
refuses "missing directory" 1 "no directory .nowhere.; create it first" tabulate BBQAL2 -o nowhere/a.h5
refuses "a file as directory" 1 "not a directory|Not a directory" tabulate BBQAL2 -o old.h5/a.h5
refuses "a directory as output" 1 "folder.h5.*is a directory; name a file" tabulate BBQAL2 -o folder.h5 --force
refuses "line break in a name" 2 "a\?b.png" tabulate BBQAL2 -o $'a\nb.png'
chmod 500 locked
if [ "$(id -u)" != 0 ]; then
  refuses "unwritable directory" 1 "locked" tabulate BBQAL2 -o locked/a.h5
elif command -v setpriv >/dev/null && chmod 755 "$work" && [ -x "$program" ] &&
  setpriv --reuid 65534 --clear-groups test -x "$program"; then
  setpriv --reuid 65534 --clear-groups "$program" tabulate BBQAL2 -o locked/a.h5 >out 2>err
  one_line "unwritable directory" $? 1 "locked"
else
  skip "unwritable directory: root may write everywhere"
fi
refuses "bands missing" 2 "mono takes one wavelength" tabulate BBQAL2 -o n.binary --merl-colour mono
refuses "bands too many" 2 "srgb takes no --bands" tabulate BBQAL2 -o n.binary --bands 550
refuses "bands malformed" 2 "not one or three" tabulate BBQAL2 -o n.binary --merl-colour bands \
  --bands 600,,450
check "old files as they were" test "$(cat old.h5 old.binary lone.specular.csv)" = \
  $'precious\nprecious\nprecious'
check "nothing new" test ! -e new.h5 -a ! -e n.h5 -a ! -e n.binary -a ! -e lone.binary

# ---- refused inputs ----------------------------------------------------------------------------

refuses "unknown preset" 1 "NOSUCH" tabulate NOSUCH -o n.h5
refuses "missing surface file" 1 "nosuch.yml" tabulate nosuch.yml -o n.h5
printf 'name: x\nsigma0_um: -1\ntau_um: 3\nindex: Al\n' >bad.yml
refuses "negative roughness" 1 "bad.yml:2.*sigma0_um" tabulate bad.yml -o n.h5
printf 'name: x\nsigma0_um: 1\ntau_um: 3\nindex: Al\nroughness: 2\n' >bad.yml
refuses "unknown key" 1 "bad.yml:5.*roughness" tabulate bad.yml -o n.h5
printf 'name: [x\nsigma0_um: 1\n' >bad.yml
refuses "malformed YAML" 1 "bad.yml" tabulate bad.yml -o n.h5
refuses "wavelengths outside" 1 "103\.32" tabulate BBQAL2 -o n.h5 --wavelengths 90
refuses "malformed wavelengths" 1 "400:700" tabulate BBQAL2 -o n.h5 --wavelengths 400:700
refuses "malformed axis" 1 "91" tabulate BBQAL2 -o n.h5 --theta-i 0,91
refuses "bad phi" 1 "." tabulate BBQAL2 -o n.h5 --phi 10:5:3
refuses "sRGB without the bands" 1 "400" tabulate BBQAL2 -o n.binary --wavelengths 550
check "nothing from bad input" test ! -e n.h5 -a ! -e n.binary -a ! -e n.specular.csv
printf 'name: gold\nsigma0_um: 0.2\ntau_um: 3\nindex: {file: Au.csv}\n' >gold.yml
works "a printed metal as index file" tabulate gold.yml $small -o gold.h5

# ---- eval --------------------------------------------------------------------------------------

header=lambda_um,theta_i_deg,theta_r_deg,phi_deg
points() { printf '%s\n' "$header" 0.55,0,0,0 0.55,30,30,180 0.6,60,45,180 0.55,89.9,10,33 0.55,90,20,0; }
points >in
"$program" eval BBQAL2 <in >values.csv 2>err
check "eval" test $? = 0 -a ! -s err
check "eval header" test "$(head -1 values.csv)" = "$header,dd,sp_reflectance,ud,total,g,x"
check "input unchanged" cmp -s <(cut -d, -f1-4 values.csv) in
"$program" eval BBQAL2 --method literal <in >literal.csv
close='
import csv, sys
a, b = (list(csv.DictReader(open(f))) for f in sys.argv[1:3])
near = lambda x, y: abs(x - y) <= float(sys.argv[3]) * abs(y) + 1e-14
ok = len(a) == len(b) > 0 and all(near(float(p[c]), float(q[c])) for p, q in zip(a, b)
                                  for c in ("dd", "sp_reflectance", "ud", "total", "g", "x"))
sys.exit(not ok)'
agree() { /usr/bin/python3 -c "$close" "$@"; }
check "eval float near literal" agree values.csv literal.csv 1e-5
"$program" eval BBQAL2 --precision double <in >double.csv
check "eval double near literal" agree double.csv literal.csv 1e-10
{ printf '\357\273\277'; sed 's/$/\r/' in; } | "$program" eval BBQAL2 >crlf.csv
check "CRLF and byte order mark" cmp -s values.csv crlf.csv
printf 'note,"phi_deg",theta_r_deg, theta_i_deg ,lambda_um\n"a, ""b""","0",0, 0 ,0.55\n\nc,180,30,30,5.5e-1\n' |
  "$program" eval BBQAL2 >quoted.csv
check "quotes and order" cmp -s <(cut -d, -f6- quoted.csv | tail -n1) \
  <(sed -n 3p values.csv | cut -d, -f5-)
check "quoted text passes through" grep -q '^"a, ""b""","0",0, 0 ,0.55,' quoted.csv
{ echo "$header,sigma0_um,tau_um,n,k"; echo 0.55,30,30,180,0.54,6.5,0.958,6.69; } |
  "$program" eval >rows.csv
check "material per row" test "$(wc -l <rows.csv)" = 2
yes 0.55,30,30,180 | head -200000 | sed "1i $header" | "$program" eval BBQAL2 >many.csv
check "many rows" test "$(wc -l <many.csv)" = 200001 -a "$(tail -n +2 many.csv | sort -u | wc -l)" = 1
yes 0.55,30,30,180 | sed "1i $header" | "$program" eval BBQAL2 2>err | head -2 >/dev/null
statuses=("${PIPESTATUS[@]}")
check "reader gone: quiet, not 0" test "${statuses[2]}" != 0 -a ! -s err
(
  trap '' PIPE
  { yes 0.55,30,30,180 | head -100000 | sed "1i $header"; } 2>/dev/null | {
    "$program" eval BBQAL2 2>err
    echo $? >status
  } | head -2 >/dev/null
)
check "reader gone, SIGPIPE ignored: quiet, 1" test "$(cat status)" = 1 -a ! -s err
"$program" eval BBQAL2 <in >/dev/full 2>err
one_line "eval to a full disk" $? 1 "standard output"

write_grid='
import h5py
with h5py.File("series.h5") as t, open("grid.csv", "w") as f:
    f.write("lambda_um,theta_i_deg,theta_r_deg,phi_deg\n")
    for i in t["theta_i"]:
        for r in t["theta_r"]:
            for p in t["phi"]:
                f.write(f"0.55,{i!r},{r!r},{p!r}\n")
'
/usr/bin/python3 -c "$write_grid"
"$program" eval BBQAL2 <grid.csv >grid.out.csv
compare='
import csv, sys, h5py, numpy as np
table = h5py.File("series.h5")["brdf"][:].ravel()
total = np.array([float(r["total"]) for r in csv.DictReader(open("grid.out.csv"))])
sys.exit(not np.all(np.abs(table - total) <= 2e-5 * np.abs(total) + 1e-14))
'
same_as_table() { /usr/bin/python3 -c "$compare"; }
check "eval gives what the table holds" same_as_table

bad_row() { # NAME PATTERN ROW
  { echo "$header"; echo 0.55,1,2,3; echo "$3"; } >in
  refuses_after_header "$1" "$2"
}
refuses_after_header() {
  "$program" eval BBQAL2 <in >out 2>err
  one_line "$1" $? 1 "$2"
}
bad_row "row: text" "stdin:3: column 'theta_r_deg': 'abc' is not a number" 0.55,1,abc,3
bad_row "row: empty field" "stdin:3: column 'phi_deg': ''" 0.55,1,2,
bad_row "row: nan" "stdin:3: column 'lambda_um'" nan,1,2,3
bad_row "row: infinite" "stdin:3: column 'phi_deg'" 0.55,1,2,inf
bad_row "row: below the horizon" "stdin:3: column 'theta_i_deg': 91 is out of range: give a value from 0 to 90" 0.55,91,2,3
bad_row "row: negative wavelength" "stdin:3: column 'lambda_um': -1 is out of range: give a value from 1e-06" -1,1,2,3
bad_row "row: huge azimuth" "stdin:3: column 'phi_deg': 1e300 is out of range" 0.55,1,2,1e300
bad_row "row: outside the index data" "stdin:3: .*103\.32" 0.09,1,2,3
bad_row "row: too short" "stdin:3: 3 fields where the header names 4: add the missing value or remove the column" 0.55,1,2
bad_row "row: too long" "stdin:3: 5 fields.*: remove the value" 0.55,1,2,3,4
printf '%s,sigma0_um,tau_um,n,k\n0.1,1,2,3,4e5,1e5,1,6\n' "$header" | "$program" eval >out 2>err
one_line "row: too rough" $? 1 "stdin:2: sigma0 / lambda = 4e\+06: give a value from 1e-09 to 3e\+06"
# the library's limit, not a narrower one of this command
printf '%s,sigma0_um,tau_um,n,k\n0.1,1,2,3,1e4,1e6,1,6\n' "$header" | "$program" eval >out
check "row: as rough as the library goes" test "$(wc -l <out)" = 2
bad_row "row: open quote" "stdin:3: .*quote" '"0.55,1,2,3'
check "rows before a bad one are answered" test "$(wc -l <out)" = 2
printf '%s\n0.9,1,2,3\n' "$header" >in
"$program" eval BBQAL2 --extrapolate <in >out 2>err
check "extrapolation by name" test $? = 0
: >in
refuses "eval: no input" 1 "no input" eval BBQAL2
echo lambda_um,theta_i_deg,phi_deg >in
refuses "header: column missing" 1 "stdin:1: no column 'theta_r_deg'" eval BBQAL2
echo "$header" >in
refuses "header: no material" 1 "no column 'sigma0_um', and no SURFACE" eval
echo "$header,phi_deg" >in
refuses "header: twice" 1 "'phi_deg' is there twice" eval BBQAL2
echo "$header,n" >in
refuses "header: n without k" 1 "belong together" eval BBQAL2
echo "$header,total" >in
refuses "header: an output column" 1 "'total'.*rename" eval BBQAL2
printf '%s\n0.55,1,2,\0003\n' "$header" >in
refuses_after_header "binary input" "stdin:2: .*NUL"
{ echo "$header"; head -c 70000 /dev/zero | tr '\0' 1; } >in
refuses_after_header "endless line" "stdin:2: .*longer"
"$program" eval BBQAL2 <folder.h5 >out 2>err
one_line "a directory as input" $? 1 "stdin: Is a directory"
: >in

# ---- bench -------------------------------------------------------------------------------------

works "bench" bench smooth --samples 200 --repeats 1 --csv bench.csv
check "bench table" has '^smooth +rows +float'
check "bench header" test "$(head -1 bench.csv)" = "surface,method,precision,tolerance,\
entries_per_s,ratio_literal,ratio_store,operations,ratio_peak,max_rel,p99_rel,rms_rel,samples,device,version"
check "bench baselines" test "$(grep -Ec '^smooth,(literal|store),' bench.csv)" -ge 2
refuses "bench: existing file" 1 "bench.csv exists" bench smooth --csv bench.csv
refuses "bench: unknown surface" 1 "NOSUCH" bench NOSUCH

# ---- reflectance -------------------------------------------------------------------------------

works "reflectance" reflectance BBQAL2 --theta-i 0,45,90 --wavelength 500:600:50
check "reflectance header" test "$(head -1 out)" = \
  "wavelength_nm,theta_i_deg,rho_dd,rho_s,rho_ud,rho_dh,error,fresnel"
check "reflectance rows" test "$(wc -l <out)" = 10
check "nothing at 90 degrees" has '^550,90,0,0,0,0,0,1$'
works "reflectance by default" reflectance NGGAL
check "18 incidences of 31 wavelengths" test "$(wc -l <out)" = $((18 * 31 + 1))
cp out reflectance.csv
sums_up() {
  /usr/bin/python3 -c '
import csv, sys
rows = [{k: float(v) for k, v in r.items()} for r in csv.DictReader(open("reflectance.csv"))]
sys.exit(not all(abs(r["rho_dd"] + r["rho_s"] + r["rho_ud"] - r["rho_dh"]) < 1e-8
                 and 0 < r["error"] < 1.1e-5 and 0 < r["rho_dh"] < 1.1 for r in rows))'
}
check "the parts make the sum" sums_up
works "reflectance in double" reflectance NGGAL --theta-i 30 --wavelength 550 --precision double \
  --tolerance 1e-6% --json
check "reflectance as JSON" json "d['precision'] == 'double' and len(d['reflectances']) == 1 and \
d['reflectances'][0]['stop'] == 'tolerance' and d['reflectances'][0]['evaluations'] > 0 and \
0 < d['reflectances'][0]['error'] < 1e-8 and d['reflectances'][0]['theta_i_deg'] == 30"
works "white sky" reflectance NGGAL --white-sky --wavelength 550
check "white-sky header" has '^wavelength_nm,rho_dd,rho_s,rho_ud,rho_hh,error,fresnel$'
check "white-sky row" test "$(wc -l <out)" = 2
works "reflectance in colour" reflectance NGGAL --rgb --theta-i 0,60
check "colour header" has '^theta_i_deg,red,green,blue,luminance,error,fresnel_red,'
works "colour as JSON" reflectance NGGAL --rgb --theta-i 0 --json
check "colour keys" json "len(d['reflectances'][0]['rgb']) == 3 and \
0 < d['reflectances'][0]['luminance'] <= d['reflectances'][0]['fresnel_luminance'] + 1e-4"
if /usr/bin/python3 -c 'import matplotlib' 2>/dev/null; then
  plots() { "$scripts/plot_reflectance" reflectance.png <reflectance.csv && [ -s reflectance.png ]; }
  check "plot" plots
else
  skip "plot: no matplotlib"
fi
refuses "reflectance: no surface" 2 "no SURFACE" reflectance
refuses "reflectance: two surfaces" 2 "unexpected argument 'b'" reflectance a b
refuses "reflectance: below the horizon" 1 "91.*0 to 90" reflectance NGGAL --theta-i 91
refuses "reflectance: not a number" 1 "theta_i" reflectance NGGAL --theta-i nan
refuses "reflectance: outside the index data" 1 "103\.32" reflectance NGGAL --wavelength 90
refuses "reflectance: zero tolerance" 2 "tolerance" reflectance NGGAL --tolerance 0
refuses "reflectance: colour of one band" 1 "400" reflectance NGGAL --rgb --wavelength 550
"$program" reflectance NGGAL >/dev/full 2>err
one_line "reflectance to a full disk" $? 1 "standard output"

# ---- audit -------------------------------------------------------------------------------------

# audits NAME STATUS ARGUMENT...: hetab audit ends with the status and says nothing on standard error.
audits() {
  local name=$1 expected=$2 status
  shift 2
  "$program" audit "$@" >out 2>err </dev/null
  status=$?
  if [ $status = "$expected" ] && [ ! -s err ]; then
    pass
  else
    fail "$name: status $status instead of $expected, $(head -c 300 err)"
  fi
}

mkdir judged
coarse="--theta-i 0:90:31 --theta-r 0:90:31 --phi 0:180:37 --wavelengths 500,600"
works "audit: a table" tabulate BBQAL1 $coarse -o judged/t.h5 --quiet
works "audit: a MERL table" tabulate BBQAL1 -o judged/t.binary --quiet --samples 0
audits "audit: a surface" 0 BBQAL1
check "audit: verdict lines" has '^  (PASS|WARN) +energy +0\.'
check "audit: fits 80 columns" test "$(wc -L <out)" -le 80
audits "audit: surface as JSON" 0 BBQAL1 --json
check "audit: surface keys" json "d['verdict'] in ('PASS', 'WARN') and d['summary']['fail'] == 0 and \
d['repair'] is None and d['results'][0]['kind'] == 'surface' and \
len(d['results'][0]['theta_i_deg']) == 90 and len(d['results'][0]['channels']) == 31 and \
{'wavelength_nm', 'rho_dh', 'error', 'rho_dd', 'rho_s', 'rho_ud', 'fresnel', 'max_a_brdf', \
'max_a_reflectance', 'max_a_fresnel', 'rho_dh_if_brdf', 'rho_dh_if_reflectance', 'specular_share', \
'grazing', 'min', 'max', 'a', 'a_unit'} <= set(d['results'][0]['channels'][0]) and \
[c['name'] for c in d['results'][0]['checks']] == ['energy', 'fresnel', 'negative', 'reciprocity', \
'specular', 'grazing', 'diffuse']"
audits "audit: tables against the model" 0 judged/t.h5 judged/t.binary --against BBQAL1 \
  --pairs 20000 --json
check "audit: table keys" json "[r['kind'] for r in d['results']] == ['hdf5', 'merl'] and \
[r['lookup'] for r in d['results']] == ['interpolate', 'truncate'] and \
d['results'][1]['bytes'] == 34992012 and d['results'][1]['dimensions'] == [3, 90, 90, 180] and \
all(r['against']['all']['relative_l1'] < 0.25 and len(r['against']['by_theta_i']) == 9 and \
'share_in_table' in r['against']['specular'] for r in d['results']) and \
d['results'][0]['reciprocity']['max_rel'] < 1e-3 and d['results'][0]['cells']['nan'] == 0"
check "audit: check keys" json "all(set(c) == {'name', 'verdict', 'value', 'error', 'threshold', \
'detail'} for r in d['results'] for c in r['checks'])"
audits "audit: several inputs" 0 BBQAL1 judged/t.h5 judged/t.binary --no-reference
check "audit: summary" has '^3 inputs: [0-9] pass, [0-9] warn, 0 fail: '
audits "audit: quiet" 0 judged/t.binary --quiet
check "audit: quiet says nothing" test ! -s out
audits "audit: threshold" 3 judged/t.h5 --max-error 1e-9 --pairs 1000
check "audit: the failed check" has '^  FAIL table_error'
works "audit: an RGL table" tabulate BBQAL2 -o judged/b.bsdf --quiet
"$program" reflectance BBQAL2 --rgb --theta-i 0:89:90 --json >judged/rgb.json 2>err
audits "audit: an RGL table against the model" 0 judged/b.bsdf --against BBQAL2 --pairs 20000 --json \
  --html judged/b.html
check "audit: its energy is that of the surface" json "
(lambda r, rho: r['kind'] == 'rgl' and r['lookup'] == 'interpolate' and r['dimensions'] == [3] and
 r['against']['all']['relative_l1'] < 0.01 and r['against']['specular']['share_in_table'] > 0.99 and
 all(abs(ch['rho_dh'][t] / row['rgb'][c] - 1) < (0.0033 if t <= 80 else 0.1) + ch['error'][t] and
     ch['error'][t] < 2e-3
     for t, row in enumerate(rho) for c, ch in enumerate(r['channels'])))(
 d['results'][0], __import__('json').load(open('judged/rgb.json'))['reflectances'])"
check "audit: its page has lobes" grep -q 'Lobes in the plane of incidence' judged/b.html
printf 'sigma0_um: 0.03\ntau_um: 3\nindex: Fe\nwavelengths_nm: 400:700:10\n' >judged/steel.yml
works "audit: folded tables" tabulate judged/steel.yml -o judged/f.bsdf -o judged/f.binary --specular-cone 2 -q
"$program" reflectance judged/steel.yml --rgb --theta-i 0:89:90 --json >judged/rgb.json 2>err
audits "audit: a folded delta is no table error" 0 judged/f.bsdf judged/f.binary --against judged/steel.yml \
  --pairs 20000 --json
check "audit: its energy is in the table" json "
all(r['against']['specular']['share_in_table'] > 0.98 and not r['against']['specular']['beside_table'] and
    'in the table as a lobe' in str(r['checks']) for r in d['results']) and
all(abs(ch['rho_dh'][t] / row['rgb'][c] - 1) < 0.01 + ch['error'][t] for t, row in
    enumerate(__import__('json').load(open('judged/rgb.json'))['reflectances']) if t <= 85
    for c, ch in enumerate(d['results'][0]['channels']))"
mkdir no-opencl
export OCL_ICD_VENDORS=$work/no-opencl/
audits "audit: no device for a table alone" 0 judged/t.h5 --no-reference
audits "audit: nor for an RGL table" 0 judged/b.bsdf
unset OCL_ICD_VENDORS

cp judged/t.binary judged/broken.binary
printf '\0\0\0\0\0\0\370\177' | dd of=judged/broken.binary bs=1 seek=$((12 + 8 * 5000000 / 8)) \
  conv=notrunc status=none
audits "audit: a NaN" 3 judged/broken.binary
check "audit: the NaN is located" has 'FAIL finite +1 1 NaN and 0 infinite'
head -c 1000000 judged/t.binary >judged/short.binary
refuses "audit: truncated" 1 "'judged/short.binary' has 1000000 bytes" audit judged/short.binary
cp judged/broken.binary judged/before.binary
audits "audit: repair" 0 judged/broken.binary --repair judged/mended.binary --scale-energy
check "audit: repair reports" has 'mended.binary: repaired: of [0-9]+ entries 1 replaced'
check "audit: repair is not in place" cmp judged/broken.binary judged/before.binary
audits "audit: the repaired" 0 judged/mended.binary
audits "audit: repair h5" 0 judged/t.h5 --repair judged/mended.h5 --json --pairs 1000
check "audit: repair keys" json "set(d['repair']) == {'output', 'entries', 'replaced', 'clamped', \
'symmetrised', 'max_change_abs', 'max_change_rel', 'scaled_incidences', 'smallest_scale'} and \
len(d['results']) == 2"
check "audit: attributes survive" h5diff judged/t.h5 judged/mended.h5 /specular_reflectance

audits "audit: page" 0 BBQAL1 judged/t.h5 judged/t.binary --against BBQAL1 --pairs 20000 \
  --html judged/page.html
well_formed='
import html.parser, re, sys
text = open("judged/page.html").read()
class P(html.parser.HTMLParser):
    stack, figures = [], 0
    def handle_starttag(self, tag, attrs):
        self.figures += tag == "figure"
        if tag not in ("meta",): self.stack.append(tag)
    def handle_startendtag(self, tag, attrs): pass
    def handle_endtag(self, tag):
        if self.stack.pop() != tag: sys.exit(1)
p = P(); p.feed(text)
sys.exit(bool(p.stack) or p.figures < 28 or "http" in text or
         re.search("[ MLHV\"](-?nan|-?inf)[ \"LM]", text) is not None)'
check "audit: the page is whole and alone" /usr/bin/python3 -c "$well_formed"

echo precious >judged/old.html
echo precious >judged/old.binary
echo nonsense >judged/noise.h5
refuses "audit: no input" 2 "no INPUT" audit
refuses "audit: existing page" 1 "old.html exists" audit BBQAL1 --html judged/old.html
refuses "audit: existing repair" 1 "old.binary exists" audit judged/t.binary --repair judged/old.binary
refuses "audit: in place" 1 "is an output too" audit judged/t.binary --repair judged/../judged/t.binary --force
refuses "audit: page over an input" 1 "is an output too" audit judged/t.h5 --html judged/t.h5 --force
refuses "audit: repair of several" 2 "takes one INPUT" audit judged/t.h5 BBQAL1 --repair judged/n.h5
refuses "audit: repair of a surface" 2 "a surface, not a table" audit BBQAL1 --repair judged/n.h5
refuses "audit: repair to another format" 2 "different formats" audit judged/t.h5 --repair judged/n.binary
refuses "audit: scale alone" 2 "goes with --repair" audit judged/t.h5 --scale-energy
refuses "audit: missing table" 1 "none.binary: No such file" audit BBQAL1 judged/none.binary
refuses "audit: unknown surface" 1 "NOSUCH" audit NOSUCH
refuses "audit: unknown reference" 1 "NOSUCH" audit judged/t.binary --against NOSUCH
refuses "audit: bad lookup" 2 "'nearest' is none of" audit BBQAL1 --lookup nearest
refuses "audit: bad threshold" 2 "outside 0 to 10" audit BBQAL1 --max-excess -1
refuses "audit: bands" 2 "mono takes one wavelength" audit judged/t.binary --merl-colour mono
echo a,b >judged/data.csv
refuses "audit: no table" 1 "'judged/data.csv' is no table" audit judged/data.csv
: >judged/empty.bsdf
refuses "audit: an empty file" 1 "empty.bsdf' is empty.*get a complete copy" audit judged/empty.bsdf
head -c 3000 judged/t.h5 >judged/cut.h5
refuses "audit: a truncated file" 1 "cut.h5' is damaged or truncated; get a complete copy" audit judged/cut.h5
refuses "audit: RGL is not repaired" 1 "convert it to HDF5" audit judged/b.bsdf --repair judged/n.bsdf
refuses "audit: a directory" 1 "judged" audit judged
refuses "audit: noise" 1 "'judged/noise.h5' is not an HDF5 file" audit judged/noise.h5
check "audit: nothing overwritten" test "$(cat judged/old.html judged/old.binary)" = \
  $'precious\nprecious' -a ! -e judged/n.h5 -a ! -e judged/n.binary

# ---- terminals ---------------------------------------------------------------------------------

works "no progress on a pipe" tabulate BBQAL2 -o pipe.h5 --samples 0
if command -v script >/dev/null; then
  rm -f pipe.h5
  script -qec "'$program' tabulate BBQAL2 -o pty.h5 --compress 1 --samples 0 >/dev/null" /dev/null \
    >out 2>&1 </dev/null
  check "progress on a terminal" has 'BBQAL2.*%.*entries/s.*left'
  check "progress is cleared" test "$(tail -c 4 out)" = $'\r\033[K'
  script -qec "'$program' tabulate BBQAL2 -o pty.h5 --force --quiet" /dev/null >out 2>&1 </dev/null
  check "quiet on a terminal" test ! -s out
  printf 'name: "a\\e[31m\\u009b5m\\u00b5b"\nsigma0_um: 0.54\ntau_um: 6.5\nindex: Al\n' >escape.yml
  mkdir $'esc\e[31m'
  cp escape.yml $'esc\e[31m/s.yml'
  for command in "surfaces --as beckmann escape.yml" "tabulate escape.yml -o pty.h5 --samples 0 --force" \
    "audit esc*/s.yml" "reflectance escape.yml" "predict escape.yml --json" "surfaces escape.yml --json"; do
    script -qec "'$program' $command" /dev/null 2>&1 </dev/null |
      sed 's/\x1b\[K//g; s/\xc2\xb5/u/g; s/\r//g' >out # of the progress, and a harmless letter
    check "$command: no control characters" test -s out -a -z "$(LC_ALL=C tr -d '\n\t -~\302' <out)"
  done
else
  skip "progress on a terminal: no script(1)"
fi
rm -f pipe.h5 pty.h5

# ---- interruption ------------------------------------------------------------------------------

mkdir stop
echo precious >stop/old.h5
# stopped SIGNAL: sends it while a big table is being compressed; leaves the status in $status. env
# undoes that shells let background jobs ignore SIGINT, and nohup SIGHUP.
stopped() {
  env --default-signal=INT,HUP "$program" tabulate BBQAL2 -o stop/old.h5 -o stop/new.h5 --force \
    --compress 9 --wavelengths 400:700:5 >out 2>err &
  local pid=$!
  sleep 1.5
  kill -0 $pid 2>/dev/null || fail "interruption came too late: the table was done"
  kill -"$1" $pid
  { wait $pid; } 2>/dev/null
  status=$?
}
unharmed() { [ "$(cat stop/old.h5)" = precious ] && [ "$(ls -A stop)" = old.h5 ]; }
for signal in INT:130 TERM:143 HUP:129; do
  stopped ${signal%:*}
  one_line "SIG${signal%:*}" $status ${signal#*:} "stopped by SIG${signal%:*}"
  check "SIG${signal%:*} harms nothing" unharmed
done
env --default-signal=INT timeout -s INT -k 10 2 "$program" view BBQAL2 --size 8192 -o stop/v.png >out 2>err
one_line "SIGINT amid a picture" $? 124 "stopped by SIGINT" # timeout's own status, 137 after -k
awk 'BEGIN { print "x_um,z_um"; for (i = 0; i < 1000000; i++) printf "%d,%.4f\n", i, sin(i * i % 997) }' >long.csv
env --default-signal=INT timeout -s INT -k 20 2 "$program" roughness long.csv --cutoff auto >out 2>err
one_line "SIGINT amid one scan" $? 124 "stopped by SIGINT"
printf 'sigma0_um: 0.3\ntau_um: 4\nindex: Cu\nwavelengths_nm: 400:899.5:0.5\n' >thousand.yml
env --default-signal=INT timeout -s INT -k 20 2 "$program" tabulate thousand.yml -o stop/thousand.bsdf \
  --for pbrt --table-error 0.03 >out 2>err
one_line "SIGINT amid an RGL table" $? 124 "stopped by SIGINT"
stopped KILL
check "SIGKILL status" test $status = 137
if /usr/bin/python3 -c 'import os; os.open("stop", os.O_TMPFILE | os.O_WRONLY)' 2>/dev/null; then
  check "SIGKILL harms nothing" unharmed
else
  check "SIGKILL leaves the old file" test "$(cat stop/old.h5)" = precious
  skip "SIGKILL leaves no litter: no O_TMPFILE in $work"
fi

# ---- a full disk -------------------------------------------------------------------------------

mkdir tiny
if [ "$(id -u)" = 0 ] && mount -t tmpfs -o size=4m none tiny 2>/dev/null; then
  mounted=$work/tiny
  echo precious >tiny/old.h5
  refuses "full disk, h5" 1 "tiny/old.h5.*(No space left|full)" tabulate BBQAL2 -o tiny/old.h5 --force
  refuses "full disk, merl" 1 "tiny/m.binary.*(No space left|full)" tabulate BBQAL2 -o tiny/m.binary
  check "full disk harms nothing" test "$(ls -A tiny; cat tiny/old.h5)" = $'old.h5\nprecious'
  head -c 4m /dev/zero >tiny/filler 2>/dev/null
  refuses "full disk, bench" 1 "tiny/b.csv" bench smooth --samples 200 --repeats 1 --quiet \
    --csv tiny/b.csv
  umount tiny && mounted=
else
  skip "full disk: mounting a small tmpfs takes root"
fi

summary
