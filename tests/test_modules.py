"""Each module can be the first that is imported: it does not count on another having been imported before."""

import pkgutil
import subprocess
import sys

import pytest

import kinemark

FIRST = """
import importlib, sys
for name in sys.argv[1:]:
    for known in [known for known in sys.modules if known.split(".")[0] == "kinemark"]:
        del sys.modules[known]
    try:
        importlib.import_module(name)
    except ImportError as error:
        print(f"{name}: {error}")
"""
PACKAGES = sorted(module.name for module in pkgutil.iter_modules(kinemark.__path__) if module.ispkg)


@pytest.mark.nightly
@pytest.mark.parametrize("package", PACKAGES)
def test_each_module_can_be_imported_first(package):
    folder = [f"{path}/{package}" for path in kinemark.__path__]
    found = pkgutil.walk_packages(folder, f"kinemark.{package}.")
    names = [f"kinemark.{package}", *(module.name for module in found if not module.name.endswith("._native"))]  # C
    done = subprocess.run([sys.executable, "-c", FIRST, *names], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, ""), done.stderr
