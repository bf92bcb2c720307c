"""The wheel: the package with the built library, and the headers that declare it, inside."""
import os
import pathlib
import re
import shutil

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py
from wheel.bdist_wheel import bdist_wheel

CHECKOUT = pathlib.Path(__file__).resolve().parents[2]
LIBRARY = CHECKOUT / os.environ.get("BUILD", "build") / "libhetab.so"


class WithLibrary(build_py):
    def run(self):
        super().run()
        if not LIBRARY.exists():
            raise SystemExit(f"{LIBRARY} is not there: run make in {CHECKOUT} first")
        package = pathlib.Path(self.build_lib) / "hetab"
        shutil.copytree(CHECKOUT / "include" / "hetab", package / "include", dirs_exist_ok=True)
        shutil.copy2(LIBRARY, package)


class OfThisPlatform(bdist_wheel):
    """The library is of this machine's kind; Python of any version loads it."""

    def get_tag(self):
        return "py3", "none", super().get_tag()[2]


class WithMachineCode(Distribution):
    def has_ext_modules(self):
        return True


setup(name="hetab",
      version=re.search(r"^VERSION := (\S+)", (CHECKOUT / "Makefile").read_text(), re.M)[1],
      description="Tables of the He-Torrance reflectance model",
      license="MIT", python_requires=">=3.9", install_requires=["cffi>=1.15", "numpy>=1.20"],
      packages=["hetab"], package_data={"hetab": ["py.typed"]}, distclass=WithMachineCode,
      cmdclass={"build_py": WithLibrary, "bdist_wheel": OfThisPlatform})
