"""`dev.py` shows that it is alive while it installs."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
STUDIO = "import sys; sys.path.insert(0, {root!r}); import dev; print(dev.EXTRAS['studio'])"
PIP = """
import sys, time
print("Collecting numpy", flush=True)
print("  Downloading numpy.whl (16 MB)", flush=True)
time.sleep(0.5)
print("Installing collected packages: numpy", flush=True)
sys.exit({status})
"""


def told(status):
    """What is printed of an installation that is silent for half a second, and how it ends."""
    code = (
        f"import sys; sys.path.insert(0, {str(ROOT)!r}); import dev; dev.EVERY_S = 0.1; "
        f"dev.run_told(sys.executable, '-c', {PIP.format(status=status)!r})"
    )
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)


def test_an_installation_shows_what_it_does_and_that_it_is_alive():
    done = told(0)
    assert not done.returncode, done.stderr
    assert "Downloading numpy.whl" in done.stdout and "Installing collected" in done.stdout
    assert "Collecting" not in done.stdout.replace("still at work: Collecting", "")
    assert "still at work" in done.stdout
    assert done.stdout.rstrip().endswith("installed")


def test_an_installation_that_fails_shows_all_that_was_said():
    done = told(3)
    assert done.returncode == 3
    assert "Collecting numpy" in done.stderr


def test_dev_needs_nothing_but_python():
    spec = importlib.util.spec_from_file_location("dev", ROOT / "dev.py")
    assert spec is not None
    text = (ROOT / "dev.py").read_text("utf-8")
    imported = {line.split()[1] for line in text.splitlines() if line.startswith(("import ", "from "))}
    assert imported <= set(sys.stdlib_module_names) | {"__future__"}


def test_what_is_compiled_is_kept_for_the_processes_that_tests_start(tmp_path):
    (tmp_path / "m.py").write_text("")
    start = "import subprocess; subprocess.run([sys.executable, '-c', 'import m'], check=True)"
    code = f"import sys; sys.path.insert(0, {str(ROOT)!r}); import dev; dev.keep_compiled(); {start}"
    environment = os.environ | {"PYTHONDONTWRITEBYTECODE": "1", "PYTHONPATH": str(tmp_path)}
    subprocess.run([sys.executable, "-c", code], env=environment, check=True, timeout=60)
    assert list(tmp_path.glob("__pycache__/m.*.pyc"))


def test_building_the_studio_installs_what_it_is_served_with():
    """`python3 dev.py demo`, then `studio`: a newcomer had the page and no server for it."""
    done = subprocess.run(
        [sys.executable, "-c", STUDIO.format(root=str(ROOT))], capture_output=True, text=True, check=True
    )
    assert set(done.stdout.strip().split(",")) == {"studio", "ui"}


def test_what_several_tasks_need_is_installed_once():
    code = (
        f"import sys; sys.path.insert(0, {str(ROOT)!r}); import dev; dev.install = print; dev.run = lambda *_: None; "
        "sys.argv = ['dev.py', 'docs']; dev.main()"
    )
    for said, extras in (("test,ui,docs", "test,ui,docs"), ("", "docs")):
        environment = os.environ | {"KINEMARK_EXTRAS": said}
        done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
        assert done.stdout.strip() == extras
