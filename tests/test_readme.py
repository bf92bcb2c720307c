#!/usr/bin/python3
"""Runs what README.md shows, as it stands there, in one scratch folder: YAML blocks become the file that their first line
names, the lines of shell blocks run one by one (`make TARGET`: the target exists), C programs and fragments are compiled
and run, Python blocks run in the order of the page. Mitsuba's block belongs to `make test-renderers`.

usage: test_readme.py BUILD
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

build = pathlib.Path(sys.argv[1]).resolve()
root = pathlib.Path(__file__).resolve().parent.parent
text = (root / "README.md").read_text()
blocks = re.findall(r"^```(\w+)\n(.*?)^```$", text, re.M | re.S)
counts = {"passed": 0, "failed": 0, "skipped": 0}


def tell(ok, what, why=""):
    counts["passed" if ok else "failed"] += 1
    if not ok:
        print(f"FAIL {what}: {why}")


def run(what, command, **more):
    done = subprocess.run(command, **{"capture_output": True, "text": True, "env": environment, "cwd": work} | more)
    tell(done.returncode == 0, what, f"status {done.returncode}, {(done.stderr or done.stdout)[-300:]}")


def fixtures():
    """What a reader of the page would have: scans, a measured paint, someone's MERL table, a scene's second surface."""
    (work / "scans").mkdir()
    for scan in range(3):
        code = ("import numpy as n; r = n.random.default_rng(%d); x = n.arange(4000) * 0.5; k = n.exp(-(n.arange(-60, 61) * 0.5 / 4.6) ** 2);"
                "z = n.convolve(r.normal(size=4120), k, 'valid'); z *= 0.54 / z.std();"
                "n.savetxt('scans/%d.csv', n.c_[x, z], delimiter=',', header='x_um,z_um', comments='')" % (scan, scan))
        run("a scan", ["/usr/bin/python3", "-c", code])
    run("a measured table", [build / "hetab", "tabulate", "NGGAL", "-q", "-o", "measured.binary"])
    angles = "\n".join(f"0.55,{i},{r},180" for i in (10, 30, 60) for r in range(0, 86, 5))
    points = subprocess.run([build / "hetab", "eval", "BBQAL2"], capture_output=True, text=True, env=environment,
                            input="lambda_um,theta_i_deg,theta_r_deg,phi_deg\n" + angles + "\n").stdout.splitlines()
    names = points[0].split(",")
    columns = [names.index(n) for n in ("lambda_um", "theta_i_deg", "theta_r_deg", "phi_deg", "total")]
    rows = [[line.split(",")[c] for c in columns] for line in points[1:]]
    (work / "paint.csv").write_text("lambda_um,theta_i_deg,theta_r_deg,phi_deg,brdf\n" +
                                    "".join(",".join(row) + "\n" for row in rows))


def shell(body):
    for line in body.splitlines():
        line = line.split("  #")[0].rstrip()
        if line.startswith("make "):
            target = line.split()[1]
            if target == "demo":
                run(line, [root / "scripts/demo", build / "hetab", "out"])
            tell(re.search(rf"^{target}:", (root / "Makefile").read_text(), re.M), line, "no such target")
            continue
        line = re.sub(r"^(hetab bench.*)", r"\1 --samples 100 --repeats 1", line)  # a minute of timing otherwise
        if line and not line.startswith(("git ", "cd ", "srun ", "pip ")):
            run(line, ["bash", "-ec", line], stdin=subprocess.DEVNULL)


def c(body, number):
    folder = work
    if "int main" in body:  # its files are not there yet
        folder = work / str(number)
        folder.mkdir()
    else:
        includes = "".join(re.findall(r"^#include .*\n", body, re.M))
        body = (f"#include <stdio.h>\n{includes}int main(void) {{\n" + re.sub(r"^#include .*\n", "", body, flags=re.M) +
                "return 0;\n}\n")
    (work / f"{number}.c").write_text(body)
    sanitizer = ["-fsanitize=address,undefined"] if "libasan" in os.environ.get("LD_PRELOAD", "") else []
    run(f"C block {number}", ["cc", *sanitizer, "-std=c11", "-Wall", "-Wextra", "-Werror", "-Wno-unused-variable",
                              "-Wno-unused-but-set-variable", f"-I{root}/include", f"{number}.c", f"-L{work}", "-lhetab",
                              "-lm", "-o", f"{number}.program"])
    if (work / f"{number}.program").exists():
        run(f"C program {number}", [work / f"{number}.program"], cwd=folder)


with tempfile.TemporaryDirectory() as folder:
    work = pathlib.Path(folder)
    environment = os.environ | {"PATH": f"{build}:{os.environ['PATH']}", "LD_LIBRARY_PATH": folder,
                                "PYTHONPATH": f"{root}/src/python", "HETAB_LIBRARY": str(build / "libhetab.so"),
                                "MPLBACKEND": "agg"}
    for name in build.glob("libhetab.so*"):
        shutil.copy(name, work)
    header = subprocess.run(["objdump", "-p", work / "libhetab.so"], capture_output=True, text=True).stdout
    soname = re.search(r"SONAME\s+(\S+)", header).group(1)
    if not (work / soname).exists():
        (work / soname).symlink_to("libhetab.so")
    fixtures()
    for number, (language, body) in enumerate(blocks):
        if language == "yaml":
            (work / re.match(r"# ([\w.]+)", body).group(1)).write_text(body)
    for number, (language, body) in enumerate(blocks):
        if language == "sh":
            shell(body)
        elif language == "c":
            c(body, number)
        elif language == "python" and "mi." not in body:
            run(f"Python block {number}", ["/usr/bin/python3", "-c", body])
lines = text.count("\n")
tell(lines <= 200, "README.md", f"{lines} lines, at most 200")
print(f"{counts['passed']} passed, {counts['failed']} failed, {counts['skipped']} skipped")
sys.exit(counts["failed"] > 0)
