"""What findings of labelling, of filling, of joint angles and of the proposal of detection say."""

from __future__ import annotations

from ...data import Finding
from .template import Words, fill, listed, shown

STATE_MARKER_SD = (
    "State the value that the laboratory knows: Markers' SD in the studio's Angles, marker_sd_mm under [angles] of "
    "session.toml, or kinemark angles --marker-sd-mm."
)
MOST_DISPLACED = 12
"""Markers beside their places that are named, the others counted; chosen, as in errors."""


def _displaced(found: Finding) -> str:
    by = found.values["off_mm_list"]
    assert isinstance(by, tuple)
    each = [f"{name} by {shown(mm, 'mm')}" for name, mm in zip(found.markers, by, strict=False)]
    return fill(
        "{markers:A named marker sits|Named markers sit} beside {markers:its place|their places} in the template: ",
        found,
    ) + (f"{listed(each, MOST_DISPLACED) or '–'}.")


def _exchanged(found: Finding) -> str:
    said = fill(
        "{marker_names} carry each other's names in frames {first} to {last} of {file}, or in all others: their "
        "distances to other markers are steady with both exchanged there. The template learns ",
        found,
    )
    return said + (
        "nothing of these frames." if found.values["learnt"] else "neither, as nothing tells which is which."
    )


def _stated_exchanged(found: Finding) -> str:
    by_template = found.values["template"]
    said = fill("{marker_names} carry each other's names by their distances to other markers, in {frames}", found)
    said += "" if by_template else ", or in all others"
    said += ". They were stated by hand, and are kept"
    return said + ("; other trials do not learn them." if by_template else ".")


BY_BODY = {
    "found": "{found} {found:point was|points were} found that the tracker had missed",
    "renamed": "{renamed} {renamed:point changes its name|points change their names}",
    "joined": "{joined} {joined:point joins|points join} a marker",
    "put_aside": "{put_aside} {put_aside:point is|points are} put aside",
    "ghosts": "{ghosts} {ghosts:track was|tracks were} taken for ghosts",
}
"""What the named body may change, by the name of its number."""


def _by_body(found: Finding) -> str:
    """Only what was changed: noughts say nothing."""
    *before, last = [fill(words, found) for key, words in BY_BODY.items() if found.values[key]] or ["nothing changes"]
    changed = f"{', '.join(before)} and {last}" if before else last
    return fill(f"By the distances of the named body, {changed}: {{marker_names}}; {{frames}}.", found)


LABELLING_WORDS = {
    "labels_refused": Words(
        "The template does not fit: the best labelling scores {fit_share} of what the template scores on its own data "
        "and places {placed_share} of the samples. Nothing is named.",
        "Give a template of this subject and marker set, or of a trial with such a posture, or scale it by height; "
        "where the trial has only a part of its markers, as those of the legs, the set of that part or their names.",
    ),
    "sides_undecided": Words(
        "Left and right cannot be told: {markers} fit as well the other way round, so that these names are not sure.",
        "Say which side one marker is on, or give a template with a marker that breaks the symmetry.",
    ),
    "own_image": Words(
        "The set is its own image: {markers} fit as well with the names of each other, so that these are not sure.",
        "Say by hand which marker one of them is, or move one so that the set is no image of itself.",
    ),
    "world_mirrored": Words(
        "The trial is the mirror image of the template: distances fit the names of one side, orientation those of the "
        "other, so that no name is sure.",
        "Look at the axes of both: one system is left-handed, as where y or a side of the volume is counted the other "
        "way. Export it right-handed, or change the sign of one axis.",
    ),
    "labels_without_template": Words(
        "No marker has a name yet: nothing tells which is which.",
        "Name those of one trial on the screen Labels of kinemark studio: the session's other trials are named by it. "
        "Or give [label] a labelled trial of the subject (template).",
    ),
    "labels_unsure": Words(
        "{stretches} {stretches:stretch has|stretches have} no name, as {stretches:it is|they are} not sure: probably "
        "{marker_names}; {frames}.",
        "See them in the table of markers; state {stretches:its name|their names} in the file of names, or say "
        "unsure = true.",
    ),
    "markers_not_found": Words(
        "{Markers} of the template {markers:is|are} not found in this trial.",
        "Check that {markers:it was|they were} worn and seen.",
    ),
    "markers_displaced": Words(
        _displaced,
        "Was it put on anew, or is it another marker? Look at it in a picture. If it is another, state its name by "
        "hand; if it was put on anew, take a newer template.",
    ),
    "ghosts_removed": Words(
        "{tracks} {tracks:track was|tracks were} taken for ghosts and left out: most of {tracks:its|their} images are "
        "those of named markers.",
    ),
    "tracks_switched": Words(
        "{switches} {switches:time|times} a track went over from one marker to another and was cut there: "
        "{marker_names}; {frames}.",
        "Look at these frames in the images.",
    ),
    "second_pass_by_body": Words(
        _by_body,
        "Look at these frames in the images; second_pass = false in [label] leaves the tracks as they were.",
    ),
    "stated_names_lost": Words(
        "{statements} {statements:name was|names were} stated of places where no track is: {marker_names}; {frames}.",
        "State them where the marker is tracked.",
    ),
    "stated_names_exchanged": Words(
        _stated_exchanged,
        "Look at these frames. Where the names are wrong, take back what was stated, or state them the other way.",
    ),
    "trial_contradicts_template": Words(
        "The trial says otherwise than the subject's template about {markers}: {pairs_share} of the distances within "
        "segments are off, by up to {off_mm}. The template does not learn from it.",
        "Check its names with `kinemark label --check`; if a marker was moved, make a new template.",
    ),
    "template_names_impossible": Words(
        "In {file}, {markers} cannot be where their names say: they are on the other side of the body, or would follow "
        "each other along the body in another order. What is named by this file has the same wrong names.",
        "Exchange their names in that file, and name the trial again.",
    ),
    "template_names_exchanged": Words(
        _exchanged,
        "Look at these frames, and exchange both names where they are wrong.",
    ),
}

FILLING_WORDS = {
    "gaps_open": Words(
        "{gaps} {gaps:gap|gaps} stayed open, for the {gaps:reason|reasons} in the table.",
        "Raise the limit if a greater error does no harm, give a static trial, or do without these frames.",
    ),
    "gaps_uncertain": Words(
        "{gaps} {gaps:gap|gaps} may be off by more than {limit_mm:.3g} somewhere: that is {gaps:its|their} expected "
        "error, or a standard deviation within {gaps:it|them}, at most {max_mm}.",
        "Look at {gaps:its drawing|their drawings}; a lower limit leaves open gaps whose expected error is great.",
    ),
    "gaps_untested": Words(
        "{gaps} {gaps:gap|gaps} filled by a method that mostly had no prediction in the hold-out gaps, so that the "
        "error is not known.",
        "Compare {gaps:it|them} with another method, or give a limit in mm.",
    ),
    "gaps_beyond_tests": Words(
        "{gaps} {gaps:gap lies|gaps lie} in faster or longer motion than any hold-out gap, at most {max_ratio} times "
        "as much: the expected {gaps:error is|errors are} extrapolated from easier ones.",
        "Look at {gaps:its drawing|their drawings}, and compare distances to other markers of the body part.",
    ),
    "gap_sides_contradict": Words(
        "Before and after {gaps} {gaps:gap|gaps} a marker lies on different places of its body: {where_list}. It is "
        "another marker on one side, or it was put on anew or slipped.",
        "Look at which side is right, and name or leave out the other; it may be wrong far beyond the gap. Where both "
        "are right, fill with a method chosen for this gap, or with --limit-mm inf.",
    ),
    "samples_far_away": Words(
        "{samples} {samples:sample|samples} farther than a kilometre from the others: no {samples:position of a "
        "marker|positions of markers}. {samples:It is|They are} missing now, or filled.",
        "Find out where {samples:it comes|they come} from; the file given still has {samples:it|them}.",
    ),
    "samples_replaced": Words(
        "{samples} {samples:sample|samples} measured beside {gaps} {gaps:gap|gaps} stood out from the marker's own "
        "motion and {samples:was|were} replaced ({samples:a dot|dots} in the drawings).",
        "Where the motion was right as it was measured, fill again without --trim (trim = 0 in a session).",
    ),
    "samples_suspicious": Words(
        "{samples} {samples:sample|samples} measured beside {gaps} {gaps:gap|gaps} {samples:stands|stand} out from the "
        "marker's own motion, or {samples:contradicts|contradict} the other markers, and {samples:was|were} kept "
        "({samples:a dot|dots} in the drawings): {where_list}.",
        "Where a distance is given, the fill does not follow these samples, and the path leaps by it beside the gap. "
        "Other fills follow them, with a larger expected error. Where samples are wrong, erase them, or fill again "
        "with --trim 5 (trim = 5 in a session): those that stand out from the marker's own motion are replaced then.",
    ),
    "markers_mostly_filled": Words(
        "{Markers}: more than {limit_share} of the trial is filled.",
        "What is computed from {markers:it|them} rests on {markers:its|their} neighbours.",
    ),
    "tracks_not_filled": Words(
        "{tracks} {tracks:track|tracks} without a name: {tracks:its|their} {gaps} {gaps:gap|gaps} {gaps:is|are} no "
        "marker's, and {gaps:stays|stay} as {gaps:it is|they are}.",
        "Name those that are markers (kinemark label), and fill then.",
    ),
    "computed_not_filled": Words(
        "{points} {points:point that was|points that were} computed of markers {points:has|have} gaps, and "
        "{points:stays|stay} as {points:it is|they are}.",
        "The program that computed {points:it|them} does so anew from the filled markers.",
    ),
    "markers_absent": Words(
        "{Markers} {markers:is|are} never seen in this trial.",
        "A static trial in which {markers:it is|they are} seen with three others of {markers:its|their} segment can "
        "place {markers:it|them}: --static.",
    ),
}

FILL_THE_GAPS = "Fill the gaps, or use a model with clusters and a static trial."


def _beyond_normal(found: Finding) -> str:
    joint = str(found.values["joint"]).capitalize()
    return f"{joint} " + fill(
        "{angle} is beyond its normal range in {frames_share} of the frames, by up to {most_deg:1}.", found
    )


ANGLE_WORDS = {
    "angles_not_computed": Words("No joint angles: {reason}", "Correct [angles], or name the markers that it wants."),
    "joints_without_angles": Words("No frame has angles of: {joints_list}. Markers are missing.", FILL_THE_GAPS),
    "frames_without_angles": Words(
        "{count} {count:frame|frames} without angles of: {joints_list}. Markers are missing there.", FILL_THE_GAPS
    ),
    "gimbal_lock": Words(
        "The {joint} is in gimbal lock: {frames}.",
        "Its first and third angle cannot be separated there; another sequence may fit better.",
    ),
    "angle_jumps": Words(
        "{joint}: {angle} jumps {count} {count:time|times} between two frames, by up to {most_deg:0}: {frames}.",
        "Check there that markers are not exchanged or misplaced; the angles are kept.",
    ),
    "side_of_markers": Words(
        "The markers' names are those of a {side} limb, so the model was taken for that side, not its {usual} one.",
        "State it with --side, if it is another.",
    ),
    "angle_beyond_normal": Words(_beyond_normal, "Check that no marker is swapped or misplaced; the angles are kept."),
    "markers_smoothed_before": Words(
        "The markers have little noise ({sd_mm}): they were smoothed before, so that the standard deviations of the "
        "angles are far too small.",
        STATE_MARKER_SD,
    ),
    "marker_errors_not_stated": Words(
        "The file states no errors of its markers; their standard deviation is {how}.",
        STATE_MARKER_SD,
    ),
}

PROPOSAL_WORDS = {
    "images_white": Words(
        "The images are white: {white_share} of the pixels have the brightest level.", "Shorten the exposure."
    ),
    "nothing_stands_out": Words(
        "Nothing stands out: the brightest pixel has {brightest} of {white}, the background {background} with a noise "
        "of {noise:.2g}.",
        "Check that the light is on and that markers are in view.",
    ),
    "markers_dark": Words("The markers are dark on a bright ground.", "`inverted = true` is part of the proposal."),
    "no_clear_gap": Words(
        "There is no clear gap between noise and markers: only from {low} to {high} of {white} the number of groups is "
        "steady.",
        "Check the detections before using them.",
    ),
    "bright_without_markers": Words(
        "{pixels_share} of the pixels stand out and are no markers: windows, lamps, a bright floor?",
        "Mask them or raise the threshold; KISS's long/wide test would split them.",
    ),
    "light_clipped": Words(
        "The light is clipped: {groups_share} of the groups reach the brightest level.", "Shorten the exposure."
    ),
    "spots_standing": Words(
        "At {at_list} px {at_list:a spot of a marker's size never moves|spots of a marker's size never move}, while "
        "others do: {at_list:a lamp or reflection?|lamps or reflections?}",
        "Cover or mask {at_list:it|them}: the masks proposed here go into a file that [masks] names; if "
        "{at_list:it is a marker|they are markers} on something that does not move, all is well.",
    ),
    "few_bits_used": Words(
        "The images have 16 bits, but no level above {white} is used: hence the low numbers of the thresholds."
    ),
}
