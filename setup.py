"""How the compiled library is built, and how wheels with and without it are named; all else is in pyproject.toml."""

import os
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py

FOLDER = "src/kinemark/native"


class BuildLibrary(build_ext):
    """Compiles a library that uses nothing of Python: it has one name for all versions and no module's entry point.

    What an earlier build left is removed first, so that it never stands for one that fails.
    """

    def run(self) -> None:
        """Compile, for a wheel or in place."""
        for ext in self.extensions:
            Path(self.get_ext_fullpath(ext.name)).unlink(missing_ok=True)
        super().run()

    def build_extension(self, ext: Extension) -> None:
        """Compile for a wheel, from where it is copied in place."""
        Path(self.get_ext_fullpath(ext.name)).unlink(missing_ok=True)
        super().build_extension(ext)

    def get_ext_filename(self, fullname: str) -> str:
        """Where the library goes."""
        return str(Path(*fullname.split("."))) + (".dll" if os.name == "nt" else ".so")

    def get_export_symbols(self, ext: Extension) -> list[str]:
        """None but those that the sources name."""
        return list(ext.export_symbols)

    def get_libraries(self, ext: Extension) -> list[str]:
        """None of Python's."""
        return list(ext.libraries)


class Sources(build_py):
    """Brings the studio's page where `dev.py studio` has built it; KINEMARK_SKIP_UI=1 leaves it out."""

    def find_data_files(self, package: str, src_dir: str) -> list[str]:
        """Files of a package besides its modules."""
        found: list[str] = super().find_data_files(package, src_dir)
        page = Path(src_dir, "page")
        skip = package == "kinemark.apps.studio" and os.environ.get("KINEMARK_SKIP_UI", "") not in ("", "0")
        return [path for path in found if not (skip and page in Path(path).parents)]


class Wheel(bdist_wheel):
    """py3-none-PLATFORM where the library was compiled, py3-none-any where it was not."""

    def run(self) -> None:
        """Compile first, so that the name of the wheel says what is in it."""
        self.run_command("build_ext")
        if not all(Path(path).is_file() for path in self.get_finalized_command("build_ext").get_outputs()):
            self.warn("no C compiler: this wheel has no compiled library, and NumPy will do its work")
            self.distribution.ext_modules = []
            self.root_is_pure = True
        super().run()

    def get_tag(self) -> tuple[str, str, str]:
        """Python, ABI and platform."""
        return "py3", "none", super().get_tag()[2]


setup(
    cmdclass={"build_ext": BuildLibrary, "build_py": Sources, "bdist_wheel": Wheel},
    ext_modules=[
        Extension(
            "kinemark.native._native",
            sources=[f"{FOLDER}/{name}.c" for name in ("clusters", "library", "motion", "pixels", "shapes", "views")],
            depends=[f"{FOLDER}/{name}.h" for name in ("native", "pixels_by_depth", "shape_light", "symmetric3")],
            # nobody asks for errno or for exceptions of floating point, and without fused products all processors
            # give the same; a compiler without these flags goes on
            extra_compile_args=["-O3", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=off"],
            optional=True,  # without a compiler NumPy does the work
        )
    ],
)
