"""No program or library of ours takes a function that rounds from the C library: those of framework/math are the same on every processor."""
import os
import pathlib
import re
import shutil
import subprocess
import unittest

from harness import HAS_DEVICES, IS_SANITIZED, LIBRARIES, ROOT, TACTOR

BUILD = pathlib.Path(os.environ.get("TACTOR_BUILD", ROOT / "build/release"))
# What the C library may be asked for: functions whose results are exact or rounded by the standard, of double, float and long double.
EXACT = """ceil floor trunc round lround llround rint lrint llrint nearbyint roundeven fmod remainder remquo modf frexp ldexp scalbn scalbln
ilogb logb fabs fmin fmax fdim copysign nextafter nexttoward sqrt fma signbit isnan isinf finite
feclearexcept fegetenv fegetexceptflag fegetround feholdexcept feraiseexcept fesetenv fesetexceptflag fesetround fetestexcept
feupdateenv feenableexcept fedisableexcept fegetexcept""".split()
EXACT = {name + end for name in EXACT for end in ("", "f", "l")}
# Boost's beta function in long double, for the confidence intervals of studies. No run computes with it.
OF_STUDIES = {"expl", "log1pl", "powl"}


def symbols(*options):
    result = subprocess.run(["nm", "-D", *map(str, options)], capture_output=True, text=True, check=True)
    return {line.split()[-1].partition("@")[0] for line in result.stdout.splitlines() if line.strip()}


def imports(file):
    return symbols("--undefined-only", file)


def libm():
    """The C library's mathematical functions: what any program of this machine would load."""
    said = subprocess.run(["ldd", TACTOR], capture_output=True, text=True, check=True).stdout
    return symbols("--defined-only", re.search(r"libm\.so\.6 => (\S+)", said)[1])


@unittest.skipIf(shutil.which("nm") is None, "nm of binutils is not installed")
@unittest.skipIf(IS_SANITIZED, "a sanitizer stands before some functions of the C library")
class Imports(unittest.TestCase):
    def test_nothing_imports_a_function_that_rounds(self):
        rounding = libm() - EXACT
        self.assertLessEqual({"sin", "pow", "cexp", "expf", "logl", "erf", "j0"}, rounding)
        files = [pathlib.Path(TACTOR), *(file for folder in ("lib", "bin", "python", "tests")
                                         for file in sorted((BUILD / folder).rglob("*.so")))]
        names = {file.name for file in files}
        self.assertLessEqual({"libtactor.so", "libtactor_prediction.so", "libtactor_collision.so"}, names)
        if HAS_DEVICES:
            self.assertIn("libtactor_usb.so", names)
        for file in files:
            with self.subTest(file=file.name):
                allowed = OF_STUDIES if file.name.startswith(("tactor", "_tactor")) else set()
                self.assertEqual(sorted(imports(file) & rounding - allowed), [], "compile it with tactor_flags, or add the function to framework/math")

    def test_nothing_shows_such_a_function_to_others(self):
        """Python, a BLAS and other libraries in the process keep their own."""
        for file in (LIBRARIES / "libtactor.so", LIBRARIES / "tactor/libtactor_prediction.so"):
            shown = symbols("--defined-only", file)
            self.assertEqual(shown & libm(), set(), file)


if __name__ == "__main__":
    unittest.main()
