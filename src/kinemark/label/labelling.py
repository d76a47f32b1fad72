"""How the markers of a session are named: by which method, from whose trials."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from ..data.method import Method, parameter
from .distances import Distances


@dataclass(frozen=True, slots=True)
class Labelling(Method):
    """What goes for all methods of labelling a session.

    Attributes:
        method: one of the stage's methods. name: of it.
    """

    method: Any = field(default_factory=Distances)
    name: str = "distances"
    template: tuple[str, ...] = parameter(
        (), meaning="files of labelled trials that move, of any program, beside session.toml"
    )
    static: tuple[str, ...] = parameter((), meaning="files of labelled static trials, which show no motion")
    markers: tuple[str, ...] = parameter(
        (), meaning="names to learn; empty: those of marker_set, else all that were not computed of others"
    )
    height_mm: float | None = parameter(
        None,
        unit="mm",
        above=0,
        meaning="height of the subject, where the files are of another one, or there is nothing but marker_set",
    )
    template_height_mm: float | None = parameter(
        None, unit="mm", above=0, meaning="height of the one whom the files are of"
    )
    grow: bool = parameter(True, meaning="each trial that was labelled and accepted adds to the template of the next")
    names: str | None = parameter(
        None, meaning="CSV of names stated by hand: trial, frame, x_mm, y_mm, z_mm, name; they are facts"
    )
    second_pass: bool = parameter(
        True,
        meaning="judge the points of tracks by the named body, and look for markers where it expects them; where "
        "[track] has the tracker `simultaneous`",
    )
    unsure: bool = parameter(False, meaning="also take names that are not sure")

    def check_together(self) -> None:
        """Refuse the height of another subject without that of this one."""
        if self.height_mm is None and self.template_height_mm is not None:
            raise ValueError(
                "template_height_mm is given without height_mm: give both, or none where it is one subject"
            )

    @property
    def scale(self) -> float | None:
        """How many times as tall the subject is as the one whom the files are of; None where they are one."""
        if self.height_mm is None or self.template_height_mm is None:
            return None
        return self.height_mm / self.template_height_mm
