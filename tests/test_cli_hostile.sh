#!/bin/bash
# Tables that were made to harm their readers, and memory that runs out: one line and status 1, at
# once, and nothing else is read or written.
# usage: test_cli_hostile.sh PROGRAM
. "$(dirname "$0")/cli_support.sh"

small="--theta-i 0:90:7 --theta-r 0:90:7 --phi 0:180:13 --samples 0 --method literal"
works "a table" tabulate BBQAL2 -o good.h5 $small

# ---- HDF5 --------------------------------------------------------------------------------------

# The good table, changed: NAME.h5 for each kind of harm.
/usr/bin/python3 - <<'END'
import os, shutil
import h5py, numpy

NAMES = ["theta_i", "brdf"]

def changed(kind, name):
    """A copy of the good table without /name, open; and what was in it."""
    path = f"{kind}_{name}.h5"
    shutil.copy("good.h5", path)
    file = h5py.File(path, "a")
    old = file[name][...]
    del file[name]
    return file, old

def virtual(name, path):
    """Virtual, from /name of the file at path."""
    file, old = changed("virtual" if path == "." else "other", name)
    layout = h5py.VirtualLayout(old.shape, old.dtype)
    layout[...] = h5py.VirtualSource(path, name, old.shape, old.dtype)
    file.create_virtual_dataset(name, layout)

def external(kind, name, path):
    """In an external file."""
    file, old = changed(kind, name)
    file.create_dataset(name, old.shape, old.dtype, external=[(path, 0, old.nbytes)])

os.mkfifo("fifo")
shutil.copy("good.h5", "elsewhere.h5")
with open("secret", "wb") as file:
    file.write(b"\0" * 10000000)
for name in NAMES:
    virtual(name, ".")
    virtual(name, "elsewhere.h5")
    external("fifo", name, "fifo")
    external("secret", name, "secret")
    file, old = changed("link", name)
    file[name] = h5py.ExternalLink("elsewhere.h5", name)
    file, old = changed("group", name)
    file.create_group(name)
    file, old = changed("text", name)
    file.create_dataset(name, old.shape, h5py.string_dtype())
    file, old = changed("loop", name)
    file[name] = h5py.SoftLink(name)
    file, old = changed("long", name)
    file.create_dataset(name, (1 << 40,) * old.ndim, old.dtype, chunks=(4,) * old.ndim)
    file, old = changed("wide", name)
    number = h5py.h5t.IEEE_F64LE.copy()
    number.set_size(4096)
    space = h5py.h5s.create_simple(old.shape)
    h5py.h5d.create(file.id, name.encode(), number, space)
    file, old = changed("filter", name)
    space, creation = h5py.h5s.create_simple(old.shape), h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    creation.set_chunk(old.shape)
    creation.set_filter(32015, h5py.h5z.FLAG_OPTIONAL, (3,))
    h5py.h5d.create(file.id, name.encode(), h5py.h5t.IEEE_F32LE, space, creation)

# What HDF5 itself may do: the newest format, soft links, compact storage.
with h5py.File("good.h5") as old, h5py.File("newest.h5", "w", libver="latest") as new:
    for key, value in old.attrs.items():
        new.attrs[key] = value
    for name in old:
        old.copy(name, new)
# Other units, and wavelengths of um in a field of nm.
UNITS = {"rad": ("theta_i", numpy.pi / 180), "Radians": ("phi", numpy.pi / 180),
         "um": ("wavelength", 1e-3), "m": ("wavelength", 1e-9), "nm": ("wavelength", 1e-3),
         "grad": ("theta_r", 10 / 9)}
for unit, (name, factor) in UNITS.items():
    shutil.copy("good.h5", f"in_{unit}.h5")
    with h5py.File(f"in_{unit}.h5", "a") as file:
        file[name][...] = file[name][...] * factor
        file[name].attrs["units"] = numpy.bytes_(unit) if unit == "um" else unit
shutil.copy("good.h5", "soft.h5")
with h5py.File("soft.h5", "a") as file:
    file.move("n", "index")
    file["n"] = h5py.SoftLink("/index")
END

# harmless FILE PATTERN: every reader refuses it within 5 s (hanging is what is feared).
harmless() {
  local command
  for command in "view -o x.png" "convert x.binary" audit "fit --index Al" "predict BBQAL2 --measurements"; do
    case $command in
      convert*) set -- "$1" "$2" convert "$1" x.binary ;;
      *) set -- "$1" "$2" $command "$1" ;;
    esac
    timeout 5 "$program" "${@:3}" >out 2>err <in
    one_line "$command $1" $? 1 "$2"
  done
}

for file in virtual_*.h5 other_*.h5; do
  harmless "$file" "'$file' is no hetab table: /[a-z_]* is neither chunked"
done
for file in fifo_*.h5 secret_*.h5; do harmless "$file" "'$file' is no hetab table: /[a-z_]* lies in other"; done
for file in link_*.h5 group_*.h5 loop_*.h5; do harmless "$file" "'$file' is no hetab table"; done
for file in text_*.h5 wide_*.h5; do harmless "$file" "does not hold floating-point"; done
for file in long_*.h5; do harmless "$file" "'$file'.* entries"; done
for file in filter_*.h5; do harmless "$file" "/[a-z_]* is compressed with filter 32015.*h5repack -f NONE"; done

for file in newest.h5 soft.h5; do
  works "$file is sound" convert -q -f --theta-i 0,45 --theta-r 0,45 --phi 0,180 "$file" sound.h5
  "$program" audit -q -f "$file" --repair repaired.h5 >out 2>err
  [ $? = 3 ] && [ ! -s err ] && pass || fail "$file is repaired: $(cat err)" # too coarse to pass
done

angles="--theta-i 0,45 --theta-r 0,45 --phi 0,180 --pairs 20"
works "degrees, nm" convert -qf $angles good.h5 sound.h5
for unit in rad Radians um m; do
  works "in $unit" convert -qf $angles in_$unit.h5 unit.h5
  check "in $unit: the same" h5diff -p 1e-7 sound.h5 unit.h5 brdf
done
harmless in_grad.h5 "'in_grad.h5': the attribute units of /theta_r is 'grad': give degree or rad"
harmless in_nm.h5 "'in_nm.h5': entry 0 of /wavelength is 0.4 nm; wavelengths are above 10 nm"

# What fails to be read is not judged by what was not read, and a folder or a pipe is no table.
mkdir folder.bsdf
mkfifo pipe.bsdf
ln -s /proc/self/mem failing.bsdf # whose first byte is an error, EIO
harmless failing.bsdf "failing.bsdf'?: .*Input/output error"
harmless folder.bsdf "cannot read 'folder.bsdf': it is not a regular file"
harmless pipe.bsdf "cannot read 'pipe.bsdf': it is not a regular file"

# ---- MERL ---------------------------------------------------------------------------------------

# NaN in place of the mark of cells below the horizon; then in one above it, too.
works "a MERL table" tabulate -q BBQAL2 -o good.binary
/usr/bin/python3 - <<'END'
import numpy
head, cells = open("good.binary", "rb").read(12), numpy.fromfile("good.binary", "<f8", offset=12)
for name, also in ("marks", 0), ("hole", 1):
    cells = numpy.where(cells < 0, numpy.nan, cells)
    if also:
        cells[100] = numpy.nan
    with open(name + ".binary", "wb") as file:
        file.write(head + cells.tobytes())
END
works "NaN as a mark" view -q --size 640 --what lobes marks.binary -o marks.png
refuses "NaN above the horizon" 1 "'hole.binary' is damaged: value 100" view hole.binary -o hole.png

# ---- RGL ---------------------------------------------------------------------------------------

works "a .bsdf" tabulate -q BBQAL2 -f -o good.bsdf --table-error 0.3
/usr/bin/python3 - <<'END'
import struct
import tensor_file

with open("good.bsdf", "rb") as file:
    good = file.read()
fields = tensor_file.parse(good)
rgb = fields["rgb"]
place = good.index(rgb.tobytes())
for name, value in ("negative", -1.0), ("overflow", 3e38), ("nan", float("nan")):
    with open(name + ".bsdf", "wb") as file:
        file.write(good[:place] + struct.pack("<f", value) + good[place + 4:])
END
for name in negative overflow nan; do
  refuses "convert a .bsdf: $name" 1 "'$name.bsdf', field rgb" convert $name.bsdf x.binary
  refuses "view a .bsdf: $name" 1 "'$name.bsdf', field rgb" view $name.bsdf -o x.png
  refuses "audit a .bsdf: $name" 1 "'$name.bsdf', field rgb" audit $name.bsdf
done

check "nothing was written" test ! -e x.png -a ! -e x.binary

# ---- outputs -----------------------------------------------------------------------------------

# keeps NAME FILE PATTERN ARGUMENT...: hetab refuses to write over FILE, which it reads.
keeps() {
  local name=$1 file=$2
  cp "$file" before
  refuses "$name" 1 "$3" "${@:4}" --force
  check "$name: $file is as it was" cmp "$file" before
}
"$program" surfaces BBQAL2 >s.yml
printf 'wavelength_nm,n,k\n400,1.5,0\n700,1.5,0\n' >index.csv
printf 'wavelength_nm,theta_i_deg,theta_r_deg,phi_deg,f\n550,30,30,180,0.2\n550,30,40,180,0.1\n' >m.csv
ln good.h5 hard.h5
keeps "predict: CSV over the surface" s.yml "output too" predict s.yml --sigma0 0.5:0.6 --csv s.yml
keeps "fit: surface over the index" index.csv "output too" fit m.csv --tau 5 --index ./index.csv --surface index.csv
keeps "audit: page over --against" s.yml "output too" audit good.h5 --against s.yml --html s.yml
keeps "audit: repair over a hard link" good.h5 "output too" audit good.h5 --repair hard.h5
keeps "roughness: CSV over a scan" m.csv "output too" roughness m.csv --csv m.csv
sed 's/^index:.*/index: {file: i.specular.csv}/' s.yml >i.yml
cp index.csv i.specular.csv
keeps "tabulate: the delta over the index" i.specular.csv "is an input" tabulate i.yml -o i.bsdf
ln -s good.h5 link.exr
keeps "view: over the table" good.h5 "output too" view good.h5 -o link.exr

# Of several outputs all or none: the second is too large.
awk 'BEGIN { print "x_um,z_um"; for (i = 0; i < 500; i++) printf "%d,%g\n", i, sin(i * i) }' >scan.csv
(ulimit -f 8 && "$program" roughness -q scan.csv --csv a.csv --html a.html 2>err)
one_line "all or none" $? 1 "cannot write 'a.html': File too large"
check "all or none: none" test ! -e a.csv -a ! -e a.html
cp s.yml a.h5
(ulimit -f 8 && "$program" convert -q -f good.bsdf a.h5 2>err)
one_line "convert" $? 1 "cannot write 'a.h5': File too large"
check "convert: the old file" cmp s.yml a.h5

"$program" audit --json good.h5 >/dev/full 2>err
one_line "a failed audit to a full disk" $? 1 "standard output: No space left"

# ---- memory ------------------------------------------------------------------------------------

# Freed memory overwritten, and handed out again at once.
plain=$program
cat >perturbed <<END
#!/bin/sh
GLIBC_TUNABLES=glibc.malloc.tcache_count=0 MALLOC_PERTURB_=165 exec "$plain" "\$@"
END
chmod +x perturbed
program=./perturbed
"$program" audit -q --pairs 1000 good.h5 >out 2>err
[ $? = 3 ] && [ ! -s err ] && pass || fail "audit, perturbed: $(cat err)"
works "convert, perturbed" convert -q -f --theta-i 0,45 --theta-r 0,45 --phi 0,180 good.h5 perturbed.h5
works "view, perturbed" view -q --size 640 --what lobes good.h5 -o perturbed.exr
works "predict, perturbed" predict -q BBQAL2 --measurements good.h5 --non-uniformity 0.1
works "tabulate, perturbed" tabulate -q -f BBQAL2 -o perturbed.h5 -o perturbed.exr $small
program=$plain

# JSON for which memory runs out: the N-th allocation of jansson fails.
cat >json.c <<'END'
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdlib.h>

typedef void set_fn(void *(*)(size_t), void (*)(void *));
extern void *__libc_malloc(size_t);
static void *(*target)(size_t) = malloc;
static __thread int failing;
static long count, fail_at;

void *malloc(size_t size) {
  return failing ? NULL : __libc_malloc(size);
}

static void *counted(size_t size) {
  failing = ++count == fail_at;
  void *memory = target(size);
  failing = 0;
  return memory;
}

void json_set_alloc_funcs(void *(*get)(size_t), void (*release)(void *)) {
  target = get;
}

static void __attribute__((constructor)) begin(void) {
  fail_at = atol(getenv("FAIL_AT"));
  ((set_fn *)dlsym(RTLD_NEXT, "json_set_alloc_funcs"))(counted, free);
}
END
# json_fails N ARGUMENT...: a line, whichever allocation up to the N-th fails.
json_fails() {
  local most=$1 at
  shift
  for at in 1 $((most / 3)) $((most / 2)) "$most"; do
    FAIL_AT=$at LD_PRELOAD=$work/json.so "$program" "$@" --json >out 2>err
    one_line "$* --json, allocation $at" $? 1 "out of memory"
  done
}
if [ -n "${ASAN_OPTIONS:-}" ]; then
  skip "JSON in little memory: AddressSanitizer has its own malloc"
else
  cc -shared -fPIC -o json.so json.c -ldl
  { cat m.csv; for r in 20 25 35 45 50; do echo 550,30,$r,180,0.1; done; } >fit.csv
  json_fails 300 surfaces BBQAL2
  json_fails 200 surfaces Al
  json_fails 200 surfaces BBQAL2 --as beckmann
  json_fails 8 devices
  json_fails 1000 reflectance BBQAL2
  json_fails 50 tabulate -f BBQAL2 -o limited.h5 $small
  json_fails 300 predict BBQAL2
  json_fails 100 roughness scan.csv
  json_fails 500 audit good.h5 --pairs 20
  json_fails 80 fit fit.csv --tau 5 --slope 0.1 --index index.csv
fi

# OpenEXR output from where memory does not suffice to start to where it does.
good=0 bad=0
if [ -n "${ASAN_OPTIONS:-}" ]; then
  skip "OpenEXR in little memory: AddressSanitizer takes terabytes of addresses"
else
  for kb in $(seq 34000 400 40000); do
    rm -f limited.exr
    (ulimit -v "$kb" && timeout 5 "$program" tabulate -q BBQAL2 -o limited.exr $small 2>err) 2>/dev/null
    status=$?
    case $status in
      0) good=$((good + 1)) ;;
      1) [ "$(wc -l <err)" = 1 ] && [ ! -e limited.exr ] && bad=$((bad + 1)) || fail "$kb kB: $(cat err)" ;;
      *) fail "OpenEXR in $kb kB: status $status" ;;
    esac
  done
  check "too little memory, and enough" test "$good" -gt 0 -a "$bad" -gt 0
fi
summary
