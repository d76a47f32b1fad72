"""What is said of gait."""

from __future__ import annotations

from dataclasses import replace

from ...data import Finding
from .template import Words, fill

REASONS = {
    "unclear": "it cannot be told which foot it was",
    "two_feet": "both feet stood on it",
    "aid": "it was loaded while the foot swung, as by a stick or a walker",
    "beside": "the foot was partly beside it",
    "two_plates": "the foot stood on another plate as well",
    "cut": "the recording begins or ends there",
    "no_foot": "no foot was near",
}
WHY = {
    "plates": "the recording has no force plates",
    "mass": "the body's mass is unknown",
    "contacts": "no foot stood whole and alone on a plate",
}
FOR_MOMENTS = {
    "plates": "Give a trial with force plates.",
    "mass": "Give mass_kg in the measures.",
    "contacts": "Record walks in which each foot meets its own plate; those above say what stood in the way.",
}


NOT_LEVEL = {
    "running": "runs: the feet leave the floor before the other one meets it, or the pelvis is highest between steps",
    "stairs": "climbs: the heels strike at other heights from step to step",
    "backward": "walks backwards",
    "to and fro": "walks forwards and backwards: means and curves are of both",
}


def _treadmill(found: Finding) -> str:
    if found.values["left_speed"] is None:
        return fill("{trial}: the floor moves at {speed:2} below the feet that stand: a treadmill.", found)
    return fill("{trial}: a treadmill of two belts, {left_speed:2} left and {right_speed:2} right.", found)


def _not_level(found: Finding) -> str:
    return (
        fill("{trial}: the subject ", found)
        + NOT_LEVEL.get(str(found.values["way"]), "does not walk on a level floor")
        + fill(". Events from markers were judged on level walks and are known to ±{sd_ms:0} here.", found)
    )


def _estimated(found: Finding) -> str:
    mass = found.values["mass_kg"]
    weighed = "" if mass is None else fill(", and by the plates the subject weighs {mass_kg:1}", found)
    return fill("Nobody states the subject's measures. By the markers the legs are {leg_mm:0} long", found) + (
        f"{weighed}; {WIDTHS.get(str(found.values['widths']), WIDTHS['share'])}, with error bars to match."
    )


WIDTHS = {
    "share": "knees and ankles have the usual share of that",
    "markers": "knees and ankles are as wide as their markers show",
    "both": "knees and ankles are as wide as their markers show, or have the usual share of that",
}
CAUSES = {
    "noise": "the noise of the markers",
    "smoothing": "what smoothing takes of the motion",
    "placement": "where the markers were put on",
    "hip centre": "where the hip joint's centre is",
    "widths": "the widths of knees and ankles",
    "soft tissue": "skin that moves over the bones",
    "plates": "where the force plates lie",
}
"""By the cause of an uncertainty of gait."""

AXES = {
    "knee_width": "{trial}: the markers of the {side} knee are {by_mm:0} farther apart than the knee is wide",
    "ankle_width": "{trial}: the markers of the {side} ankle are {by_mm:0} farther apart than the ankle is wide",
    "device": "{trial}: the sides of the device on the {side} knee differ by {by_share}",
    "axes": "{trial}: device and markers show axes of the {side} knee {by_deg:0} apart",
    "turn": "{trial}: a wand or the torsion of the {side} leg would be turned by {by_deg:0}",
}
FOR_AXES = {
    "knee_width": "Check which marker is which, on which leg, and the knee's width.",
    "ankle_width": "Check which marker is which, on which leg, and the ankle's width.",
    "device": "Check which of its markers is which, and whether it is bent.",
    "axes": "Look which of both is right; the device counts.",
    "turn": "Check which marker is which, on which leg; --no-axes leaves the axes to wands and measures.",
}


def _axes(found: Finding) -> str:
    template = AXES.get(str(found.values["what"]), "{trial}: the axes of the {side} leg are doubtful")
    by_mm = found.values["by_mm"]
    if isinstance(by_mm, float) and by_mm < 0:
        template = template.replace("farther apart", "nearer to each other")
        found = replace(found, values={**found.values, "by_mm": -by_mm})
    return fill(template, found) + "."


def _for_axes(found: Finding) -> str:
    return FOR_AXES.get(str(found.values["what"]), "Check the markers of the static trial.")


def _feet(found: Finding) -> str:
    own, here = ("flat on the floor", "as they stood")[:: 1 if found.values["flat"] else -1]
    return f"The file of the static trial took the feet {own}, and here they are taken {here}: " + fill(
        "angles of ankle and foot are up to {by_deg:1} from the file's own.", found
    )


def _for_feet(found: Finding) -> str:
    if found.values["flat"]:
        return "Leave --no-flat-foot out, in a session flat_foot, if both are to be compared."
    return "Give --no-flat-foot, in a session flat_foot = false, if both are to be compared."


def _shown_by(found: Finding) -> str:
    by = {"devices": "alignment devices on the knees", "markers": "markers inside of the joints"}
    return fill("{trial}: axes of knees and ankles come from ", found) + by.get(str(found.values["way"]), "it") + "."


def _left_out(found: Finding) -> str:
    why = REASONS.get(str(found.values["reason"]), "for a reason that is not known here")
    return f"{fill('{trial}: the load on plate {plate} does not count', found)}: {why}."


EXCHANGED = {
    "sides": "{trial}: all left markers are on the right side of the body",
    "pelvis": "{trial}: the front of the pelvis is where its back should be ({markers})",
    "across": "{trial}: {markers} are each on the other side of the body",
    "foot": "{trial}: {markers} are exchanged: the foot would point backwards",
    "leg": "{trial}: {markers} are exchanged: from pelvis to toe they would follow each other in the wrong order",
}
FOR_EXCHANGED = {
    "sides": "Exchange left and right in the names; or, if the file comes from axes that are left-handed, turn the "
    "sign of one axis where it was written.",
    "pelvis": "Name the markers of the pelvis anew: ASI in front, PSI or SACR at the back.",
}
DOUBTFUL = {
    "beside": "the centre of pressure is {by_share} of the foot's length beside the foot",
    "backward": "the centre of pressure does not go forward below the foot ({by_share} of its length)",
    "askew": "its force along the floor does not point from the foot to the body",
    "weight": "by the plates the body weighs {by_share} more than by the measures",
    "time": "its events come {late_ms:0} after those of the markers",
    "saturated": "a channel is cut off at its limit, in {by_share} of the samples under load",
    "elsewhere": "it is loaded while a foot stands {away_mm} away, and by nobody else",
    "origin": "its sensors would be {away_mm} off its surface or its middle, as the file has its origin",
    "unit": "no unit of its force is stated, and in N it never reaches the least load ({by_share} of that); it looks "
    "like kN",
}
FOR_DOUBTFUL = {
    "beside": "Where a stick, a walker or a helper loaded the plate too, leave this step out. Else check the order and "
    "places of the plate's corners, and the unit of its moments.",
    "backward": "Check the order of the plate's corners, and the unit of its moments, N·mm or N·m.",
    "askew": "Check the order of the plate's corners, and the signs of its channels.",
    "weight": "Check the mass in the measures, and the plates' scale; sticks, rails and helpers carry weight too.",
    "saturated": "Set the plate's amplifier to a wider range and record again; what is cut off is lost.",
    "elsewhere": "Check where the file has the plate's corners, and their unit, mm or m.",
    "origin": "Check the plate's ORIGIN in the file, and its unit, mm or m.",
    "unit": "Export it again in N, or with the unit of each channel (ANALOG:UNITS in C3D).",
    "time": "Check when cameras and plates begin, and the rate of the channels.",
}


def _exchanged(found: Finding) -> str:
    template = EXCHANGED.get(str(found.values["how"]), "{trial}: {markers} are not where their names say")
    return fill(template + "; angles and moments that follow from them are wrong.", found)


def _for_exchanged(found: Finding) -> str:
    return FOR_EXCHANGED.get(
        str(found.values["how"]), "Exchange their names; kinemark audit and kinemark studio show where each one is."
    )


def _deviations(found: Finding) -> str:
    cause = str(found.values["cause"])
    known = fill("Knee flexion is known to ±{knee_deg:1} (one standard deviation)", found)
    return f"{known}; what makes most of it is {CAUSES.get(cause, cause)}."


def _doubtful(found: Finding) -> str:
    what, values = str(found.values["what"]), dict(found.values)
    template = DOUBTFUL.get(what, "it cannot be as the file says")
    for name, word, other in (("by_share", "more", "less"), ("late_ms", "after", "before")):
        value = values[name]
        if isinstance(value, float) and value < 0 and what != "backward":
            values[name], template = -value, template.replace(word, other)
    head = "{trial}, plate {plate}: " if found.values["plate"] else "{trial}, the plates: "
    return fill(head + template + ": moments and powers follow it.", replace(found, values=values))


def _for_doubtful(found: Finding) -> str:
    return FOR_DOUBTFUL.get(str(found.values["what"]), "Check the plate in the file.")


def _no_moments(found: Finding) -> str:
    return f"There are no moments and powers: {WHY.get(str(found.values['why']), 'why is not known here')}."


def _no_strides(found: Finding) -> str:
    if found.values["stood"]:
        return fill("{trial}: the subject stands or steps on the spot in every stride, or at its end.", found)
    return fill("{trial}: no foot strikes the floor twice, so that there is no stride.", found)


def _for_strides(found: Finding) -> str:
    walk = "ecord a longer walk, or check the names of heel and toe markers."
    if found.severity == "red":
        return f"R{walk}"
    return fill('If it is the standing trial, name it: --static "{file}". Else r', found) + walk


def _for_left_out(found: Finding) -> str:
    if found.values["reason"] == "no_foot":
        return (
            "If a foot did stand there, the plate's corners, their order, its zero, or its moments' unit are not as "
            "the file says; else nothing is lost."
        )
    return "Other steps count; nothing is lost."


def _for_moments(found: Finding) -> str:
    return FOR_MOMENTS.get(str(found.values["why"]), "Give a trial with plates, and the mass in the measures.")


GAIT_WORDS = {
    "gait_without_strides": Words(
        _no_strides,
        _for_strides,
    ),
    "gait_walk_left_out": Words(
        "{why} So {trial} was left out.",
        "Mend the file, or compute gait without it: nothing here rests on it.",
    ),
    "gait_walk_repeated": Words(
        "{trial} is the same recording as {other}. So it was left out, and its steps count once.",
        "Nothing is lost. If {trial} is the better of both, give it without {other}.",
    ),
    "gait_subjects_differ": Words(
        "The files state different subjects: {subjects_list}. They are averaged as one person's.",
        "Give walks and standing trial of one person, or correct the name in the files.",
    ),
    "gait_bodies_differ": Words(
        "{trial} shows another body than {other}, or markers that were put on anew in between: distances within "
        "segments differ by {rms_mm:0} RMS and up to {most_mm:0} more than they move ({pairs_list}). Angles follow the "
        "markers of both.",
        "Give walks and standing trial of one person in the same markers. If they are, see in both what these markers "
        "are called, and whether the files' units are true.",
    ),
    "gait_static_moves": Words(
        "{trial}: the subject does not stand, the legs get up to {by_mm:0} shorter. Ankle and foot angles count from "
        "the mean of that.",
        "Give a trial in which the subject stands still: --static.",
    ),
    "gait_few_strides": Words(
        "{left_strides} left and {right_strides} right {right_strides:stride|strides}: how strides differ is hardly "
        "known.",
        "Give several walks together.",
    ),
    "gait_angles_with_gaps": Words(
        "{cut} of {strides} {strides:stride|strides} of the {side} side {cut:has|have} angles with gaps, of "
        "{joints_list}: {unknown_share:1} of the points of these curves are not there, for markers are missing.",
        "Fill the walk first: kinemark fill WALK.c3d -o FILLED.c3d, with --ends where a marker comes late or goes "
        "early; or in a session, [fill], with ends = true.",
    ),
    "gait_key_values_with_gaps": Words(
        "{missing} key {missing:value|values} of the {side} side {missing:is|are} not known, for samples are missing "
        "in a few frames of {curves_list}.",
        "Fill the walk first: kinemark fill WALK.c3d -o FILLED.c3d.",
    ),
    "gait_markers_leap": Words(
        "{trial}: leaps of {markers} in {leaps} {leaps:frame|frames}, by up to {most_mm:0}, which no body makes: "
        "angles, moments and powers there follow them.",
        "kinemark audit lists what went wrong in the tracks, kinemark studio mends it.",
    ),
    "gait_spikes_left_out": Words(
        "{trial}: {samples} {samples:sample|samples} of {markers} {samples:is|are} off the path by up to {most_mm:0} "
        "for a moment ({frames}). {samples:It was|They were} left out before anything was computed. Where there are "
        "frames on both sides the path goes on from these; beside a gap, and at the ends, nothing is there.",
        "kinemark audit lists what went wrong in the tracks, kinemark studio mends it.",
    ),
    "gait_markers_exchanged": Words(_exchanged, _for_exchanged),
    "gait_markers_move_apart": Words(
        "{trial}: markers of one segment come apart by up to {most_mm:0}: {pairs_list}. One of them is another marker "
        "for a time, or came off.",
        "kinemark audit lists what went wrong in the tracks, kinemark studio mends it.",
    ),
    "gait_plate_doubtful": Words(_doubtful, _for_doubtful),
    "foot_offsets_unknown": Words(
        "There is no static trial and no stated offset of the feet: ankle and foot angles are those of the line from "
        "ankle to toe.",
        "Give a standing trial: --static.",
    ),
    "gait_measures_estimated": Words(_estimated, "Measure legs, knees, ankles and weight, and give them: --measures."),
    "gait_heels_from_static": Words(
        "The walks have no {markers}: heels sit on the feet where the standing trial had them.",
        "For events and step lengths to a few millimetres, let the subject wear them while walking.",
    ),
    "gait_one_leg": Words(
        "{trial}: there is no marker of the {side} leg. All numbers are of the other one; what counts from foot to "
        "foot, as step length and support, is not known.",
        "If the leg did have markers, see what they are called: --marker; where it has none, nothing is lost.",
    ),
    "gait_markers_never_seen": Words(
        "{trial}: {markers} {markers:is|are} never seen. Angles that follow from {markers:it|them} are not known; "
        "without heel and toe a side has no steps.",
        "If one of the trial's unnamed trajectories is such a marker, name it; no filling restores a marker that no "
        "frame shows. "
        "Heels come from a standing trial: --static.",
    ),
    "gait_markers_renamed": Words(
        "Markers were taken for the gait model's: {names_list}.",
        "If one is another marker, say which it is: --marker SACR=sacrum.",
    ),
    "gait_hips_functional": Words(
        "The hip joint centres are those that {trial} shows, to ±{sd_mm:0} along each axis; up to {away_mm:0} from "
        "where the regression has them.",
        "Where both are far apart, look whether the motion was wide and the markers of the thighs sat firmly.",
    ),
    "gait_axes_from_static": Words(_shown_by, "Wands and torsions that follow stand with the measures."),
    "gait_axes_doubtful": Words(_axes, _for_axes),
    "gait_feet_otherwise": Words(_feet, _for_feet),
    "gait_clusters": Words(
        "Clusters of markers, calibrated in {trial}, carry {segments_list}; they fit to {misfit_mm:1} RMS at worst.",
        "What skin does to all markers of a cluster together no misfit shows; the error bars hold it (soft tissue).",
    ),
    "gait_clusters_by_names": Words(
        "What markers are called says on which segment they sit: {clusters_list}. They stand for the model's wands.",
        'If one sits elsewhere, state the cluster: --cluster "left thigh=A,B,C".',
    ),
    "gait_cluster_loose": Words(
        "The markers of the cluster of the {segment} are {misfit_mm:1} RMS from where {trial} has them.",
        "Look whether two of them are exchanged in one of the trials, or one came off; leave it out of the cluster.",
    ),
    "gait_plate_zeroed": Words(
        "{trial}: plate {plate} showed {baseline:0} while nothing stood on it. That was taken off all its channels.",
        "Set the plates to zero before a session, while nobody stands on them.",
    ),
    "contact_left_out": Words(_left_out, _for_left_out),
    "gait_plates_added": Words(
        "{trial}: the {side} foot stepped on plates {plates_list} together. Their forces were added up.",
        "If one of them carried something else, such as a stick, leave this walk out.",
    ),
    "gait_without_moments": Words(_no_moments, _for_moments),
    "events_without_plates": Words(
        "{trial}: foot strikes and offs come from the markers, ±{sd_ms:0} each.",
        "A plate under one step makes them surer.",
    ),
    "file_events_differ": Words(
        "{trial}: {events} {events:event|events} of the file {events:is|are} up to {most_ms:0} off those found.",
        "Look at both; those of the file are kept in it.",
    ),
    "file_events_not_found": Words(
        "{trial}: near {events} {events:event|events} of the file none was found.",
        "Markers or a plate show no such event there; those of the file are kept in it.",
    ),
    "gait_not_level": Words(
        _not_level,
        "Time and distance hang on the events; mark them by hand, or give plates, where they matter.",
    ),
    "gait_on_treadmill": Words(_treadmill, "Speed, stride and step count from it."),
    "gait_turns": Words(
        "{trial}: the subject turns: the pelvis faces up to {turned_deg:0} aside.",
        "Angles of pelvis and feet are to the way at each moment, and mean little where it turns back or the subject "
        "turns on the spot (by Plug-in Gait to an axis of the laboratory, where they mean little in any turn). Lengths "
        "and widths of steps in a turn are not those of straight walking.",
    ),
    "gait_turns_left_out": Words(
        "{trial}: the subject turns in {left_out} of {strides} strides: they are left out of means and curves.",
        "They stand in time_distance.csv.",
    ),
    "gait_stands_left_out": Words(
        "{trial}: the subject stands or steps on the spot in {left_out} of {strides} strides, or at their end: they "
        "are left out of means and curves.",
        "They stand in time_distance.csv.",
    ),
    "gait_ways": Words(
        "{trial}: the subject walks in more than one direction, from the laboratory's x to the left: {ways_list}.",
        "Time and distance of each direction stand in their section.",
    ),
    "gait_good": Words("Gait was measured and nothing stands out."),
    "gait_usable": Words("Gait was measured. First look at what needs attention."),
    "gait_unusable": Words("Gait was computed from markers that are exchanged: do not use it before that is mended."),
    "gait_missing": Words("There is no gait result: what needs attention says why."),
    "gait_measured": Words(
        "{left_strides} left and {right_strides} right {right_strides:stride|strides}, {speed:2} at {cadence:0} steps "
        "a minute."
    ),
    "gait_deviations": Words(_deviations),
}
