"""What may be found of gait: of feet, plates, events, measures and EMG; and what its verdict says."""

from __future__ import annotations

from .finding import FindingKind as Kind

GAIT_KINDS = (
    Kind("gait_without_strides", "gait", "red", "No foot strikes twice, or the subject stands in all strides, so many; "
         "amber where other trials have some.", {"trial": "text", "file": "text", "stood": "count"}),
    Kind("gait_walk_left_out", "gait", "amber", "A walk that cannot be used beside others that can; why.",
         {"trial": "text", "why": "text"}),
    Kind("gait_walk_repeated", "gait", "amber", "A walk that is the recording of another one given, as a copy of it or "
         "processed; it was left out.", {"trial": "text", "other": "text"}),
    Kind("gait_subjects_differ", "gait", "amber", "Walks and standing trial state more than one subject, each with its "
         "files.", {"subjects_list": "text"}),
    Kind("gait_bodies_differ", "gait", "amber", "The body in a file is another than in the standing trial or the "
         "first walk, or its markers were put on anew: distances within segments differ by more than they "
         "move in each, RMS and greatest; which most.",
         {"trial": "text", "other": "text", "pairs_list": "text", "most_mm": "mm", "rms_mm": "mm"}),
    Kind("gait_static_moves", "gait", "amber", "The subject bends the legs in the standing trial; how much shorter "
         "they get.", {"trial": "text", "by_mm": "mm"}),
    Kind("gait_few_strides", "gait", "amber", "Fewer than three strides of a side: their spread means little.",
         {"left_strides": "count", "right_strides": "count"}),
    Kind("gait_angles_with_gaps", "gait", "amber", "Strides of a side in which more than a tenth of some angle is not "
         "known, for markers are missing; of which joints, and how much of these angles is not.",
         {"side": "text", "cut": "count", "strides": "count", "joints_list": "text", "unknown_share": "share"}),
    Kind("gait_key_values_with_gaps", "gait", "amber", "Key values of a side that are not known, though less than a "
         "tenth of their curves is missing; how many, and of which curves.",
         {"side": "text", "missing": "count", "curves_list": "text"}),
    Kind("gait_markers_leap", "gait", "amber", "Markers of a trial leap as no body does, in so many frames; greatest "
         "second difference of a place.", {"trial": "text", "leaps": "count", "most_mm": "mm"}),
    Kind("gait_spikes_left_out", "gait", "info", "Samples of markers of a trial that stand off their paths, by so much "
         "at most, and were left out.", {"trial": "text", "samples": "count", "most_mm": "mm"}),
    Kind("gait_markers_exchanged", "gait", "red", "Markers of a trial cannot be where their names say. how: sides "
         "(left and right of all markers, or left-handed axes), pelvis (its front and back), across (with the other "
         "side), foot (heel and toe) or leg (two markers that follow each other).", {"trial": "text", "how": "text"}),
    Kind("gait_markers_move_apart", "gait", "amber", "Markers of one segment do not keep their distance; width of the "
         "middle 95 % of the worst.", {"trial": "text", "pairs_list": "text", "most_mm": "mm"}),
    Kind("gait_plate_doubtful", "gait", "amber", "A plate, or all, cannot be as the file says. what: beside (the "
         "centre of pressure is that share of the foot's length aside of it), backward (it goes that share forward), "
         "askew (its force does not point to the body; the least likeness), weight (that share off the stated one), "
         "saturated (that share of the samples under load), time (of its events against the markers'), elsewhere "
         "(nobody is near while it is loaded as by a foot that stands then), origin (its sensors are so far from its "
         "surface or its middle) or unit (none is stated, and in N its force reaches that share of the least load).",
         {"trial": "text", "plate": "count", "what": "text", "by_share": "share", "late_ms": "ms", "away_mm": "mm"}),
    Kind("foot_offsets_unknown", "gait", "amber", "No static trial, and no offsets stated: ankle and foot angles are "
         "those of the line from ankle to toe."),
    Kind("gait_measures_estimated", "gait", "amber", "Nobody states the subject's measures: legs by the markers, "
         "mass by the plates where there are. legs: mean of both. widths of knees and ankles: by their \"markers\", as "
         "their usual \"share\" of the leg, or \"both\".",
         {"leg_mm": "mm", "mass_kg": "kg", "widths": "text"}),
    Kind("gait_heels_from_static", "gait", "info", "Heels that the walks do not have sit on the feet as in the static "
         "trial."),
    Kind("gait_one_leg", "gait", "amber", "No marker of one leg is in a walk: its side has no numbers.",
         {"trial": "text", "side": "text"}),
    Kind("gait_markers_never_seen", "gait", "amber", "Markers of the model that a walk names and never shows: what "
         "follows from them has no numbers.", {"trial": "text"}),
    Kind("gait_markers_renamed", "gait", "info", "Markers of the file that were taken for the model's, as SACR = "
         "sacrum.", {"names_list": "text"}),
    Kind("gait_hips_functional", "gait", "info", "Hip joint centres come from a motion that turns them. way: score or "
         "spheres. Standard uncertainty along an axis; distance of the farther hip from the regression's.",
         {"trial": "text", "way": "text", "sd_mm": "mm", "away_mm": "mm"}),
    Kind("gait_axes_from_static", "gait", "info", "Axes of knees and ankles come from the static trial. way: devices "
         "or markers.", {"trial": "text", "way": "text"}),
    Kind("gait_axes_doubtful", "gait", "amber", "The static trial contradicts itself or the measures. what: "
         "knee_width, ankle_width, device, axes or turn; by so many mm, share or deg.",
         {"trial": "text", "side": "text", "what": "text", "by_mm": "mm", "by_share": "share", "by_deg": "deg"}),
    Kind("gait_feet_otherwise", "gait", "amber", "The static trial's file states offsets of the feet that its program "
         "found the other way: flat, or as they stood; greatest difference of both.",
         {"flat": "flag", "by_deg": "deg"}),
    Kind("gait_clusters", "gait", "info", "Clusters of markers, calibrated in the static trial, carry segments; RMS "
         "misfit of the worst.", {"trial": "text", "segments_list": "text", "misfit_mm": "mm"}),
    Kind("gait_clusters_by_names", "gait", "info", "Clusters that nobody stated, taken by what markers are called, as "
         "left thigh = L_FTC, LKNE, LKNM.", {"clusters_list": "text"}),
    Kind("gait_cluster_loose", "gait", "amber", "The markers of a cluster move against each other, RMS misfit in the "
         "worst walk.", {"trial": "text", "segment": "text", "misfit_mm": "mm"}),
    Kind("gait_plate_zeroed", "gait", "info", "A plate showed a force while nothing stood on it; its "
         "greatest component, which was taken off.", {"trial": "text", "plate": "count", "baseline": "N"}),
    Kind("contact_left_out", "gait", "info", "A load on a plate from which no moments follow. reason: unclear, "
         "two_feet, aid, beside, cut, two_plates or no_foot.", {"trial": "text", "plate": "count", "reason": "text"}),
    Kind("gait_plates_added", "gait", "info", "Steps of a foot on several plates, whose forces were added up.",
         {"trial": "text", "side": "text", "plates_list": "text"}),
    Kind("gait_without_moments", "gait", "info", "There are no moments. why: plates, mass or contacts.",
         {"why": "text"}),
    Kind("events_without_plates", "gait", "info", "Foot events of a trial come from markers alone; median of their "
         "standard uncertainties.", {"trial": "text", "sd_ms": "ms"}),
    Kind("file_events_differ", "gait", "amber", "Events in the file are off from those that were found; greatest "
         "difference.", {"trial": "text", "events": "count", "most_ms": "ms"}),
    Kind("file_events_not_found", "gait", "info", "Events in the file near which none was found.",
         {"trial": "text", "events": "count"}),
    Kind("gait_not_level", "gait", "amber", "The subject does not walk forwards on a level floor. way: running, "
         "stairs, backward or to and fro. Standard uncertainty of events from markers there.",
         {"trial": "text", "way": "text", "sd_ms": "ms"}),
    Kind("gait_on_treadmill", "gait", "info", "The floor moves below standing feet, at this speed; lengths and speed "
         "count from it. Speeds below each foot where there are two belts.",
         {"trial": "text", "speed": "m/s", "left_speed": "m/s", "right_speed": "m/s"}),
    Kind("gait_turns", "gait", "amber", "The subject turns: for a tenth of the time the pelvis faces so far or more "
         "from its mean direction, or from that of progression.", {"trial": "text", "turned_deg": "deg"}),
    Kind("gait_turns_left_out", "gait", "info", "Strides in which the subject turns, of all; they are left out of "
         "means and curves.", {"trial": "text", "left_out": "count", "strides": "count"}),
    Kind("gait_stands_left_out", "gait", "info", "Strides in which the subject stands or steps on the spot, or that "
         "end so, of all; they are left out of means and curves.",
         {"trial": "text", "left_out": "count", "strides": "count"}),
    Kind("gait_ways", "gait", "info", "The subject walks more ways than one: where the pelvis faces in each, from the "
         "x of the laboratory to the left, and how many strides.", {"trial": "text", "ways_list": "text"}),
    Kind("emg_smoothed", "gait", "info", "EMG channels were recorded as envelopes; they are not filtered again.",
         {"trial": "text", "channels_list": "text"}),
    Kind("emg_saturated", "gait", "amber", "EMG channels sit at their limits; share of the worst.",
         {"trial": "text", "channels_list": "text", "samples_share": "share"}),
    Kind("emg_scale_doubtful", "gait", "amber", "EMG channels whose envelopes are far from their greatest contraction; "
         "how far the first one's greatest value is.", {"channels_list": "text", "peak_share": "share"}),
    Kind("emg_hums", "gait", "amber", "The mains are heard in EMG channels.",
         {"trial": "text", "channels_list": "text", "mains": "Hz"}),
    Kind("emg_left_out", "gait", "info", "Channels of EMG that cannot be read as such, and why the first cannot.",
         {"trial": "text", "channels_list": "text", "why": "text"}),
    Kind("emg_without_bursts", "gait", "amber", "EMG channels show no bursts, as noise alone does.",
         {"trial": "text", "channels_list": "text"}),
    Kind("emg_without_side", "gait", "amber", "EMG channels do not say their side; they are taken for the left.",
         {"trial": "text", "channels_list": "text"}),
    Kind("gait_good", "gait", "info", "The verdict: nothing was found."),
    Kind("gait_usable", "gait", "info", "The verdict: gait needs attention."),
    Kind("gait_missing", "gait", "info", "The verdict: there is no gait result."),
    Kind("gait_unusable", "gait", "info", "The verdict: markers are exchanged, so that the results are wrong."),
    Kind("gait_measured", "gait", "info", "Strides of both sides, mean speed and cadence.",
         {"left_strides": "count", "right_strides": "count", "speed": "m/s", "cadence": "count"}),
    Kind("gait_deviations", "gait", "info", "Median standard uncertainty of knee flexion, and what makes most of it.",
         {"knee_deg": "deg", "cause": "text", "variance_share": "share"}),
)  # fmt: skip
