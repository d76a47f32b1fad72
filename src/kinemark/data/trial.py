"""All of one capture, and whose it is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from .analog import Analog, ForcePlate
from .arrays import set_columns
from .events import Events
from .poses import Poses
from .short_repr import ShortRepr
from .signals import Signals
from .trajectories import Trajectories

UP = "up"
"""Of what is known of a capture: the axis that goes up."""


@dataclass(frozen=True, slots=True)
class Identity:
    """What a recording says of itself, or the user of it; empty where nobody says it.

    Attributes:
        subject: who was recorded, as a name or a code.
        date: of the recording, YYYY-MM-DD.
        file_date: when its file was last changed, YYYY-MM-DD, which copying may alter.
    """

    subject: str = ""
    date: str = ""
    file_date: str = ""


@dataclass(frozen=True, slots=True)
class Step:
    """One stage as it was run: enough to tell whether it must be run again.

    Attributes:
        stage: "detect", "match", …
        method: name of the method; parameters: its fields.
        version: of Kinemark.
        input: hash of all that went in.
        seconds: how long it took.
    """

    stage: str
    method: str
    parameters: Mapping[str, Any]
    version: str
    input: str
    seconds: float


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Trial(ShortRepr):
    """One capture.

    Attributes:
        name: of the trial.
        trajectories: the markers, and nothing else.
        analog: channels as they were recorded, each record at its own rate and from its own start.
        plates: force plates; events.
        source: what the file held besides, in that file format's own record, so that writing gives it back.
        steps: how the trial was made.
        signals: angles, moments, powers, forces and other quantities that were computed.
        poses: of segments, each record at its own rate.
        about: what else is known of the capture, by name: "date", "subject", …; "up", the axis of the world that goes
            up, as "+Y", where it is not +Z.
        notes: what was odd in the file and how it was read, in words; only HDF5 keeps them.
    """

    name: str
    trajectories: Trajectories
    analog: tuple[Analog, ...] = ()
    plates: tuple[ForcePlate, ...] = ()
    events: Events = field(default_factory=Events)
    source: Any = None
    steps: tuple[Step, ...] = ()
    signals: Signals = field(default_factory=Signals)
    poses: tuple[Poses, ...] = ()
    about: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        tuples = {name: tuple(getattr(self, name)) for name in ("analog", "plates", "steps", "poses", "notes")}
        set_columns(self, **tuples)

    def frames(self, first: int, stop: int) -> Trial:
        """Frames first … stop − 1, counted from 0; channels, signals and poses stay whole and start so much earlier."""
        first, stop, _ = slice(first, stop).indices(self.trajectories.n_frames)
        earlier = first / self.trajectories.rate
        zero = [None if plate.zero_frames is None else plate.zero_frames - first for plate in self.plates]
        return replace(
            self,
            trajectories=self.trajectories.frames(first, stop),
            analog=tuple(replace(a, start=a.start - earlier) for a in self.analog),
            plates=tuple(replace(p, zero_frames=own) for p, own in zip(self.plates, zero, strict=True)),
            poses=tuple(replace(p, start=p.start - earlier) for p in self.poses),
            signals=Signals(tuple(replace(s, start=s.start - earlier) for s in self.signals)),
        )
