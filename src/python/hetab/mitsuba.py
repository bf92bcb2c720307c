"""The material he_torrance for Mitsuba 3: import hetab.mitsuba.

    mi.set_variant("llvm_ad_rgb")
    import hetab.mitsuba
    mi.load_dict({"type": "he_torrance", "sigma0": 0.54, "tau": 6.5, "material": "Al"})

The source is the library's: what `hetab shader --language mitsuba` writes, and what is installed
under share/hetab/mitsuba. check(scene, integrator) says whether gradients are right there."""
from ._surface import shader

exec(compile(shader("mitsuba"), "he_torrance.py", "exec"))
