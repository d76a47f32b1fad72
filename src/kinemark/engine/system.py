"""What Kinemark runs on: versions, threads, and whether the compiled library does the work or NumPy."""

from __future__ import annotations

import ctypes
import hashlib
import importlib
import os
import platform
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .. import native
from ..numerics.blas_threads import THREADS
from ..version import __version__

THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
"""Environment variables that limit the threads of BLAS."""

THREAD_FUNCTIONS = (
    "scipy_openblas_get_num_threads64_",
    "scipy_openblas_get_num_threads",
    "openblas_get_num_threads64_",
    "openblas_get_num_threads",
    "MKL_Get_Max_Threads",
)
"""Functions of BLAS libraries that say how many threads they use."""


@dataclass(frozen=True, slots=True)
class System:
    """What Kinemark runs on.

    Attributes:
        kinemark, python, numpy, scipy: versions.
        platform: operating system and machine.
        processors: that this process may use.
        blas: name and version of NumPy's BLAS.
        blas_threads: it uses outside of Kinemark's own work; None where it does not say.
        work_threads: it uses in calibrations, runs and fills, whatever the environment says.
        thread_limits: the `THREAD_VARIABLES` that are set.
        native: whether the compiled library runs, its path and version, or why NumPy does its work.
    """

    kinemark: str
    python: str
    numpy: str
    scipy: str
    platform: str
    processors: int
    blas: str
    blas_threads: int | None
    work_threads: int
    thread_limits: dict[str, str]
    native: native.Status

    def figures(self) -> dict[str, Any]:
        """The same for a machine."""
        path, version, reason = self.native
        own = {"runs": "compiled" if path else "numpy", "path": str(path) if path else None}
        return asdict(self) | {"native": own | {"version": version, "reason": reason or None}}

    def text(self) -> str:
        """The same for a reader."""
        path, version, reason = self.native
        runs = f"compiled library, version {version}: {path}" if path else f"NumPy: {reason}"
        limits = "".join(f", {name}={value}" for name, value in self.thread_limits.items())
        threads = "unknown" if self.blas_threads is None else self.blas_threads
        lines = {
            "kinemark": self.kinemark,
            "inner loops": runs,
            "Python": self.python,
            "NumPy": self.numpy,
            "SciPy": self.scipy,
            "BLAS": f"{self.blas}, threads: {threads}{limits}; {self.work_threads} in calibrate, run and fill",
            "processors": self.processors,
            "platform": self.platform,
        }
        return "\n".join(f"{name + ':':<13}{value}" for name, value in lines.items())


def system() -> System:
    """What Kinemark runs on now."""
    from importlib import metadata  # takes long to import, and only this needs it

    return System(
        kinemark=__version__,
        python=f"{platform.python_implementation()} {platform.python_version()}",
        numpy=np.__version__,
        scipy=metadata.version("scipy"),
        platform=platform.platform(),
        processors=_processors(),
        blas=_blas(),
        blas_threads=_blas_threads(),
        work_threads=THREADS,
        thread_limits={name: os.environ[name] for name in THREAD_VARIABLES if name in os.environ},
        native=native.status(),
    )


def absence_notice(folder: Path | None = None) -> str | None:
    """A line that says that the compiled library is absent, and why: once for each installation and reason.

    None where the library is there, where `KINEMARK_PLAIN` asks for NumPy, and where it was said before, which a file
    in the user's cache folder remembers. Where that cannot be written it is said by every process.

    Args:
        folder: where it is remembered; None: the user's cache folder.
    """
    reason = native.status().reason
    if not reason or os.environ.get(native.PLAIN):
        return None
    key = hashlib.sha256(f"{Path(native.__file__).parent}\n{reason}".encode()).hexdigest()[:16]
    try:
        folder = folder or _cache_folder()
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"no-library-{key}").touch(exist_ok=False)
    except FileExistsError:
        return None
    except (OSError, RuntimeError):  # read-only, or nobody's home
        pass
    return (
        f"{reason}. NumPy does its work with the same results, but takes longer. Install a C compiler and then "
        "Kinemark again. (ReadOptions once; `kinemark info --system` says what runs.)"
    )


def _cache_folder() -> Path:
    """Where programs of this user keep what can be made again.

    Raises:
        RuntimeError: the user has no home.
    """
    if os.name == "nt":
        base = os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local"
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    else:
        base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "kinemark"


def _processors() -> int:
    """Processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _blas() -> str:
    """Name and version of the BLAS that NumPy was built with."""
    config: Any = np.show_config(mode="dicts")
    blas = config.get("Build Dependencies", {}).get("blas", {})
    return f"{blas.get('name', 'unknown')} {blas.get('version', '')}".strip()


def _blas_threads() -> int | None:
    """Threads that NumPy's BLAS uses; None where it does not say.

    NumPy's linear algebra is linked with its BLAS, so that the system's loader finds the functions of the one through
    the other.
    """
    try:
        linked = ctypes.CDLL(str(importlib.import_module("numpy.linalg._umath_linalg").__file__))
    except (ImportError, OSError):
        return None
    for name in THREAD_FUNCTIONS:
        if hasattr(linked, name):
            return int(getattr(linked, name)())
    return None
