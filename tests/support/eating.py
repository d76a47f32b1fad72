"""A feeding motion in the laboratory of UM²AS, its images, and an operator who knows where the markers are."""

from functools import cache

import numpy as np

from kinemark.data import Rig
from kinemark.digitise import Absent, Accept, DigitisingPhase, No, Point, Verify, Yes, find_markers
from kinemark.synth import Capsules, Optics, Subject, arm, film, truth
from kinemark.synth import look_at as aimed

CENTRE = np.array([420.0, 300.0, 400.0])
SIZE = (512, 512)
POST = np.array([600.0, -100.0, 50.0])
"""The reference marker, on a stand at the side of the table."""


LAMP = (((1300.0, 312.0, 605.0), (1300.0, 420.0, 605.0)), ((455.0, -800.0, 380.0), (455.0, -800.0, 540.0)))
"""Axes of its parts: a bar that the hand passes behind for the first camera, a pole for the elbow and the second."""


def laboratory():
    """Three cameras 2.4 m from where their axes meet; images as UM²AS has them, 0 … 511.

    They stand along the axes, but for the upper one, which would see the post's marker on the acromion's.
    """
    places = CENTRE + 2400.0 * np.array([[1.0, 0, 0], [0, -1.0, 0], [0.35, -0.25, 0.9]])
    cameras = tuple(aimed(f"cam{i + 1}", p, CENTRE, focal_px=1080.0, size=SIZE) for i, p in enumerate(places))
    return Rig(cameras, "placed", np.array([CENTRE - 500, CENTRE + 500]))


def meal(duration_s=3.0, rate=30.0, seed=1, **arm_options):
    """The arm with the reference marker as its eighth, and a lamp between it and two cameras."""
    eater = arm("feeding", duration_s=duration_s, rate=rate, seed=seed, **arm_options)
    xyz = np.concatenate([eater.xyz, np.broadcast_to(POST, (1, eater.n_frames, 3))])
    limbs, n = eater.capsules, eater.n_frames
    a, b = (np.repeat(np.array(LAMP)[:, end, None], n, 1) for end in (0, 1))
    capsules = Capsules(
        (*limbs.names, "lamp's arm", "lamp's pole"),
        np.concatenate([limbs.a, a]),
        np.concatenate([limbs.b, b]),
        np.concatenate([limbs.radius, [25.0, 20.0]]),
    )
    return Subject((*eater.names, "REF"), rate, xyz, 17.0, capsules, angles=eater.angles)


@cache
def footage(duration_s=3.0, seed=1):
    """(rig, subject, sight, images (C, F, H, W))."""
    rig, subject = laboratory(), meal(duration_s, seed=seed)
    images = [np.stack(list(film(c, subject, optics=Optics(subsamples=2), seed=10 + i))) for i, c in enumerate(rig)]
    return rig, subject, truth(rig, subject), images


def image_source(images, method=None):
    """Frames ready to be pointed at, made once each."""

    @cache
    def at_frame(f):
        return find_markers(images[f], method=method)

    return at_frame


def pointed_at(sight, images, *, least=0.35):
    """(C, M, F, 2) px where somebody points: a marker's place, the white pixel next to it where it is partly hidden,
    NaN where less than `least` of it is in sight."""
    uv = np.where(sight.visible[..., None] < least, np.nan, sight.uv)
    sources = [image_source(own) for own in images]
    for c, m, f in np.argwhere((sight.visible >= least) & (sight.visible < 1)):
        v, u = np.nonzero(sources[c](f).owner >= 0)
        near = int(np.hypot(u - uv[c, m, f, 0], v - uv[c, m, f, 1]).argmin())
        uv[c, m, f] = u[near], v[near]
    return uv


class Knowing:
    """An operator who sees a marker if at least this share of it is in sight, and points with an unsteady hand.

    Before saving a frame they check it, and correct what is further off than they can see, 4 px.
    """

    def __init__(self, sight, c, images, *, least=0.35, seed=0, shift=None):
        self.uv, self.visible = sight.uv[c], sight.visible[c]
        self.least, self.rng, self.images = least, np.random.default_rng(seed), images
        self.shift = np.zeros((self.uv.shape[1], 2)) if shift is None else shift
        self.asked = []

    def __call__(self, question, state):
        self.asked.append(question)
        m, f = question.marker, question.frame
        if question.phase is DigitisingPhase.REVIEW:
            return Accept() if all(self.right(state.draft, k, f) for k in range(len(self.uv))) else Verify()
        if question.phase is DigitisingPhase.VERIFY:
            return Yes() if self.right(state.draft, m, f) else No()
        if question.phase is DigitisingPhase.REFERENCE:
            return Yes()
        if question.proposal is not None and self.agrees(question):
            return Yes()
        if self.visible[m, f] < self.least:
            return Absent()
        if question.phase is DigitisingPhase.CORRECT:
            return Point(*(self.place(m, f) + self.rng.uniform(-1, 1, 2)))
        at = self.place(m, f) + self.rng.uniform(-2, 2, 2)
        v, u = np.nonzero(self.images(f).owner >= 0)
        near = int(np.hypot(u - at[0], v - at[1]).argmin())  # they point at something white
        return Point(float(u[near]), float(v[near]))

    def place(self, m, f):
        """Where they see it."""
        return self.uv[m, f] + self.shift[f]

    def right(self, draft, m, f):
        """As far as they can see."""
        if np.isnan(draft.uv[m, 0]):
            return self.visible[m, f] < 0.99
        if self.visible[m, f] < self.least:
            return self.visible[m, f] > 0.05
        return np.hypot(*(draft.uv[m] - self.place(m, f))) < 4.0

    def agrees(self, question):
        """What is proposed is what they see: the marker within its radius, or nothing."""
        m, f = question.marker, question.frame
        if not question.proposal.seen:
            return self.visible[m, f] < self.least
        off = question.proposal.uv - self.place(m, f)
        return bool(self.visible[m, f] >= self.least and np.hypot(*off) < 4.0)
