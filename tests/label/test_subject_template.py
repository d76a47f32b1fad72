"""A subject's template grows by what was labelled and accepted, and by nothing else."""

from dataclasses import replace
from functools import cache
from itertools import permutations

import numpy as np
import pytest

from kinemark.data import KinemarkError
from kinemark.label import SubjectTemplate, TemplateSource, label, learn_template, template_of_subjects
from kinemark.label.pooled import part_of, pooled
from kinemark.label.template import triple_products
from kinemark.synth import walking

FROM = TemplateSource("walk.c3d", 200, "2026-01-31", "accepted")


@cache
def walk(seed, height=1730.0, **more):
    return walking(duration_s=2.0, rate=100.0, seed=seed, wobble_mm=1.0, height_mm=height, **more).trajectories


def renamed(trial, new):
    return replace(trial, paths=tuple(replace(path, name=new.get(path.name, path.name)) for path in trial))


def test_two_trials_pooled_are_what_is_learnt_from_both():
    one, both = learn_template(walk(1)), learn_template(walk(1), walk(2, speed_mm_s=1500.0))
    other = learn_template(walk(2, speed_mm_s=1500.0))
    found = pooled(one, other, walk(2, speed_mm_s=1500.0))
    np.testing.assert_allclose(found.distance, both.distance, rtol=1e-9)
    np.testing.assert_allclose(found.spread, both.spread, rtol=1e-6, atol=1e-6)
    np.testing.assert_array_equal(found.frames, both.frames)
    assert {tuple(quad) for quad in found.handed.tolist()} <= {tuple(quad) for quad in one.handed.tolist()}


def test_an_accepted_trial_is_added_and_a_refused_one_is_not():
    own = SubjectTemplate(learn_template(walk(1)), "kiss-15", "Anna", 1730.0, (FROM,))
    good = own.grown(walk(2), label(walk(2), own.template), FROM)
    assert good.refused is None and set(good.added) == set(own.template.names)
    assert good.template.sources == (FROM, FROM) and good.template.subject == "Anna"
    assert good.template.template.frames.max() == 2 * own.template.frames.max()
    far = renamed(walk(2), {})
    far = replace(far, paths=tuple(replace(p, xyz=p.xyz * [1.0, 2.0, 0.3]) for p in far))
    refused = own.grown(far, label(far, own.template), FROM)
    assert refused.template is own and refused.refused is not None and refused.refused.kind == "labels_refused"


def test_only_sure_names_count():
    own = SubjectTemplate(learn_template(walk(1)))
    found = label(walk(2), own.template)
    state = tuple("unsure" if name == "LTOE" else s for name, s in zip(found.names, found.state, strict=True))
    grown = own.grown(walk(2), replace(found, state=state), FROM)
    assert "LTOE" not in grown.added
    k = own.template.names.index("LTOE")
    assert (grown.template.template.frames[k] == own.template.frames[k]).all()
    none = own.grown(walk(2), replace(found, state=("unsure",) * len(found)), FROM)
    assert none.template is own and none.added == () and none.refused is None


@pytest.mark.parametrize("two", [("LKNE", "LTIB"), ("LHEE", "LTOE"), ("LASI", "RASI"), ("LANK", "LHEE")])
def test_a_trial_that_contradicts_is_refused_and_says_of_which_markers(two):
    own = SubjectTemplate(learn_template(walk(1)))
    trial = walk(2)
    wrong = replace(label(trial, own.template), names=tuple(dict([two, two[::-1]]).get(n, n) for n in trial.names))
    found = own.grown(trial, wrong, FROM)
    assert found.template is own and found.refused is not None
    assert found.refused.kind == "trial_contradicts_template" and set(found.refused.markers) & set(two)


@pytest.mark.parametrize("seed", range(2, 8))
def test_other_walks_of_the_subject_do_not_contradict(seed):
    own = SubjectTemplate(learn_template(walk(1)))
    trial = walk(seed, speed_mm_s=700.0 + 150.0 * seed)
    assert own.grown(trial, label(trial, own.template), FROM).refused is None


def test_several_subjects_tell_more_than_one_and_know_what_they_do_not():
    heights = (1400.0, 1600.0, 1900.0)
    templates = [learn_template(walk(k, h)) for k, h in enumerate(heights)]
    found = template_of_subjects(templates, heights, 1730.0)
    np.testing.assert_allclose(found.distance, learn_template(walk(9)).distance, atol=40.0)
    one = template_of_subjects(templates[:1], heights[:1], 1730.0)
    off = ~np.eye(len(found), dtype=bool)
    assert (found.doubt[off] > 0).all() and np.median(found.doubt[off]) < np.median(one.doubt[off])
    with pytest.raises(ValueError, match="wanted as many"):
        template_of_subjects(templates, heights[:2], 1730.0)
    with pytest.raises(KinemarkError, match="share 0"):
        template_of_subjects(
            [templates[0], learn_template(renamed(walk(1), {n: f"x{n}" for n in walk(1).names}))], (1.0, 1.0), 1.0
        )


def test_part_of_a_template_keeps_the_orientation_of_its_quadruples():
    whole = learn_template(walk(1))
    names = whole.names[::-1][:10]
    part = part_of(whole, names)
    xyz = np.stack([walk(1)[name].xyz for name in names])
    assert len(part.handed) and (np.sign(triple_products(xyz, part.handed)) == part.sign[:, None]).all()
    i, j = whole.names.index(names[2]), whole.names.index(names[7])
    assert part.distance[2, 7] == whole.distance[i, j]
    for order in permutations(names[:4]):
        xyz = np.stack([walk(1)[name].xyz for name in order])
        some = part_of(whole, order)
        assert (np.sign(triple_products(xyz, some.handed)) == some.sign[:, None]).all()


def test_what_is_no_height_is_refused():
    with pytest.raises(ValueError, match="height_mm"):
        SubjectTemplate(learn_template(walk(1)), height_mm=-1.0)
