"""What cameras see of a stick waved about: the scenes of `benchmarks/bundle.py`, for tests."""

import importlib.util
import sys
from pathlib import Path

_path = Path(__file__).parents[2] / "benchmarks" / "bundle.py"
_spec = importlib.util.spec_from_file_location("benchmark_of_bundle", _path)
assert _spec is not None and _spec.loader is not None
benchmark = sys.modules["benchmark_of_bundle"] = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(benchmark)

ALONG, MIDDLE, sizes, waved = benchmark.ALONG, benchmark.MIDDLE, benchmark.sizes, benchmark.waved
