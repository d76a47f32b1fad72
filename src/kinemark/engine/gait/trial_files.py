"""The files of a gait report: one of each recording, a name for each trial, and none that is overwritten."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from ...data import KinemarkError
from ..folders import RECORDINGS


def one_of_each(found: Sequence[Path], named: Iterable[Path | None]) -> tuple[tuple[Path, ...], tuple[Path, ...]]:
    """The files without those that a folder holds in a second format, and these.

    Files of one name in one folder are one recording: a file that was named counts, else C3D before TRC, TDF and TSV.

    Args:
        found: all files. named: those that were named themselves, of any purpose; folders do not count.
    """
    own = {path.resolve() for path in named if path is not None}
    settled = {_recording(path) for path in own}
    best = {_recording(path): path.resolve() for path in sorted(found, key=_rank, reverse=True)}
    taken = own | {path for recording, path in best.items() if recording not in settled}
    left_out = tuple(path for path in found if path.resolve() not in taken)
    return tuple(path for path in found if path.resolve() in taken), left_out


def _recording(path: Path) -> tuple[Path, str]:
    return path.parent.resolve(), path.stem.casefold()


def _rank(path: Path) -> int:
    ending = path.suffix.lower()
    return RECORDINGS.index(ending) if ending in RECORDINGS else len(RECORDINGS)


def trial_names(paths: Iterable[Path]) -> dict[Path, str]:
    """A name of its own for each file, by the resolved path: its name without the ending, where no other has it.

    Else with its folder ("a_w"), else with its format ("w_c3d"), else with both, else with all folders.
    """
    files = {path.resolve(): path.parent.resolve() / path.name for path in paths}
    names = {key: path.stem for key, path in files.items()}
    for longer in (_with_folder, _with_format, _with_both, _with_all):
        count = Counter(name.casefold() for name in names.values())
        names = {key: longer(files[key]) if count[name.casefold()] > 1 else name for key, name in names.items()}
    return names


def _with_folder(path: Path) -> str:
    return f"{path.parent.name}_{path.stem}"


def _with_format(path: Path) -> str:
    return f"{path.stem}_{path.suffix.lstrip('.')}"


def _with_both(path: Path) -> str:
    return f"{path.parent.name}_{_with_format(path)}"


def _with_all(path: Path) -> str:
    return "_".join([*path.parent.parts[1:], _with_format(path)])


def check_targets(targets: Iterable[Path], given: Iterable[Path | None]) -> None:
    """See that no file of the results is one that was given.

    Raises:
        KinemarkError: one is.
    """
    kept = {path.resolve() for path in given if path is not None}
    if lost := [path for path in targets if path.resolve() in kept]:
        raise KinemarkError(
            f"The results would overwrite {lost[0]}, which was given. Nothing was written. "
            "Give them a folder without recordings: -o results."
        )
