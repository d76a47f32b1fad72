"""The files of a gait report: one of each recording, a name for each trial, and none that is overwritten."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

from ...data import KinemarkError
from ...data.subject_measures import SubjectMeasures
from ...gait.clusters import Clusters
from ...io.measures_toml import read_measures
from ..folders import RECORDINGS


@dataclass(frozen=True)
class SubjectFiles:
    """What is given of one subject.

    Attributes:
        walks: trials with named markers; a recording that is given twice counts once.
        left_out: files of the same recordings in another format, which are told and kept.
        static: a standing trial, for the feet.
        functional: a motion that turns the hips in all directions, which shows their centres.
        mvc: of the muscles' greatest contractions, which are 100 % of the EMG.
        measures: the subject's, or a TOML file of them; as the files state them, else estimated, where none are given.
        reference: band of controls, drawn grey, and scored against.
        markers: the files' names of markers by the gait model's, where they are neither those nor usual ones.
        clusters: names of markers by the segment that they carry, one of `gait.clusters.SEGMENTS`; need a static trial.
    """

    walks: Sequence[Path]
    left_out: Sequence[Path] = ()
    static: Path | None = None
    functional: Path | None = None
    mvc: Path | None = None
    measures: Path | SubjectMeasures | None = None
    reference: Path | None = None
    markers: Mapping[str, str] = field(default_factory=dict)
    clusters: Clusters = field(default_factory=dict)

    def once(self) -> SubjectFiles:
        """Each walk once, as it was given first."""
        return replace(self, walks=list({path.resolve(): path for path in reversed(self.walks)}.values())[::-1])

    @cached_property
    def names(self) -> dict[Path, str]:
        """Of the trials, by their resolved paths."""
        return trial_names([*self.walks, *(path for path in (self.static, self.functional) if path is not None)])

    def name(self, path: Path) -> str:
        """Of a walk, of the standing trial or of the motion of the hips."""
        return self.names[path.resolve()]

    def every(self) -> list[Path]:
        """All that must stay as it is."""
        stated = self.measures if isinstance(self.measures, Path) else None
        others = (self.static, self.functional, stated, self.reference, self.mvc)
        return [*self.walks, *self.left_out, *(path for path in others if path is not None)]

    def stated_measures(self) -> SubjectMeasures | None:
        """The subject's measures as they are given; None where they are not.

        Raises:
            KinemarkError: their file cannot be read.
        """
        return read_measures(self.measures) if isinstance(self.measures, Path) else self.measures


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


def check_targets(targets: Iterable[Path], given: Iterable[Path]) -> None:
    """See that no file of the results is one that was given.

    Raises:
        KinemarkError: one is.
    """
    kept = {path.resolve() for path in given}
    if lost := [path for path in targets if path.resolve() in kept]:
        raise KinemarkError(
            f"The results would overwrite {lost[0]}, which was given. Nothing was written. "
            "Give them a folder without recordings: -o results."
        )
