#!/bin/bash
# Plans and batches: what a scene needs, made once, whole, by any number of processes.
. "$(dirname "$0")/cli_support.sh"

scene() { # scene NAME LINE...
  local name=$1
  shift
  printf '%s\n' "$@" >"$name"
}
json() { # json NAME EXPRESSION: of ./out, as d
  check "$1" /usr/bin/python3 -c "import json; d = json.load(open('out')); assert $2"
}

# ---- plans ---------------------------------------------------------------------------------------
scene five.yml 'surfaces: [BBQAL1, BBQAL2, GGAL120, GGAL240, NGGAL]' 'consumer: mitsuba-rgb'
works "plan" plan five.yml
check "a row a surface" has 'NGGAL +table +dd delta'
check "sums" has '5 surfaces for mitsuba-rgb: 5 tables'
scene thin.yml 'surfaces: [{name: thin, sigma0_um: 0.02, tau_um: 500, index: Al}, BBQAL2]' 'consumer: hdf5' 'table_error: 0.02'
works "a needle, planned for a grid" plan thin.yml
check "no grid will hold it" grep -q "^1 of the tables cannot be that exact, thin's least of all: .bsdf" out
works "plan in JSON" plan five.yml --json
json "five tables within 5 MB" 'sum(s["bytes"] for s in d["surfaces"]) <= 5e6 and d["table_error"] == 0.01'
json "saving over dense tables" 'd["dense_bytes"] == 5 * 31 * 90 * 90 * 181 * 4'
scene kinds.yml 'surfaces:' '  - {name: mirror, sigma0_um: 0.0005, tau_um: 5, index: Al}' \
  '  - {name: one, sigma0_um: 0.3, tau_um: 3, index: Al}' \
  '  - {name: same, sigma0_um: 0.3, tau_um: 3.001, index: Al}' \
  '  - {name: paint, sigma0_um: 2, tau_um: 5, index: {n: 1.5}, diffuse_reflectance: 0.5}' \
  'consumer: pbrt' 'max_theta_i_deg: 60'
works "kinds" plan kinds.yml --json
json "mirror, shared, terms" \
  '[s["what"] for s in d["surfaces"]] == ["mirror", "table", "shared", "table"]
assert d["surfaces"][2]["table_of"] == "one"
assert d["surfaces"][3]["delta"] == "left out" and d["surfaces"][3]["diffuse"]
assert d["surfaces"][3]["energy_left_out"] < 0.003'
scene delta.yml 'surfaces: [{name: a, sigma0_um: 0.001, tau_um: 0.05, index: Au}]' \
  'consumer: hdf5' 'energy_error: 0.00001'
works "nearly all is the delta" plan delta.yml
check "100 %" has 'up to 100 % of what they reflect'
scene nothing.yml 'surfaces: []' 'consumer: merl'
works "nothing" plan nothing.yml
check "nothing is said" has '^0 surfaces for merl'
scene sweep.yml 'sweep: {index: [Al, Cu], slope: [0.1, 0.2], tau_um: {from: 2, to: 8, count: 3, spacing: log}}' \
  'consumer: merl'
works "sweep" plan sweep.yml --json
json "every combination" 'len(d["surfaces"]) == 12 and d["surfaces"][1]["surface"] == "Al_s0.4_t4"
assert all(s["bytes"] == 34992012 for s in d["surfaces"])'
works "job file" plan five.yml --jobs-for slurm
check "an array" has '^#SBATCH --array'
scene "it's.yml" 'surfaces: [NGGAL]' 'consumer: mitsuba-rgb' "output: a b"
works "a command line" plan "it's.yml" --jobs-for parallel
sed "s|hetab batch|echo|; s/^parallel --quote //; s/ :::.*//" out >line.sh
check "quoted for the shell" test "$(sh line.sh)" = "it's.yml -o a b --jobs 1 --shard {}/8"
refuses "jobs for no scene" 1 'none.yml' plan none.yml --jobs-for slurm

works_loud() { # as works, but a log on standard error
  local name=$1
  shift
  if "$program" "$@" >out 2>err </dev/null; then pass; else fail "$name: $(head -c 300 err)"; fi
}

# ---- budgets: the common error is the least that the budget allows ----------------------------------
scene budget.yml 'surfaces: [BBQAL1, BBQAL2, NGGAL]' 'consumer: mitsuba-rgb' 'memory_mb: 1'
works "budget" plan budget.yml --json
json "met, and used" '0.9e6 < d["bytes"] <= 1e6 and d["table_error"] > 0.01'
cp out budget.json
works_loud "budget made" batch budget.yml -o budget
check "asked for and left, printed" has '\(1 % asked for; the budget leaves [1-9]\.?[0-9]* %\)'
check "and on the page" grep -Eq 'asked for: 1 %; the budget of 1 MB leaves [1-9]\.?[0-9]* %' budget/index.html
# brute force: of all ways to split the budget, with errors a tenth apart, the least worst error
check "no split is better" /usr/bin/python3 - "$program" <<'END'
import itertools, json, subprocess, sys
found = json.load(open("budget.json"))
names = [s["surface"] for s in found["surfaces"]]
errors = [0.01 * 1.05**k for k in range(0, 30, 2)]
def sizes(error):
    with open("one.yml", "w") as f:
        f.write("surfaces: [%s]\nconsumer: mitsuba-rgb\ntable_error: %.9g" % (", ".join(names), error))
    return [s["bytes"] for s in json.loads(subprocess.run([sys.argv[1], "plan", "one.yml", "--json"],
                                                          capture_output=True).stdout)["surfaces"]]
table = [sizes(e) for e in errors]
best = min(errors[max(pick)] for pick in itertools.product(range(len(table)), repeat=3)
           if sum(table[pick[s]][s] for s in range(3)) <= 1e6)
assert best / 1.1026 < found["table_error"] <= best * 1.0001, (best, found["table_error"])
assert all(s["error_l1"] <= found["table_error"] for s in found["surfaces"])
END
scene tight.yml 'surfaces: [BBQAL1, NGGAL]' 'consumer: mitsuba-rgb' 'memory_mb: 0.01'
refuses "impossible budget" 1 'memory_mb 0.01 is too little: at an error of 0.3, the largest that is allowed, the tables take .* MB together; .*BBQAL1 \(' plan tight.yml

# ---- mistakes ------------------------------------------------------------------------------------
bad() { # bad NAME PATTERN LINE...
  local name=$1 pattern=$2
  shift 2
  scene bad.yml "$@"
  refuses "$name" 1 "$pattern" plan bad.yml
}
bad "unknown key" 'bad.yml:2: key colour' 'consumer: merl' 'colour: red' 'surfaces: [NGGAL]'
bad "unknown consumer" 'bad.yml:1: key consumer.*maya' 'consumer: maya' 'surfaces: [NGGAL]'
bad "no consumer" 'consumer' 'surfaces: [NGGAL]'
bad "no surfaces" 'neither surfaces nor a sweep' 'consumer: merl'
bad "unknown surface" 'bad.yml:1: key surfaces' 'surfaces: [NOSUCH]' 'consumer: merl'
bad "missing file" 'none.yml' 'surfaces: [none.yml]' 'consumer: merl'
bad "same name twice" 'two surfaces are named NGGAL' 'surfaces: [NGGAL, NGGAL]' 'consumer: merl'
bad "name that is a path" 'bad.yml:1.*to name a file' \
  'surfaces: [{name: ../x, sigma0_um: 1, tau_um: 5, index: Al}]' 'consumer: merl'
bad "control character in a name" 'to name a file' \
  'surfaces: [{name: "a\tb", sigma0_um: 1, tau_um: 5, index: Al}]' 'consumer: merl'
bad "contradiction" 'slope.*besides sigma0_um' \
  'sweep: {index: Al, slope: 0.1, sigma0_um: 1, tau_um: 5}' 'consumer: merl'
bad "bad range" 'bad.yml:1: key tau_um' \
  'sweep: {index: Al, slope: 0.1, tau_um: {from: 5, to: 1, count: 3}}' 'consumer: merl'
bad "outside the index data" '103\.32' \
  'surfaces: [{name: x, sigma0_um: 1, tau_um: 5, index: Al, wavelengths_nm: 80:90:10}]' 'consumer: merl'
bad "a unit" "bad.yml:2: key memory_mb: '20 MB'.*without a unit" 'surfaces: [NGGAL]' 'memory_mb: 20 MB' 'consumer: merl'
bad "error out of range" 'bad.yml:2: key table_error' 'surfaces: [NGGAL]' 'table_error: 2' 'consumer: merl'

# ---- batches -------------------------------------------------------------------------------------
scene two.yml 'surfaces: [BBQAL2, NGGAL, {name: twin, sigma0_um: 0.54, tau_um: 6.5, index: Al}]' \
  'consumer: mitsuba-rgb'
works "dry run" batch two.yml -o made --dry-run
check "all are to be made" test "$(sort out | tr '\n' ' ')" = "BBQAL2 NGGAL twin "
works_loud "batch" batch two.yml -o made --json
json "made" 'd["made"] == 3 and d["failed"] == 0 and d["error_l1"] <= 0.01'
check "a log" grep -q 'BBQAL2: made, 0\.[0-9]* MB (0\.[0-9]* expected), error' err
check "twins have one table" test ! -e made/twin.bsdf -a -s made/BBQAL2.bsdf
check "records, manifest, overview, scene" test -s made/twin.json -a -s made/manifest.json \
  -a -s made/index.html -a -s made/scene.xml
check "what to import" sh -c "grep -q 'import he_torrance, which is' made/scene.xml &&
  grep -q 'import he_torrance' made/index.html"
check "scene" grep -q '"he_torrance" id="twin"><string name="filename" value="BBQAL2.bsdf"' made/scene.xml
check "the material of the delta" sh -c '/usr/bin/python3 -m py_compile made/scene.py made/he_torrance.py && rm -r made/__pycache__'
check "pictures" grep -q 'src="data:image/png;base64,' made/index.html
check "measured is what was asked for" /usr/bin/python3 - <<'END'
import json
for name in "BBQAL2", "NGGAL", "twin":
    r = json.load(open("made/%s.json" % name))
    assert r["fits"] and 0 < r["error_l1"] <= 0.01, r
    assert name == "twin" or 0.5 < r["error_l1"] / r["planned"]["error_l1"] < 2, r
r = json.load(open("made/BBQAL2.json"))
assert r["files"][0]["bytes"] == r["planned"]["bytes"], r
END
cp -a made first
works_loud "again" batch two.yml -o made --json
json "nothing is made twice" 'd["made"] == 0 and d["kept"] == 3'
check "nothing is touched" sh -c 'diff -r first made && test made/NGGAL.bsdf -ot out'
sed -i 's/"key": "./"key": "x/' made/NGGAL.json
truncate -s 100 made/BBQAL2.bsdf
works_loud "a record edited, a table cut" batch two.yml -o made --json
json "both are made again" 'd["made"] >= 2'
check "as they were" cmp first/BBQAL2.bsdf made/BBQAL2.bsdf
/usr/bin/python3 - <<'END'
import os
with open("made/NGGAL.bsdf", "r+b") as f:
    at = os.stat("made/NGGAL.bsdf")
    f.seek(50000)
    byte = f.read(1)
    f.seek(50000)
    f.write(bytes([byte[0] ^ 1]))
os.utime("made/NGGAL.bsdf", ns=(at.st_atime_ns, at.st_mtime_ns))
END
works_loud "unseen by size and time" batch two.yml -o made --json
json "kept" 'd["made"] == 0'
works_loud "seen by checksum" batch two.yml -o made --json --verify
json "made again" 'd["made"] == 1'
check "byte for byte" cmp first/NGGAL.bsdf made/NGGAL.bsdf

# spectra: a few wavelengths, the delta folded for pbrt, and the error with all of that
scene spectra.yml 'surfaces: [BBQAL1, NGGAL, {name: mirror, sigma0_um: 0.0005, tau_um: 5, index: Cu}]' \
  'consumer: mitsuba-spectral' 'output: spectra'
works "spectra, planned" plan spectra.yml --json
json "few wavelengths" 'all(3 <= s["wavelengths"] <= 11 for s in d["surfaces"][:2]) and d["surfaces"][2]["what"] == "mirror"
assert all(0 < s["wavelength_error"] <= 0.0025 for s in d["surfaces"][:2])'
works_loud "spectra" batch spectra.yml --quiet
check "error of all wavelengths" with_library /usr/bin/python3 "$scripts/../tests/batch_errors.py" "$(dirname "$program")" spectra 0.01 BBQAL1 NGGAL
check "a mirror's colour" grep -q '"conductor" id="mirror"><spectrum name="eta" value="400:[0-9.]*, 410:' spectra/scene.xml
sed 's/mitsuba-spectral/pbrt/' spectra.yml >pbrt.yml
works_loud "pbrt" batch pbrt.yml -o pbrt --quiet
check "the delta is in the tables" sh -c 'test ! -e pbrt/NGGAL.specular.csv && grep -qa specular_cone_deg pbrt/NGGAL.bsdf'
check "spectra" grep -qa wavelengths pbrt/NGGAL.bsdf
check "materials" grep -q 'MakeNamedMaterial "NGGAL" "string type" "measured" "string filename" "NGGAL.bsdf"' pbrt/scene.pbrt

# the overview of a batch that is not done
works_loud "one of three" batch two.yml -o some --only NGGAL --quiet
works_loud "what there is" batch two.yml -o some --report --quiet
check "what is missing is said" grep -q '<td>BBQAL2</td><td class="b FAIL">missing' some/index.html
check "and what is there" grep -q '<td>NGGAL</td><td class="b PASS">pass' some/index.html

# so rough that only the slope counts
scene rough.yml 'surfaces:' '  - {name: a, sigma0_um: 16, tau_um: 160, index: Al}' \
  '  - {name: b, sigma0_um: 24, tau_um: 240, index: Al}' '  - {name: c, sigma0_um: 0.5, tau_um: 5, index: Al}' \
  'consumer: mitsuba-rgb' 'max_theta_i_deg: 80'
works_loud "one slope" batch rough.yml -o rough
check "one table" test ! -e rough/b.bsdf -a -e rough/c.bsdf
check "measured" grep -q '"fits": true' rough/b.json

# more light than falls on it, by the model's own doing, is no fault of the table
scene bright.yml 'surfaces: [{name: bright, sigma0_um: 0.1, tau_um: 2, index: Ag}]' 'consumer: mitsuba-rgb'
works_loud "a model that makes light" batch bright.yml -o bright --quiet
check "told from a table's fault" /usr/bin/python3 -c '
import json; r = json.load(open("bright/bright.json"))
assert r["verdict"] == "model" and r["fits"] and r["energy"] > 1.005 and abs(r["bias"]) < 0.01 / 3'
check "the page too" grep -q '<td>bright</td><td class="b WARN">model' bright/index.html

# parts, and a launcher's
for part in 1 2; do
  works_loud "part $part" batch two.yml -o parts --shard $part/2 --quiet
done
check "the same files" cmp made/NGGAL.bsdf parts/NGGAL.bsdf
check "who finishes last writes the overview" test -s parts/index.html
refuses "bad part" 2 'give I/N' batch two.yml -o parts --shard 3/2
OMPI_COMM_WORLD_RANK=0 OMPI_COMM_WORLD_SIZE=2 "$program" batch two.yml -o ranks -n >out 2>err
check "a rank has its part" test "$(wc -l <out)" -lt 3 -a "$(wc -l <out)" -gt 0
OMPI_COMM_WORLD_RANK=0 "$program" batch two.yml -o ranks -n >out 2>err
check "half a pair is an error" test $? = 1
check "and says so" grep -q 'OMPI_COMM_WORLD_SIZE.*--shard' err
SLURM_PROCID=0 SLURM_NTASKS=8 "$program" batch two.yml -o ranks -n >out 2>err
check "outside a step all is done" test "$(wc -l <out)" = 3
SLURM_ARRAY_TASK_ID=5 SLURM_ARRAY_TASK_MIN=1 SLURM_ARRAY_TASK_STEP=2 SLURM_ARRAY_TASK_COUNT=3 \
  "$program" batch two.yml -o ranks -n >out 2>err
check "an array's task" test $? = 0
SLURM_ARRAY_TASK_ID=6 SLURM_ARRAY_TASK_MIN=1 SLURM_ARRAY_TASK_STEP=2 SLURM_ARRAY_TASK_COUNT=3 \
  "$program" batch two.yml -o ranks -n >out 2>err
check "one that does not fit" grep -q 'use --shard' err

scene twice.yml 'sweep: {index: Al, sigma0_um: [0.500001, 0.500002], tau_um: 5}' 'consumer: merl'

# ---- failures ------------------------------------------------------------------------------------
scene merl.yml 'surfaces: [NGGAL]' 'consumer: merl'
refuses "an unwritable place" 1 'cannot make the folder' batch two.yml -o /proc/tables
refuses "an unwritable folder" 1 '/proc/plan.json' batch two.yml -o /proc
refuses "a value twice" 1 'first four digits' plan twice.yml
works_loud "nothing to make" batch nothing.yml -o nothing
check "has an overview, too" grep -q '0 surfaces for merl' nothing/index.html
printf 'sigma0_um: 0.3\ntau_um: 3\nindex: Cu\n' >alone.yml
refuses "a surface for a scene" 1 'alone.yml: this is a surface; a scene has the key surfaces' plan alone.yml
chmod 755 . && mkdir -m 555 closed
nobody() { setpriv --reuid 65534 --clear-groups "$program" "$@"; }
if nobody --version >out 2>err; then # root, who may write anywhere, does so as somebody else
  nobody batch nothing.yml -o closed/t >out 2>err </dev/null
  one_line "a folder that may not be made" $? 1 'make the folder closed/t: Permission denied'
fi
refuses "a file in the folder's place" 1 'cannot make the folder' batch two.yml -o two.yml
refuses "no folder" 2 '-o DIR' batch two.yml
for consumer in hdf5 exr; do
  scene small.yml 'surfaces: [NGGAL]' "consumer: $consumer" 'max_theta_i_deg: 10' 'max_theta_r_deg: 15'
  works_loud "$consumer" batch small.yml -o "small-$consumer" --json
  json "$consumer: what occurs" 'd["made"] == 1 and d["planned_bytes"] == 10 * 15 * 181 * {"hdf5": 4 * 31, "exr": 2 * 3}["'$consumer'"]'
done
scene coarse.yml 'surfaces: [BBQAL1]' 'consumer: hdf5' 'table_error: 0.02'
works_loud "as few nodes as the error allows" batch coarse.yml -o coarse --json
json "fewer" 'd["table_bytes"] < 1e7 and d["misfits"] == 0 and 0.007 < d["error_l1"] <= 0.02'
check "and the error" with_library /usr/bin/python3 "$scripts/../tests/batch_errors.py" "$(dirname "$program")" coarse 0.02 BBQAL1
check "no more than that" test "$(stat -c %s small-hdf5/NGGAL.h5)" -lt 4000000
works "MERL's own error" plan merl.yml --json
json "that of truncating" '0.03 < d["surfaces"][0]["error_l1"] < 0.09'
scene fixed.yml 'surfaces: [NGGAL]' 'consumer: merl' 'memory_mb: 20'
refuses "a size that no error changes" 1 'one size: they take 35 MB together; .*NGGAL' plan fixed.yml
refuses "--only of another" 2 'no such surface' batch two.yml -o made --only GGAL120
mkdir -p blocked/NGGAL.bsdf
"$program" batch two.yml -o blocked >out 2>err
check "one fails" test $? = 1
check "it is named" grep -q '^hetab: NGGAL: .*NGGAL.bsdf' err
check "the rest goes on" test -s blocked/BBQAL2.bsdf -a ! -e blocked/index.html
rmdir blocked/NGGAL.bsdf
works_loud "and can be mended" batch two.yml -o blocked --json
json "only it" 'd["made"] == 1 and d["kept"] == 2'

"$program" batch two.yml -o both --quiet 2>err1 &
works_loud "two at one folder" batch two.yml -o both --quiet
wait $!
check "the other" test $? = 0
check "both made the same" sh -c 'cmp first/BBQAL2.bsdf both/BBQAL2.bsdf && cmp first/NGGAL.bsdf both/NGGAL.bsdf'
OCL_ICD_VENDORS=/nonexistent "$program" batch merl.yml -o nodevice >out 2>err
check "no device: status" test $? = 1
check "no device: one line" grep -q '^hetab: NGGAL: .*OpenCL' err
if ! ldd "$program" | grep -q asan; then # which wants to be loaded first
  echo 'int clEnqueueNDRangeKernel(void) { return -5; }' >shim.c
  check "a shim" cc -shared -fPIC -o shim.so shim.c
  LD_PRELOAD=./shim.so "$program" batch merl.yml -o shim >out 2>err
  check "a device that fails: status" test $? = 1
  check "a device that fails: one line" grep -q '^hetab: NGGAL: clEnqueueNDRangeKernel failed' err
  check "a device that fails: nothing half" test -z "$(find shim -name 'NGGAL*')"
fi
works_loud "MERL" batch merl.yml -o merl --json
json "bytes as planned" 'd["made"] == 1 and d["table_bytes"] == d["planned_bytes"] == d["bytes"] == 34992012'
mkdir small
if mount -t tmpfs -o size=700k none small 2>/dev/null; then
  mounted=$work/small
  "$program" batch two.yml -o small >out 2>err
  check "full disk: status" test $? = 1
  check "full disk: said" grep -q 'No space left' err
  check "full disk: whole or absent" sh -c 'for f in small/*.bsdf; do test ! -e $f || cmp $f first/$(basename $f); done'
  umount small && mounted=
else
  skip "full disk: nothing can be mounted"
fi

# killed at any moment: the next run completes, and makes nothing again that is finished
for delay in 0.05 0.2 0.4 0.6; do
  "$program" batch two.yml -o killed -j 2 --quiet 2>/dev/null &
  pid=$!
  sleep $delay
  kill -9 $pid
  wait $pid 2>/dev/null
  check "no torn table" sh -c 'for f in killed/*.bsdf; do test ! -e $f || cmp $f first/$(basename $f); done'
done
scene many.yml 'sweep: {index: Al, sigma0_um: [0.3, 0.5, 0.7], tau_um: [5, 6]}' 'consumer: mitsuba-rgb'
"$program" batch many.yml -o many -j 2 >out 2>err &
pid=$!
for _ in $(seq 1000); do
  worker=$(awk '{print $1}' /proc/$pid/task/$pid/children 2>/dev/null)
  [ -n "$worker" ] && ls many/*.json >/dev/null 2>&1 && break
  sleep 0.01
done
kill -9 $worker
wait $pid
check "a worker killed: status" test $? = 1
check "a worker killed: said" grep -q 'was killed by signal 9' err
check "the rest goes on" test "$(ls many/*.bsdf | wc -l)" -ge 5
works_loud "and what it was at is made" batch many.yml -o many --json
json "no more" 'd["made"] <= 1 and d["made"] + d["kept"] == 6'
works_loud "after kills" batch two.yml -o killed --quiet
for f in BBQAL2.bsdf NGGAL.bsdf NGGAL.specular.csv; do check "as undisturbed: $f" cmp first/$f killed/$f; done
check "no litter" test -z "$(find killed -name '.hetab*')"
summary
