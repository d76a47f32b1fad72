"""What a chain of segments is made of: points, segments with axes, joints with a sequence of turns, clusters.

A model says how markers become axes and axes become angles; it holds no measurement. Models are written as TOML files
(`io.model_toml`), so that another convention is another file.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal

AXES = "xyz"
LABORATORY = "laboratory"
"""Parent of a joint that is measured against the room: x forward, y up, z to the right (ISB)."""
AUTO = "auto"
"""In place of the laboratory's axes: as the trial shows (`kinematics.chain`)."""
DIRECTIONS = tuple(sign + axis for sign in "+-" for axis in AXES)


@dataclass(frozen=True, slots=True)
class Axis:
    """One axis of a segment: the vector from one point to another, or the normal of two such vectors.

    Attributes:
        letter: "x", "y" or "z".
        points: (2) from, to; or (4) from, to, from, to: the first vector cross the second.
    """

    letter: str
    points: tuple[str, ...]

    def __post_init__(self) -> None:
        if self.letter not in tuple(AXES):
            raise ValueError(f"an axis is called {self.letter!r}, wanted x, y or z")
        if len(self.points) not in (2, 4):
            raise ValueError(f"axis {self.letter} has {len(self.points)} points, wanted 2 (from, to) or 4 (a normal)")
        ends = [self.points[i : i + 2] for i in range(0, len(self.points), 2)]
        if any(a == b for a, b in ends):
            raise ValueError(f"axis {self.letter} goes from {ends[0][0]} to itself")


@dataclass(frozen=True, slots=True)
class Segment:
    """A body with axes: `first` as it is, `second` made perpendicular to it, the third to both, right-handed."""

    name: str
    first: Axis
    second: Axis

    def __post_init__(self) -> None:
        if self.first.letter == self.second.letter:
            raise ValueError(f"segment {self.name}: both axes are {self.first.letter}, wanted two different ones")


MINUS = "minus "
"""Before a motion that has no word for its opposite."""


@dataclass(frozen=True, slots=True)
class JointMotion:
    """One angle of a joint in the words of anatomy.

    Attributes:
        positive, negative: what the joint does where the angle is above or below zero.
        normal: least and greatest angle of normal motion, deg; None where unknown.
    """

    positive: str
    negative: str
    normal: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if self.normal is not None and not self.normal[0] <= self.normal[1]:
            raise ValueError(f"the range of {self.positive} is {self.normal}, wanted the least angle first")

    def reversed(self) -> JointMotion:
        """The same of the angle with the other sign."""
        bare = self.positive.removeprefix(MINUS)
        opposite = self.negative or (bare if bare != self.positive else f"{MINUS}{self.positive}")
        normal = None if self.normal is None else (-self.normal[1], -self.normal[0])
        return JointMotion(opposite, self.positive if self.negative else "", normal)

    @property
    def name(self) -> str:
        """Both words, `flexion/extension`, or one where they are the same."""
        return self.positive if self.negative in ("", self.positive) else f"{self.positive}/{self.negative}"


@dataclass(frozen=True, slots=True)
class Joint:
    """How a child segment is turned against its parent.

    Attributes:
        parent, child: segments; the parent may be `LABORATORY`.
        sequence: the axes of the three turns, each as the turns before have left it: "zxy", "yxy".
        motions: (3) what the angles are called; None where the joint has no such degree of freedom.
        middle: sign of the middle angle in sequences that begin and end with the same axis.
        signs: (3) 1, or -1 for an angle that is turned round after it was read; `motions` are of what it then is.
    """

    name: str
    parent: str
    child: str
    sequence: str
    motions: tuple[JointMotion | None, ...] = (None, None, None)
    middle: Literal["positive", "negative"] = "positive"
    signs: tuple[int, int, int] = (1, 1, 1)

    def __post_init__(self) -> None:
        check_sequence(self.sequence)
        if len(self.signs) != 3 or not set(self.signs) <= {1, -1}:
            raise ValueError(f"joint {self.name}: signs are {list(self.signs)}, wanted three of 1 and -1")
        if len(self.motions) != 3:
            raise ValueError(f"joint {self.name} names {len(self.motions)} angles, wanted 3")
        if self.middle not in ("positive", "negative"):
            raise ValueError(f"joint {self.name}: middle is {self.middle!r}, wanted positive or negative")


@dataclass(frozen=True, slots=True)
class Cluster:
    """Markers on one rigid body, and the points of the body that a static trial gives and they carry."""

    name: str
    markers: tuple[str, ...]
    points: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if len(set(self.markers)) < 3:
            raise ValueError(f"cluster {self.name} has the markers {self.markers}, wanted three or more")


@dataclass(frozen=True, slots=True)
class Centre:
    """A joint's centre found from motion: the point that stays where it is in both clusters; the second carries it."""

    name: str
    between: tuple[str, str]


@dataclass(frozen=True, slots=True)
class Model:
    """A chain of segments.

    Attributes:
        name, source: what it is called and who described it.
        side: "left" mirrors the markers, so that the same axes and signs hold on both sides (Wu et al. 2005).
        forward, up: of the laboratory, such as "+x" and "+z"; both `AUTO` where the trial shows them.
        means: point → the points it is the mean of, in the order in which they can be worked out.
        aliases: marker → other names under which files may have it.
    """

    name: str
    segments: tuple[Segment, ...]
    joints: tuple[Joint, ...]
    source: str = ""
    side: Literal["right", "left"] = "right"
    forward: str = "+x"
    up: str = "+z"
    means: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    clusters: tuple[Cluster, ...] = ()
    centres: tuple[Centre, ...] = ()
    aliases: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    links: tuple[tuple[str, str], ...] = ()

    def __post_init__(self) -> None:
        for name in ("means", "aliases"):
            held = {k: tuple(v) for k, v in getattr(self, name).items()}
            object.__setattr__(self, name, MappingProxyType(held))
        _check_names(self)
        if self.side not in ("right", "left"):
            raise ValueError(f"side is {self.side!r}, wanted right or left")
        if {self.forward, self.up} == {AUTO}:
            return
        if not {self.forward, self.up} <= set(DIRECTIONS) or self.forward[1] == self.up[1]:
            raise ValueError(
                f"forward is {self.forward!r} and up is {self.up!r}, wanted two axes such as +x and +z, or {AUTO} twice"
            )

    @property
    def carried(self) -> frozenset[str]:
        """Points that clusters carry, so that a static trial is needed for them."""
        return frozenset(p for c in self.clusters for p in c.points) | {c.name for c in self.centres}

    @property
    def points(self) -> tuple[str, ...]:
        """The points that the axes and links stand on, each once."""
        named = [p for s in self.segments for axis in (s.first, s.second) for p in axis.points]
        named += [p for link in self.links for p in link]
        return tuple(dict.fromkeys(named))

    @property
    def markers(self) -> tuple[str, ...]:
        """The markers that a trial must have where nothing is carried: what points and means come down to."""
        return tuple(dict.fromkeys(m for p in self.points for m in self._behind(p)))

    def _behind(self, point: str) -> Iterator[str]:
        if point in self.means:
            for part in self.means[point]:
                yield from self._behind(part)
        else:
            yield point


def check_sequence(sequence: str) -> None:
    """Three axes, no axis twice in a row.

    Raises:
        ValueError: anything else.
    """
    if len(sequence) != 3 or not set(sequence) <= set(AXES) or sequence[1] in (sequence[0], sequence[2]):
        raise ValueError(f"sequence is {sequence!r}, wanted three of x, y, z, none twice in a row, such as zxy or yxy")


def _check_names(model: Model) -> None:
    """Names differ, and what a joint, a mean or a centre names is there."""
    for kind, items in (("segment", model.segments), ("joint", model.joints), ("cluster", model.clusters)):
        names = [item.name for item in items]
        if len(set(names)) != len(names):
            raise ValueError(f"{kind}s must have different names, found {names}")
    _check_joints(model)
    _check_means(model)
    clusters = {c.name for c in model.clusters}
    for centre in model.centres:
        if wrong := set(centre.between) - clusters:
            raise ValueError(f"centre {centre.name} names {sorted(wrong)}; there are the clusters {sorted(clusters)}")


def _check_joints(model: Model) -> None:
    if not model.joints:
        raise ValueError(f"model {model.name} has no joint, wanted at least one")
    known = {s.name for s in model.segments}
    for joint in model.joints:
        if wrong := {joint.parent, joint.child} - known - {LABORATORY}:
            raise ValueError(f"joint {joint.name} names {sorted(wrong)}; there are the segments {sorted(known)}")
        if joint.child == LABORATORY or joint.child == joint.parent:
            raise ValueError(f"joint {joint.name}: its child must be a segment other than its parent")


def _check_means(model: Model) -> None:
    done: set[str] = set()
    for name, parts in model.means.items():
        later = [part for part in parts if part in model.means and part not in done]
        if later or not parts:
            raise ValueError(f"point {name} is the mean of {parts}; means that it uses must stand above it: {later}")
        done.add(name)
