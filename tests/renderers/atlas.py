"""Opens OpenEXR atlases in OpenImageIO, in OpenCV and in a shader; see scripts/test_renderers.

usage: atlas.py BUILD FOLDER

Every texel is compared with the engine's table, which tinyexr reads from a file of many parts, within
half floats' rounding; and what scripts/exr_atlas.glsl makes of the texels in headless Chromium, at the
nodes and between them, with the same interpolation in double."""
import base64
import os
import re
import subprocess
import sys

os.environ["OPENCV_IO_ENABLE_OPENEXR"] = "1"
import cv2
import numpy
import OpenImageIO

from browser import chromium, present

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.dirname(HERE))
from exr_parts import load

BUILD, FOLDER = sys.argv[1:3]
GRIDS = {"even": ("0:90:31", "0:90:31", "0:180:61"), "cells": ("cells:20", "0:80:9", "cells:30"),
         "one": ("30", "0:90:46", "0:180:91")}
BOUNDS = {"half": 1.0, "rho_s": 0.0, "shader": 5e-5}
PAGE = """<script type="x" id="shader">#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D points;
out vec4 said;
%s
void main() {
  vec3 p = texelFetch(points, ivec2(gl_FragCoord.xy), 0).xyz;
  said = vec4(atlas_brdf(p.x, p.y, p.z), 1);
}
</script><script>
const bytes = text => Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer;
const gl = document.createElement('canvas').getContext('webgl2');
gl.getExtension('EXT_color_buffer_float');
function texture(unit, inside, format, type, width, height, data) {
  const made = gl.createTexture();
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(gl.TEXTURE_2D, made);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.texImage2D(gl.TEXTURE_2D, 0, inside, width, height, 0, format, type, data);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  return made;
}
const program = gl.createProgram();
for (const [kind, text] of [[gl.VERTEX_SHADER, `#version 300 es
void main() { gl_Position = vec4(gl_VertexID %% 2 * 4 - 1, gl_VertexID / 2 * 4 - 1, 0, 1); }`],
                            [gl.FRAGMENT_SHADER, document.getElementById('shader').textContent]]) {
  const shader = gl.createShader(kind);
  gl.shaderSource(shader, text);
  gl.compileShader(shader);
  document.title += gl.getShaderInfoLog(shader);
  gl.attachShader(program, shader);
}
gl.linkProgram(program);
gl.useProgram(program);
const place = name => gl.getUniformLocation(program, name), [width, height, rows] = %s;
texture(0, gl.RGB16F, gl.RGB, gl.HALF_FLOAT, width, height, new Uint16Array(bytes('%s')));
texture(1, gl.RGBA32F, gl.RGBA, gl.FLOAT, 256, rows, new Float32Array(bytes('%s')));
const said = texture(2, gl.RGBA32F, gl.RGBA, gl.FLOAT, 256, rows, null);
gl.uniform1i(place('atlas'), 0);
gl.uniform1i(place('points'), 1);
gl.uniform4iv(place('atlas_count'), %s);
gl.uniform3fv(place('atlas_first'), %s);
gl.uniform3fv(place('atlas_per_degree'), %s);
gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, said, 0);
gl.viewport(0, 0, 256, rows);
gl.drawArrays(gl.TRIANGLES, 0, 3);
const values = new Float32Array(4 * 256 * rows);
gl.readPixels(0, 0, 256, rows, gl.RGBA, gl.FLOAT, values);
document.write('<pre>' + Array.from(values, v => v.toPrecision(9)).join(' ') + '</pre>');
</script>"""
missed = []


def judge(what, value, bound):
    print(f"atlas, {what}: {value:.2g}, bound {bound:g}")
    if not value <= bound:
        missed.append(what)


def write(name):
    """(table[theta_i][theta_r][phi][rgb], rho_s[rgb][theta_i]), and the atlas's file."""
    grid = [word for pair in zip(("--theta-i", "--theta-r", "--phi"), GRIDS[name]) for word in pair]
    paths = [os.path.join(FOLDER, f"{name}.{layout}.exr") for layout in ("theta_i", "atlas")]
    for path in paths:
        subprocess.run([os.path.join(BUILD, "hetab"), "tabulate", "BBQAL2", *grid, "--force", "--quiet",
                        "--exr-layout", path.split(".")[-2], "-o", path], check=True)
    with open(paths[0][:-4] + ".txt", "w", encoding="ascii") as text:
        subprocess.run([os.path.join(BUILD, "tests/exr_readback"), paths[0], paths[0][:-4] + ".bin"],
                       check=True, stdout=text)
    parts = load(paths[0][:-4])
    delta = parts.pop("specular_reflectance")
    rho = [delta[c][0] for c in "RGB"]
    table = numpy.array([[part[c] for c in "RGB"] for part in parts.values()])
    return table.transpose(0, 2, 3, 1), numpy.array(rho), paths[1]


def tiles(pixels, across, shape):
    """An atlas's pixels as a table."""
    down = pixels.shape[0] // shape[1]
    cut = pixels.reshape(down, shape[1], across, shape[2], 3).swapaxes(1, 2)
    return cut.reshape(-1, *shape[1:])[:shape[0]]


def half_steps(found, table):
    """The largest difference, in halves of what half floats resolve."""
    return numpy.max(numpy.abs(found - table) / numpy.maximum(numpy.abs(table) * 2**-11, 2**-25))


def interpolate(table, at):
    at = numpy.clip(at, 0, numpy.array(table.shape[:3]) - 1)
    low, total, scale = at.astype(int), 0, 0
    for corner in range(8):
        high = numpy.array([corner >> k & 1 for k in range(3)])
        node = numpy.minimum(low + high, numpy.array(table.shape[:3]) - 1)
        value = table[node[:, 0], node[:, 1], node[:, 2]].astype("f8")
        total = total + numpy.prod(numpy.where(high, at - low, 1 - at + low), axis=1)[:, None] * value
        scale = numpy.maximum(scale, numpy.abs(value).max(axis=1, keepdims=True))
    return total, scale


def shader(table, pixels, across, axes):
    """The largest error of the look-up, relative to the largest of the values around."""
    counts = [len(a) for a in axes]
    per = [(len(a) - 1) / (a[-1] - a[0]) if len(a) > 1 else 0.0 for a in axes]
    nodes = numpy.stack(numpy.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    random = numpy.random.default_rng(1).uniform((0, 0, -360), (90, 90, 720), (20000, 3))
    degrees = numpy.concatenate([nodes, random])
    rows = -(-len(degrees) // 256)
    points = numpy.zeros((256 * rows, 4), "f4")
    points[:len(degrees), :3] = numpy.radians(degrees)
    with open(os.path.join(HERE, "../../scripts/exr_atlas.glsl"), encoding="ascii") as file:
        text = PAGE % (file.read(), [*pixels.shape[1::-1], rows],
                       base64.b64encode(pixels.astype("f2").tobytes()).decode(),
                       base64.b64encode(points.tobytes()).decode(), [*counts, across],
                       [float(a[0]) for a in axes], per)
    page = os.path.join(FOLDER, "atlas.html")
    with open(page, "w", encoding="ascii") as file:
        file.write(text)
    answer = chromium("--dump-dom", "file://" + os.path.abspath(page))
    said = numpy.array(re.search("<pre>([^<']+)</pre>", answer)[1].split(), "f8").reshape(-1, 4)
    folded = numpy.degrees(points[:len(degrees), :3].astype("f8"))
    folded[:, 2] = numpy.abs((folded[:, 2] + 180) % 360 - 180)
    expected, scale = interpolate(table, (folded - [a[0] for a in axes]) * per)
    return numpy.max(numpy.abs(said[:len(degrees), :3] - expected) / numpy.maximum(scale, 2**-14))


def check(name):
    table, rho, path = write(name)
    image = OpenImageIO.ImageInput.open(path)
    spec = image.spec()
    if (spec.channelnames, str(spec.format)) != (("R", "G", "B"), "half") or image.seek_subimage(1, 0):
        missed.append("one part, R G B in half")
    across = int(spec.getattribute("tiles_across"))
    pixels = numpy.array(image.read_image("float"))
    opencv = cv2.imread(path, cv2.IMREAD_UNCHANGED)[:, :, ::-1]
    for reader, read in (("OpenImageIO", pixels), ("OpenCV", opencv)):
        judge(f"{name}, {table.size} numbers in {reader}, in rounding errors of half",
              half_steps(tiles(read, across, table.shape), table), BOUNDS["half"])
    judge(f"{name}, rho_s", max(numpy.abs(numpy.array(
        spec.getattribute(f"specular_reflectance_{c}")) - r).max() for c, r in zip("RGB", rho)),
        BOUNDS["rho_s"])
    axes = [numpy.atleast_1d(spec.getattribute(f"{a}_deg")) for a in ("theta_i", "theta_r", "phi")]
    if present():
        judge(f"{name}, exr_atlas.glsl", shader(tiles(pixels, across, table.shape), pixels, across, axes),
              BOUNDS["shader"])


for each in GRIDS:
    check(each)
if not present():
    print("skip: the test of exr_atlas.glsl needs Debian's chromium")
for what in missed:
    print(f"MISSED atlas: {what}")
sys.exit(bool(missed))
