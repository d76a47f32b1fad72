"""What gait figures are made of: results of walks; what subject, standing trial and files say."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from ..data import Events, Finding
from ..data.gait_curves import KeyValue
from ..data.strides import FootEvent, Stride
from ..data.subject_measures import Side, SubjectMeasures
from ..gait.emg import Emg
from ..gait.gait_trial import GaitTrial
from ..gait.marker_doubts import MarkerDoubts
from ..gait.marker_leaps import MarkerLeaps
from ..gait.marker_spikes import MarkerSpikes
from ..gait.plate_doubts import PlateDoubt
from ..gait.static_axes import AxesShown
from ..gait.static_checks import FeetTaken, StaticDoubt
from ..gait.treadmill import STILL, Floor
from .gait_subjects import BodyOfTrial


class GaitOfTrial(NamedTuple):
    """One trial's results.

    Attributes:
        name: of the trial. gait: segments, loads, signals. events: feet's. strides: between them.
        file_events: that the trial had; start_s: of its first frame on their clock. emg: by channel.
        way: "level", "running", "stairs", "backward" or "to and fro". first_frame: its number in the recording.
        floor: how it moves. keys: key values of its strides that count. leaps: of its markers.
        names, plates: what of its names and its plates cannot be. bare: the side whose leg has no marker.
        unseen: markers of the model, of other sides, that it names and no frame shows.
        no_emg: why channels cannot be read as EMG, by name. spikes: samples of markers that were left out.
    """

    name: str
    gait: GaitTrial
    events: tuple[FootEvent, ...]
    strides: tuple[Stride, ...]
    file_events: Events
    start_s: float
    emg: Mapping[str, Emg]
    way: str = "level"
    first_frame: int = 1
    floor: Floor = STILL
    keys: tuple[KeyValue, ...] = ()
    leaps: MarkerLeaps = MarkerLeaps()
    names: MarkerDoubts = MarkerDoubts()
    plates: tuple[PlateDoubt, ...] = ()
    bare: Side | None = None
    unseen: tuple[str, ...] = ()
    no_emg: Mapping[str, str] = {}
    spikes: MarkerSpikes = MarkerSpikes()

    @property
    def counted(self) -> tuple[Stride, ...]:
        """Strides that count in means and curves."""
        return tuple(one for one in self.strides if one.counts)


class HipsShown(NamedTuple):
    """Hips that a motion has shown.

    Attributes:
        trial: its name. way: "score" or "spheres". sd_mm: standard uncertainty along an axis, of both hips.
        away_mm: of the farther hip from where the regression has it.
    """

    trial: str
    way: str
    sd_mm: float
    away_mm: float


class StaticAxes(NamedTuple):
    """Axes of knees and ankles that a standing trial has shown.

    Attributes:
        trial: its name. way: "devices" or "markers". doubts: what of it contradicts itself.
    """

    trial: str
    way: AxesShown
    doubts: tuple[StaticDoubt, ...]


class ClustersShown(NamedTuple):
    """Segments that clusters have carried.

    Attributes:
        trial: that calibrated them. misfit_mm: by segment, RMS distance of a marker from where its cluster has it.
        by_names: markers by segment of those that nobody stated.
    """

    trial: str
    misfit_mm: Mapping[str, float]
    by_names: Mapping[str, Sequence[str]] = {}


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredSubject:
    """Whose gait it is.

    Attributes:
        name: of the subject; empty where nobody states it. measures: with offsets of the feet.
        estimated: "legs" and "mass", where nobody measured them; "knees" and "ankles", where markers do not show their
            widths either. hips: that a motion has shown; None where there is none.
    """

    name: str
    measures: SubjectMeasures
    estimated: Sequence[str] = ()
    hips: HipsShown | None = None


@dataclass(frozen=True, slots=True, eq=False)
class StandingShown:
    """What a standing trial has shown.

    Attributes:
        name: of the trial; None where there is none. axes: of knees and ankles. clusters: that carried segments.
        heels: that were taken from it. feet: how its own program took them, where it is the other way.
    """

    name: str | None = None
    axes: StaticAxes | None = None
    clusters: ClustersShown | None = None
    heels: Sequence[str] = ()
    feet: FeetTaken | None = None


@dataclass(frozen=True, slots=True, eq=False)
class GivenFiles:
    """What the files say besides motion.

    Attributes:
        paths: of the walks, by their names. subjects: that each file states, by its name; empty where it states none.
        renamed: the files' names of markers by the model's, where they differ. bodies: that the files show.
        left_out: what is told of walks that do not count.
    """

    paths: Mapping[str, str] = field(default_factory=dict)
    subjects: Mapping[str, str] = field(default_factory=dict)
    renamed: Mapping[str, str] = field(default_factory=dict)
    bodies: Sequence[BodyOfTrial] = ()
    left_out: Sequence[Finding] = ()
