"""A walk through the Python package, cell by cell; draws OUTPUT/python.png.

usage: PYTHONPATH=src/python python3 src/python/example.py [OUTPUT]        from the checkout"""
# %% A surface: a preset, a file, or the keys of one
import pathlib
import sys
import tempfile

import matplotlib
import numpy

import hetab

matplotlib.use("Agg")
import matplotlib.pyplot as plt

output = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
surface = hetab.Surface(sigma0_um=0.2, tau_um=2.5, index="Cu")
print(surface)
figure, axes = plt.subplots(2, 3, figsize=(10.6, 6.2), dpi=100)
(lobes, energy, look_up), (colours, scans, fitted) = axes

# %% The model at points: arrays in, arrays out
theta_r = numpy.linspace(-1.5, 1.5, 601)
for degrees in (0, 30, 60):
    values = hetab.evaluate(surface.points(numpy.radians(degrees), abs(theta_r),
                                           numpy.where(theta_r > 0, numpy.pi, 0.0), 0.55))
    lobes.semilogy(numpy.degrees(theta_r), values["total"], label=f"{degrees}°")
lobes.set(title="BRDF at 550 nm, 1/sr", xlabel="θr, degrees", ylim=(1e-4, 50))
lobes.legend(title="θi", frameon=False)

# %% Energy: the hemisphere's integral with its error, the delta, the polished bound
theta_i = numpy.radians(numpy.arange(0, 89.5, 1.0))
at_550 = hetab.Surface(sigma0_um=0.2, tau_um=2.5, index="Cu", wavelengths_nm=[550])
rho = hetab.reflectance(at_550, theta_i)[0]
for field, words in (("fresnel", "polished"), ("dh", "all"), ("specular", "delta")):
    energy.plot(numpy.degrees(theta_i), rho[field], label=words)
energy.set(title="reflectance at 550 nm", xlabel="θi, degrees", ylim=(0, 1))
energy.legend(frameon=False)
print("audit:", hetab.audit(at_550).verdict)

# %% A table in memory, with progress
table = hetab.tabulate(surface, "0:80:5", "0:85:86", "0:180:91", progress=lambda done, total: print(
    f"\rtabulated {100 * done / total:.0f} %", end="", flush=True))
print(f", largest error sampled {table.report.error.max_rel:.1e}")
plane = table.brdf[:, 2, :, -1]  # theta_i 40 degrees, phi 180
mesh = colours.pcolormesh(table.theta_r_deg, 1e3 * table.wavelengths_um, numpy.log10(plane),
                          vmin=-4, shading="nearest")
colours.set(title="log10 BRDF, θi = 40°", xlabel="θr, degrees", ylabel="wavelength, nm")
figure.colorbar(mesh, ax=colours)

# %% A table as a file, looked up as renderers do
with tempfile.TemporaryDirectory() as folder:
    path = pathlib.Path(folder) / "copper.h5"
    hetab.tabulate_to(surface, path)
    opened = hetab.open_table(path)
wi, random = (numpy.sin(0.7), 0, numpy.cos(0.7)), numpy.random.default_rng(1)
drawn, weight = opened.sample(wi, random.random(20_000), random.random((20_000, 2)), [0.55])
look_up.scatter(*drawn["wo"][:, :2].T, s=0.4, c=weight[:, 0], vmin=0, vmax=1.2)
look_up.set(title=f"samples; mean weight {weight.mean():.3f}", xlabel="x", ylabel="y",
            xlim=(-1, 1), ylim=(-1, 1), aspect="equal")

# %% The laboratory: roughness of (synthetic) height scans
spacing_um = 0.1
kernel = numpy.exp(-2 * (numpy.arange(-150, 151) * spacing_um / surface.tau_um) ** 2)
heights = numpy.array([numpy.convolve(random.standard_normal(20_300), kernel, "valid")
                       for _ in range(3)]) * surface.sigma0_um / (kernel @ kernel) ** 0.5
found = hetab.roughness(heights, spacing_um=spacing_um)
scans.plot(numpy.arange(600) * spacing_um, heights[0, :600])
scans.set(title=f"scan: σ {found.raw.sigma_um.mean:.3f}, τ {found.raw.tau_um.mean:.2f} µm",
          xlabel="µm", ylabel="height, µm")

# %% A fit to (synthetic, noisy) measurements
i, r = (a.ravel() for a in numpy.meshgrid(numpy.radians([20, 45, 60]), numpy.radians(
    numpy.arange(0, 80, 2.5)), indexing="ij"))
truth = hetab.evaluate(at_550.points(i, r, numpy.pi))["total"].T
noisy = truth * (1 + 0.03 * random.standard_normal(truth.shape))
fit = hetab.fit(hetab.measurements([0.55], i, r, numpy.pi, noisy), "Cu", slope=(0.02, 0.5),
                tau_um=surface.tau_um)
for k, degrees in enumerate((20, 45, 60)):
    part = slice(32 * k, 32 * (k + 1))
    fitted.semilogy(numpy.degrees(r[part]), noisy[part], ".", color=f"C{k}")
    fitted.semilogy(numpy.degrees(r[part]), fit.model[part, 0], color=f"C{k}")
fitted.set(title=f"slope {fit.slope:.4f} fitted, 0.08 put in", xlabel="θr, degrees",
           ylim=(1e-4, 50))

figure.tight_layout()
figure.savefig(output / "python.png")
