"""What may be found by labelling, edits, filling, joint angles, the error budget, the proposal of detection and the
planning of cameras, with their verdicts."""

from __future__ import annotations

from .finding import FindingKind as Kind

LABELLING = (
    Kind("labels_refused", "label", "red", "The template does not fit the trial, so that nothing is named: the score "
         "of the best labelling as a share of what the template scores on its own data, and the share of samples that "
         "it could place.", {"fit_share": "share", "placed_share": "share"}),
    Kind("sides_undecided", "label", "amber", "All names of the left and the right could change places: nothing in "
         "the template tells the one from the other, and none of them is sure."),
    Kind("own_image", "label", "amber", "All distances allow the names of these markers as well in other ways, each "
         "with the name of another: the set is its own image, as a box or a hand with alike fingers is, and none of "
         "them is sure. In how many ways, and of each marker the other name that fits best.",
         {"ways": "count", "other_list": "text"}),
    Kind("world_mirrored", "label", "red", "The trial is the mirror image of the one that the template was learnt "
         "from: distances fit names of the one side, and orientation those of the other, so that none is sure."),
    Kind("labels_without_template", "label", "info", "The session is to name markers, and neither a template nor a "
         "statement tells which is which in this trial."),
    Kind("labels_unsure", "label", "amber", "Stretches of tracks whose name is not sure, so that they have none.",
         {"stretches": "count"}),
    Kind("markers_not_found", "label", "amber", "Markers of the template that no track is, not even probably."),
    Kind("markers_displaced", "label", "amber", "Named markers that sit beside their places in the template, by "
         "so many mm each: they were put on anew, or are other markers. Their names stay.", {"off_mm_list": "mm"}),
    Kind("ghosts_removed", "label", "info", "Tracks that were taken for no markers, as most of their images are those "
         "of named ones.", {"tracks": "count"}),
    Kind("tracks_switched", "label", "info", "Tracks that went over from one marker to another, and were cut there.",
         {"switches": "count"}),
    Kind("second_pass_by_body", "label", "info", "What the named body changed of the tracks: points found where it "
         "expects a marker, given the name of another marker, joined to one from tracks without a name, put aside; and "
         "tracks without a name that were taken for ghosts.",
         {"found": "count", "renamed": "count", "joined": "count", "put_aside": "count", "ghosts": "count"}),
    Kind("stated_names_lost", "label", "amber", "Names that were stated of places where no track is.",
         {"statements": "count"}),
    Kind("stated_names_exchanged", "label", "amber", "Two markers, of which a person stated one, carry each other's "
         "names by the distances to the others: those of the template, or else of the trial's other frames. What was "
         "stated is kept; by a template other trials do not learn from these samples.", {"template": "flag"}),
    Kind("trial_contradicts_template", "label", "amber", "Markers of a labelled trial sit elsewhere than its subject's "
         "template says, so that the template does not learn from it: the share of the distances within segments that "
         "are off, and the most.", {"pairs_share": "share", "off_mm": "mm"}),
    Kind("template_names_impossible", "label", "amber", "Markers of a labelled trial that the template learns from "
         "cannot be where their names say, as a body is made: left and right, or the order along it. The template "
         "learns them all the same.", {"file": "text"}),
    Kind("template_names_exchanged", "label", "amber", "Two markers carry each other's names in a part of a labelled "
         "trial that the template learns from: the distances to their neighbours vary less with both exchanged there. "
         "first and last are frames as that file numbers them. The template does not learn from "
         "these samples, or, where they are more than a tenth, neither marker.",
         {"file": "text", "first": "count", "last": "count", "learnt": "flag"}),
)  # fmt: skip

FILLING = (
    Kind("gaps_open", "fill", "amber", "Gaps that stayed open; red where none was filled.", {"gaps": "count"}),
    Kind("gaps_uncertain", "fill", "amber", "Gaps whose expected error or standard deviation is above the limit.",
         {"gaps": "count", "limit_mm": "mm", "max_mm": "mm"}),
    Kind("gaps_untested", "fill", "amber", "Gaps filled without an expected error.", {"gaps": "count"}),
    Kind("gaps_beyond_tests", "fill", "amber", "Gaps filled in which the body part moves clearly more than in any "
         "hold-out gap; max_ratio is how many times as much at most.", {"gaps": "count", "max_ratio": "ratio"}),
    Kind("gap_sides_contradict", "fill", "amber", "Gaps after which a marker is elsewhere on its body than before: "
         "another marker, or put on anew.", {"gaps": "count", "where_list": "text"}),
    Kind("samples_far_away", "fill", "amber", "Samples farther than a kilometre from the others.",
         {"samples": "count"}),
    Kind("samples_replaced", "fill", "info", "Measured samples beside gaps that were replaced.",
         {"samples": "count", "gaps": "count"}),
    Kind("samples_suspicious", "fill", "info",
         "Measured samples beside gaps that stand out from the marker's own motion, or contradict the others; kept.",
         {"samples": "count", "gaps": "count", "where_list": "text"}),
    Kind("markers_mostly_filled", "fill", "info", "More than the limit of these markers is filled.",
         {"limit_share": "share"}),
    Kind("markers_absent", "fill", "amber", "Markers that this trial never shows; red where it shows none."),
    Kind("gaps_filled", "fill", "info", "The verdict: so many of the gaps are filled.",
         {"filled": "count", "gaps": "count"}),
    Kind("tracks_not_filled", "fill", "info", "Tracks without a name beside markers with one: their gaps are none of a "
         "marker's and stay as they are.", {"tracks": "count", "gaps": "count"}),
    Kind("computed_not_filled", "fill", "info", "Points with missing samples that a program computed of markers: they "
         "stay as they are.", {"points": "count"}),
    Kind("nothing_to_fill", "fill", "info", "The verdict: there are no gaps."),
    Kind("no_marker_seen", "fill", "info", "The verdict: no marker is seen."),
    Kind("expected_gap_error", "fill", "info", "Expected error of a filled sample, median and largest of the gaps, by "
         "hold-out gaps.", {"median_mm": "mm", "max_mm": "mm"}),
    Kind("markers_from_static", "fill", "info", "Markers placed from the static trial; largest expected error.",
         {"count": "count", "max_mm": "mm"}),
    Kind("samples_beyond", "fill", "info", "Samples before a marker's first or after its last that were not to be "
         "filled.", {"samples": "count"}),
)  # fmt: skip

KINEMATICS = (
    Kind("angles_not_computed", "kinematics", "amber", "The session is to compute joint angles, and this trial has "
         "none, for this reason.", {"reason": "text"}),
    Kind("joints_without_angles", "kinematics", "red", "No frame has angles of these joints.", {"joints_list": "text"}),
    Kind("frames_without_angles", "kinematics", "info", "So many frames have no angles of these joints.",
         {"count": "count", "joints_list": "text"}),
    Kind("gimbal_lock", "kinematics", "amber", "A joint is in gimbal lock in these frames.", {"joint": "text"}),
    Kind("angle_jumps", "kinematics", "amber", "An angle changes between two frames as no joint moves.",
         {"joint": "text", "angle": "text", "count": "count", "most_deg": "deg"}),
    Kind("side_of_markers", "kinematics", "info", "The side was not stated; the names of the markers tell it.",
         {"side": "text", "usual": "text"}),
    Kind("angle_beyond_normal", "kinematics", "amber", "An angle is beyond its normal range.",
         {"joint": "text", "angle": "text", "frames_share": "share", "most_deg": "deg"}),
    Kind("markers_smoothed_before", "kinematics", "amber", "The markers' noise is so small that they were smoothed "
         "before, and the deviations of the angles are too small.", {"sd_mm": "mm"}),
    Kind("marker_errors_not_stated", "kinematics", "info", "The file states no errors; how is estimated or assumed.",
         {"how": "text"}),
    Kind("angles_good", "kinematics", "info", "The verdict: nothing was found."),
    Kind("angles_usable", "kinematics", "info", "The verdict: the angles need attention."),
    Kind("angles_missing", "kinematics", "info", "The verdict: a joint has no angles."),
    Kind("angles_computed", "kinematics", "info", "Model, side and frames.",
         {"model": "text", "side": "text", "frame_count": "count"}),
    Kind("angle_deviations", "kinematics", "info", "Least and greatest of the median standard deviations.",
         {"least_deg": "deg", "least_joint": "text", "least_angle": "text", "greatest_deg": "deg",
          "greatest_joint": "text", "greatest_angle": "text"}),
    Kind("cycles_averaged", "kinematics", "info", "Cycles that were averaged.", {"cycles": "count"}),
)  # fmt: skip

SENSITIVITY = (
    Kind("error_limited_by", "sensitivity", "info", "The verdict: the source that limits the recording. Angles: amber "
         "above 2°, red above 5° in a mean of cycles; positions: amber unless it is the placement of markers.",
         {"source": "text"}),
    Kind("error_of_angle", "sensitivity", "info", "Standard uncertainty of an angle, in a frame and in a mean of "
         "cycles, and the source with that share of the variance.",
         {"frame_deg": "deg", "mean_deg": "deg", "cycles": "count", "source": "text", "variance_share": "share"}),
    Kind("error_of_position", "sensitivity", "info", "The same of a marker's position.",
         {"frame_mm": "mm", "mean_mm": "mm", "cycles": "count", "source": "text", "variance_share": "share"}),
    Kind("error_of_cameras", "sensitivity", "info", "What all but the placement of markers makes of it.",
         {"position_mm": "mm", "angle_deg": "deg"}),
    Kind("placement_assumed", "sensitivity", "info", "Placement of markers is assumed; next is the greatest source "
         "that the trial itself shows.", {"placement_mm": "mm", "next_source": "text"}),
    Kind("camera_most_missed", "sensitivity", "info", "Standard uncertainty of a position by the cameras, without this "
         "camera (None: no point is left) and with it, and share of the points lost.",
         {"without_mm": "mm", "with_mm": "mm", "lost_share": "share"}),
    Kind("cameras_losing_points", "sensitivity", "info", "Losing one of these takes more points than the limit.",
         {"limit_share": "share"}),
    Kind("two_cameras_no_loss", "sensitivity", "info", "With two cameras nothing is measured when one is lost."),
)  # fmt: skip

PROPOSAL = (
    Kind("images_white", "detect", "amber", "Most pixels have the brightest level.", {"white_share": "share"}),
    Kind("nothing_stands_out", "detect", "amber", "No markers stand out from the background.",
         {"brightest": "level", "white": "level", "background": "level", "noise": "level"}),
    Kind("markers_dark", "detect", "info", "Markers are dark on a bright ground."),
    Kind("no_clear_gap", "detect", "amber", "Noise and markers are hardly apart in brightness.",
         {"low": "level", "high": "level", "white": "level"}),
    Kind("bright_without_markers", "detect", "amber", "Many bright pixels belong to no marker.",
         {"pixels_share": "share"}),
    Kind("light_clipped", "detect", "amber", "Many markers reach the brightest level.", {"groups_share": "share"}),
    Kind("spots_standing", "detect", "info", "Spots of a marker's size that never move while others do, and where, in "
         "px of the image: lamps or reflections.", {"at_list": "text"}),
    Kind("few_bits_used", "detect", "info", "Images of 16 bits use no level above this.", {"white": "level"}),
)  # fmt: skip

EDITS = (
    Kind("edits_orphaned", "edit", "amber", "Edits that no longer find their place; they are kept and applied to "
         "nothing: the number of each entry, and why.", {"edits": "count", "entries_list": "text"}),
    Kind("edits_thin", "edit", "amber", "Edits that stand on few of their witnesses: the number of each entry, and "
         "how many were found.", {"edits": "count", "entries_list": "text"}),
    Kind("edits_unreadable", "edit", "amber", "Lines of the journal that are damaged, were changed, or are of a later "
         "version: the number of each line, and what is wrong.", {"lines": "count", "lines_list": "text"}),
    Kind("edits_applied", "edit", "info", "What became of the journal's entries: those that stand, that had nothing "
         "left to do, and that later ones took the place of.",
         {"entries": "count", "held": "count", "moot": "count", "overruled": "count"}),
)  # fmt: skip

PLAN_KINDS = (
    Kind("plan_covers", "plan", "info", "The verdict: shares of the walking body's markers (of the places of the "
         "volume where there is no body) that at least two, and at least three cameras measure. Red below 95 % by two, "
         "amber below 99 % by two or 95 % by three.",
         {"camera_count": "count", "two_share": "share", "three_share": "share", "body": "flag"}),
    Kind("plan_error", "plan", "info", "Median and 95th percentile of the predicted standard deviation of a marker's "
         "position, per axis, and the centroids' it was predicted from; calibrated: cameras that state their own "
         "calibration's error.",
         {"sd_median_mm": "mm", "sd_95_mm": "mm", "centroid_px": "px", "body": "flag", "calibrated": "count"}),
    Kind("plan_volume", "plan", "info", "The same shares of the empty volume, and the median standard deviation there.",
         {"two_share": "share", "three_share": "share", "sd_median_mm": "mm"}),
    Kind("plan_following", "plan", "info", "What one more camera would bring, at the best place for it.",
         {"three_share": "share", "three_share_after": "share", "sd_median_mm": "mm", "sd_median_after_mm": "mm"}),
    Kind("plan_camera_most_missed", "plan", "info", "The camera without which fewest is measured: the share that two "
         "cameras measure then, and the median standard deviation.", {"two_share": "share", "sd_median_mm": "mm"}),
)  # fmt: skip

STAGE_KINDS = (*LABELLING, *FILLING, *KINEMATICS, *SENSITIVITY, *PROPOSAL, *EDITS)
