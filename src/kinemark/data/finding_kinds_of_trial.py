"""What may be found of a trial: of the recording, its cameras, its points and its tracks; and what its verdict says."""

from __future__ import annotations

from .finding import FindingKind as Kind

TRIAL_KINDS = (
    # Nothing there
    Kind("no_frames", "record", "red", "The recording has no frames."),
    Kind("no_detections", "detect", "red", "No camera has any detection."),
    Kind("no_points", "reconstruct", "red", "There are detections but no points; diagnosed: whether the tracking "
         "found something odd about its input.", {"diagnosed": "flag"}),
    Kind("no_trajectories", "track", "red", "There are points but no trajectory."),
    # Cameras
    Kind("camera_sees_nothing", "detect", "amber", "A camera has no detection, while others have some."),
    Kind("ground_subtracted", "detect", "info", "Uneven static ground was subtracted from the images of cameras."),
    Kind("camera_disagrees", "reconstruct", "amber", "The median residual of a camera is far above the median of the "
         "others, by this ratio (None where theirs is 0); the offset is the median of detection less reprojection.",
         {"residual_px": "px", "ratio": "ratio", "offset_u_px": "px", "offset_v_px": "px"}),
    Kind("cameras_agree_poorly", "reconstruct", "amber", "The median residual of all images is high; red above 3 px.",
         {"residual_px": "px"}),
    Kind("calibration_residual_high", "calibrate", "amber", "The calibration states a residual above the limit, and "
         "nobody judged it.", {"limit_px": "px"}),
    Kind("calibration_verdict", "calibrate", "info", "The calibration's own verdict is not green; red where it is. "
         "sd_mm: standard deviation per axis in that share of the volume.",
         {"grade": "text", "sd_mm": "mm", "volume_share": "share"}),
    Kind("detections_unused", "reconstruct", "amber", "Few of a camera's valid detections belong to a point, of those "
         "that neither stand nor are fleeting; red where most of all do not. used_share is the least of these cameras.",
         {"used_share": "share"}),
    Kind("reflections_standing", "detect", "info", "Detections of cameras that belong to no point stay at so many "
         "places, camera by camera, while tracks move: lamps or reflections. at_list names the first of these places, "
         "in px of the images; images_share is the most of a camera.",
         {"spots_list": "count", "at_list": "text", "images_share": "share"}),
    Kind("images_fleeting", "detect", "info", "Many detections of a camera belong to no point and are seen in one "
         "frame alone. images_share is the most of a camera.", {"images_share": "share"}),
    Kind("two_camera_points", "reconstruct", "amber", "Many points rest on only two cameras.",
         {"points_share": "share"}),
    Kind("scale_impossible", "calibrate", "red", "The outermost cameras stand nearer to each other than cameras are "
         "wide, or farther apart than they see: the calibration's unit of length is probably another.",
         {"apart_mm": "mm"}),
    Kind("length_unit_doubtful", "calibrate", "info", "By the calibration's unit of length the markers are smaller or "
         "larger than any (amber), or all lie as near to the cameras and to each other as a person in another unit. "
         "marker_mm: width of a marker by its images, None where they have no area; distance_mm: of the markers from "
         "the cameras; extent_mm: longest side of where the markers are.",
         {"marker_mm": "mm", "distance_mm": "mm", "extent_mm": "mm"}),
    Kind("pixels_not_square", "calibrate", "amber", "Focal lengths along u and v differ, and not as in fields."),
    Kind("frame_rate_contradicted", "record", "amber", "Videos state another frame rate than the session; one stated "
         "rate a camera.", {"rate_hz": "Hz", "stated_hz_list": "Hz"}),
    Kind("camera_fewer_images", "record", "amber", "A camera has fewer images than the others: it began or stopped "
         "apart, or lost some.", {"images": "count", "most_images": "count"}),
    Kind("channels_resampled", "record", "info", "Channels whose rate or start does not fall on the one clock of a C3D "
         "file, interpolated there; their source keeps them as they were.",
         {"channels": "count", "channels_list": "text", "rate_hz": "Hz", "stored_rate_hz": "Hz"}),
    Kind("channels_cut", "record", "info", "Channels that reach beyond the frames, of which a C3D file holds no more; "
         "their source keeps the rest.", {"channels": "count", "channels_list": "text", "duration_s": "s"}),
    Kind("recording_partly_read", "record", "amber", "Parts of the recording's file could not be read.",
         {"parts_list": "text"}),
    Kind("recording_notes", "record", "info", "What is odd in the recording's file and was read, and blocks of it that "
         "nothing here needs.", {"parts_list": "text"}),
    Kind("cameras_swapped", "match", "red", "Two cameras have each other's images; several pairs where they do as "
         "well, cameras two by two. Shares of their detections confirmed by two more cameras, swapped and as it is.",
         {"swapped_share": "share", "as_is_share": "share"}),
    Kind("cameras_with_same_images", "match", "red", "Two cameras have the same images, to the last digit: one file is "
         "given for both. Amber where tracking left one of them out."),
    Kind("pixel_axes_differ", "match", "red", "The images count their pixels otherwise than the calibration: v from "
         "the bottom (v_up), u from the right (u_left), both (turned), the row before the column (exchanged), in "
         "images of half_size or double_size, from the centre (centre, centre_v_up) or as shares of the size (share, "
         "share_v_up). Shares of the detections confirmed by two more cameras, counted so and "
         "as it is, in the median camera.",
         {"way": "text", "other_share": "share", "as_is_share": "share"}),
    # What tracks show of their input
    Kind("camera_out_of_sync", "track", "amber", "A camera takes its images later (or earlier, below 0) than the "
         "others; shift_px is how far that moves its images.",
         {"delay_ms": "ms", "delay_frames": "frames", "shift_px": "px"}),
    Kind("camera_started_apart", "track", "amber", "A camera was started later (or earlier, below 0) than the others, "
         "by whole images; state_ms is what to state as its delay: with all that is stated, and learned.",
         {"images": "count", "delay_ms": "ms", "state_ms": "ms"}),
    Kind("camera_late_as_calibrated", "track", "amber", "A camera was taken to be as late (or early, below 0) as "
         "the calibration's film told, where it then fits better: delay_ms, of it whole images; state_ms as above.",
         {"images": "count", "delay_ms": "ms", "state_ms": "ms"}),
    Kind("camera_dropped_images", "track", "amber", "A camera dropped images about a frame, or has some twice (below "
         "0): its later ones are those of frames later by images in all. Kinemark's own tracker puts them into the "
         "frames that they show, if they then fit better.", {"dropped": "count", "images": "count"}),
    Kind("camera_delay_learned", "track", "amber", "A camera takes its images later (or earlier, below 0) than the "
         "others by delay_ms, of standard error delay_se_ms; all was tracked with this delay; state_ms as above.",
         {"delay_ms": "ms", "delay_se_ms": "ms", "state_ms": "ms"}),
    Kind("camera_rolling_shutter", "track", "amber", "A camera takes the last row of its images later (or earlier, "
         "below 0) than the first by readout_ms, of standard error readout_se_ms; all was tracked so.",
         {"readout_ms": "ms", "readout_se_ms": "ms"}),
    Kind("camera_uneven_times", "track", "amber", "The times of a camera's images scatter by uneven_ms, standard "
         "deviation; its images count the less the faster they are.", {"uneven_ms": "ms"}),
    Kind("camera_without_images", "track", "amber", "A camera has no images at all."),
    Kind("camera_stopped", "track", "amber", "A camera has no images in the last frames, though markers were in view.",
         {"recorded_frames": "count"}),
    Kind("camera_started_late", "track", "amber", "A camera has no images in the first frames, though markers were in "
         "view.", {"recorded_frames": "count"}),
    Kind("camera_moved", "track", "amber", "A camera's images fit no track any more in these frames, as they "
         "do else."),
    Kind("camera_shifted", "track", "amber", "A camera's images lie beside where the others expect them; with frames "
         "where that began within the recording; left_out where none of them was used.",
         {"offset_u_px": "px", "offset_v_px": "px", "left_out": "flag"}),
    Kind("camera_put_right", "track", "amber", "A camera's images lay beside where the others expect them; it "
         "was turned, and moved a little, until they did not, and used. The trial's rig.toml has it as it was found; "
         "with frames, where that began within the recording, as it was before.",
         {"offset_u_px": "px", "offset_v_px": "px"}),
    Kind("cameras_put_in_order", "track", "amber", "Cameras have images of each other, images_of_list those of which "
         "one, in the cameras' order; each was given the calibration of the one whose images it has, and used.",
         {"images_of_list": "text"}),
    Kind("calibration_off", "track", "amber", "The images of most cameras lie beside where the others expect them, by "
         "offset_px in the median camera.", {"offset_px": "px"}),
    Kind("lens_terms_unstated", "track", "amber", "The calibration states no lens term, and the images do not fit "
         "without; k1_list is the radial term that they have, camera by camera. Where the terms were lost from a "
         "calibration that had them, all was tracked and solved with these. Else nothing was changed, and it is red "
         "where the images lie sd_px, standard deviation, above 1 px beside each other's lines.",
         {"lost": "flag", "sd_px": "px", "k1_list": "ratio"}),
    Kind("lens_terms_taken_out", "track", "amber", "The calibration states lens terms, and the images fit clearly "
         "better without, as where distortion was taken out of them before: by the calibration as it is they lie "
         "sd_px, standard deviation, beside each other's lines. All was tracked and solved without lens terms.",
         {"sd_px": "px"}),
    Kind("strobes_seen", "track", "info", "In the images of cameras something shines where the rig has other cameras, "
         "of_list: their strobes, which were left out.", {"of_list": "text"}),
    Kind("noise_overstated", "track", "amber", "The centroids state a standard deviation of stated_px, far more than "
         "that by which the images of the median camera lie beside each other's lines, seen_px; the latter was "
         "believed.", {"stated_px": "px", "seen_px": "px"}),
    Kind("camera_takes_place_of_other", "track", "amber", "The first camera sees what the second should see.",
         {"left_out": "flag"}),
    Kind("camera_fits_nothing", "track", "amber", "A camera's images fit nothing that the others see.",
         {"left_out": "flag"}),
    Kind("camera_in_doubt", "track", "amber", "A camera's images hardly fit those of the others, and too few points "
         "have images of three cameras to tell which is wrong; points that two cameras see may be no markers."),
    Kind("nothing_goes_on", "track", "amber", "Cameras agree in single frames, but no marker goes on to the next: the "
         "frame rate may be wrong.", {"rate_hz": "Hz"}),
    Kind("too_few_frames", "track", "amber", "The recording has fewer frames than any track needs.",
         {"frame_count": "count", "least": "count"}),
    Kind("speeds_impossible", "track", "amber", "Markers move faster than people can: the frame rate may be wrong.",
         {"speed_m_s": "m/s", "rate_hz": "Hz"}),
    Kind("points_dropped_outside", "track", "amber", "Tracked points farther than `volume_margin` outside the control "
         "volume were left out; between which corners they lie; the unit in which the volume was probably written.",
         {"points": "count", "points_share": "share", "margin_mm": "mm", "least_mm_list": "mm",
          "greatest_mm_list": "mm", "unit": "text"}),
    Kind("angle_model_unused", "track", "amber", "An angle model was given to the tracking and corrected nothing. why "
         "is unrecognised (its markers were not found among the tracks), no_neighbour (they were missing, in so many "
         "frames of all markers, with none in sight to place them from) or not_needed (none was missing: info).",
         {"why": "text", "missing": "count"}),
    Kind("positions_uncertain", "track", "info", "Positions whose standard deviation exceeds a limit, as where two "
         "cameras look along almost one line; frames in which there are any.",
         {"points": "count", "points_share": "share", "limit_mm": "mm"}),
    # Markers and tracks
    Kind("markers_never_seen", "track", "amber", "Markers without any sample."),
    Kind("incomplete", "track", "amber", "Few of the markers' positions are there while the subject is in view; the "
         "least complete markers come first.", {"complete_share": "share"}),
    Kind("tracks_broken", "track", "amber", "More unlabelled tracks than markers; red where many times more.",
         {"tracks": "count", "markers_worn": "count"}),
    Kind("tracks_continue", "track", "info", "Tracks that likely continue earlier ones, by their distances to others, "
         "and are not joined to them: the name of each earlier one and, in the same order, of the later one.",
         {"tracks": "count", "earlier_list": "text", "later_list": "text"}),
    Kind("tracks_still", "track", "info", "Tracks that stay within a limit while others move, by this in the median: "
         "probably lamps or reflections.", {"limit_mm": "mm", "moved_mm": "mm"}),
    Kind("tracks_mirrored", "track", "amber", "Tracks that are mirror images of others in a plane behind which no "
         "camera stands, as a wet floor or a window: they are no markers, and get no name."),
    Kind("tracks_confusable", "track", "amber", "Tracks came so near each other, for the rate, that they may have been "
         "exchanged: how many such decisions, and the share of all points; red where many times more.",
         {"decisions": "count", "points_share": "share"}),
    Kind("rate_too_low", "track", "amber", "Points leave the course of their track from one frame to the next by more "
         "than half of the distance to another track: their share.",
         {"points_share": "share", "rate_hz": "Hz"}),
    Kind("long_gaps", "track", "amber", "Gaps above the limit are left.", {"limit_s": "s"}),
    Kind("much_filled", "fill", "amber", "Much of these markers is filled, not measured.", {"limit_share": "share"}),
    Kind("markers_uncertain", "reconstruct", "amber", "The mean standard deviation is above the limit.",
         {"limit_mm": "mm"}),
    Kind("noise_above_deviation", "reconstruct", "amber", "Positions tremble by more than their standard "
         "deviation says.", {"sd_mm": "mm", "noise_mm": "mm"}),
    Kind("outside_volume", "reconstruct", "amber", "Samples lie outside the given control volume.",
         {"samples_share": "share"}),
    Kind("unnamed_trajectories", "track", "info", "Trajectories without a marker's name.",
         {"unnamed": "count", "trajectories": "count"}),
    Kind("points_in_no_track", "track", "amber", "Points that belong to no track.", {"points_share": "share"}),
    Kind("close_decisions", "track", "info", "Ambiguous decisions of the tracking, by kind.",
         {"swap": "count", "merge": "count", "ghost": "count", "stitch": "count"}),
    # What the verdict says
    Kind("trial_good", "track", "info", "The verdict: nothing was found."),
    Kind("trial_usable", "track", "info", "The verdict: usable with care."),
    Kind("trial_unknown", "track", "info", "The verdict: how good it is is not known, since the calibration states no "
         "error; whatever else was found is amber at most."),
    Kind("trial_unusable", "track", "info", "The verdict: not to be used."),
    Kind("recorded", "record", "info", "What was recorded; track_count is None where trajectories have names.",
         {"camera_count": "count", "marker_count": "count", "track_count": "count", "duration_s": "s",
          "frame_count": "count", "rate_hz": "Hz"}),
    Kind("completeness", "track", "info", "How complete the markers are while the subject is in view; shown is how "
         "many there are by the images of a frame, where that is more than were found.",
         {"complete_share": "share", "shown": "count", "filled_share": "share", "gaps": "count", "longest_s": "s"}),
    Kind("completeness_unknown", "track", "info", "How complete the markers are is not known: of the images only that "
         "share belongs to a point; the other values are of the markers that were found.",
         {"complete_share": "share", "used_share": "share", "filled_share": "share", "gaps": "count",
          "longest_s": "s"}),
    Kind("agreement", "reconstruct", "info", "The median residual, and what it is at the subject.",
         {"residual_px": "px", "at_subject_mm": "mm"}),
    Kind("position_deviation", "reconstruct", "info", "Mean standard deviation of a position, per axis, and how much "
         "of it is noise from frame to frame; without errors of a calibration that states none.",
         {"sd_mm": "mm", "noise_mm": "mm", "calibration_known": "flag"}),
    Kind("room_deviation_of_trial", "calibrate", "info", "Standard deviation per axis by which all positions of the "
         "trial together may lie elsewhere in the room; it is in none of their own.", {"sd_mm": "mm"}),
)  # fmt: skip
