"""What may be found of a calibration, and what its verdict says."""

from __future__ import annotations

from .finding import FindingKind as Kind

CALIBRATION_KINDS = (
    # Control points judge themselves: severity info is good, amber usable, red bad
    Kind("control_points_return", "calibrate", "info", "How far control points that took no part come back from where "
         "they were surveyed, and 1 part of the volume's diagonal in how many; limit_parts is the one that it missed.",
         {"rms_mm": "mm", "max_point": "text", "max_mm": "mm", "parts": "parts", "diagonal_m": "m",
          "limit_parts": "parts"}),
    Kind("control_points_by_residual", "calibrate", "info", "Points are too few to leave one out (or one camera is "
         "alone), so residuals judge: 1 part of the images' extent in between least and most parts.",
         {"alone": "flag", "equations": "count", "error_px": "px", "parts_least": "parts", "parts_most": "parts",
          "limit_parts": "parts"}),
    Kind("no_equations_left", "calibrate", "amber", "As many equations as parameters: residuals say nothing."),
    Kind("cameras_miss_control_points", "calibrate", "red", "Residuals of these cameras are bad by themselves.",
         {"residual_px_list": "px", "limit_parts": "parts"}),
    Kind("cameras_worse_than_others", "calibrate", "amber", "Residuals of these cameras are larger than the others' "
         "beyond chance.", {"residual_px_list": "px", "limit_ratio": "ratio"}),
    Kind("residuals_above_noise", "calibrate", "amber", "Residuals are larger than the centroids' noise explains.",
         {"residual_px": "px", "ratio": "ratio"}),
    Kind("control_points_left_out", "calibrate", "info", "Images that a camera left out: how far off each is, and the "
         "point where it seems to belong. Amber where they are many.",
         {"points_list": "text", "off_px_list": "px", "place_of_list": "text"}),
    Kind("control_points_swapped", "calibrate", "red", "Control points are taken for one another in a camera's image: "
         "each point, the point whose image it has, and the residual before and after.",
         {"points_list": "text", "image_of_list": "text", "before_px": "px", "after_px": "px"}),
    Kind("control_point_misplaced", "calibrate", "red", "Without one control point a camera sees the others much "
         "better.", {"point": "text", "before_px": "px", "after_px": "px"}),
    Kind("control_points_displaced", "calibrate", "amber", "All cameras see these control points elsewhere than "
         "surveyed. where: other (each at the place of the other), alike (all shifted alike) or apart; the mean shift, "
         "the least and greatest distance; less far off ones; residuals with and without them, None where unused.",
         {"where": "text", "points_list": "text", "shift_mm_list": "mm", "least_mm": "mm", "greatest_mm": "mm",
          "less_points_list": "text", "less_mm_list": "mm", "before_px": "px", "after_px": "px"}),
    Kind("focal_length_uncertain", "calibrate", "amber", "A camera's points determine its focal length poorly.",
         {"sd_share": "share"}),
    Kind("control_points_unseen", "calibrate", "info", "No camera sees these control points.", {"points_list": "text"}),
    Kind("control_points_seen_by_few", "calibrate", "info", "Less than half of the cameras see these control points.",
         {"points_list": "text"}),
    # Any calibration
    Kind("cameras_miss_points", "calibrate", "amber", "RMS residuals of these cameras are high; red above 3 px.",
         {"max_px": "px"}),
    Kind("camera_fits_worse", "calibrate", "amber", "A camera's residual is far above the median of the others.",
         {"residual_px": "px", "others_px": "px"}),
    Kind("left_out_errors_large", "calibrate", "amber", "Points that took no part are missed by much more than the "
         "residual; the ratio is the largest.", {"ratio": "ratio"}),
    Kind("control_points_disagree", "calibrate", "amber", "The other points do not agree with these.",
         {"points_list": "text", "max_px": "px"}),
    Kind("images_left_out", "calibrate", "amber", "Many images of points were left out as wrong.",
         {"images_share": "share"}),
    Kind("volume_unseen", "calibrate", "amber", "Fewer than two cameras see this share of the volume; red above 30 % "
         "of a stated one.", {"volume_share": "share", "volume_given": "flag"}),
    Kind("volume_seen_by_two", "calibrate", "amber", "Only two cameras see this share of the volume.",
         {"volume_share": "share", "volume_given": "flag"}),
    Kind("two_cameras_only", "calibrate", "info", "With two cameras nothing is measured when one is lost."),
    Kind("camera_indispensable", "calibrate", "info", "Without this camera the error is so many times as large, and "
         "that share of the volume is no longer measured (None where it is small).",
         {"ratio": "ratio", "unseen_share": "share"}),
    Kind("points_cover_part", "calibrate", "info", "Calibration points cover only part of the volume in these cameras' "
         "images; amber where it is very little.", {"least_share": "share"}),
    Kind("lens_uncertain", "calibrate", "amber", "The lens is hardly determined in parts of these cameras' images.",
         {"max_px": "px"}),
    Kind("points_outside_image", "calibrate", "amber", "Points lie outside these cameras' images, up to this share of "
         "one's.", {"most_share": "share"}),
    Kind("lens_folds", "calibrate", "info", "In parts of these cameras' images, up to this share, the lens terms fold "
         "the image over, so that nothing seen there has a direction.", {"most_share": "share"}),
    Kind("scale_doubtful", "calibrate", "amber", "A length that took no part comes out wrong; red above 2 %.",
         {"length": "text", "known_mm": "mm", "found_mm": "mm", "error_share": "share"}),
    Kind("cameras_distance_implausible", "calibrate", "red", "The median distance between cameras is not that of a "
         "laboratory.", {"apart_mm": "mm"}),
    Kind("cameras_at_one_place", "calibrate", "red", "Two cameras stand within each other."),
    Kind("wand_length_wrong", "calibrate", "amber", "The wand's length in poses that took no part; red above 2 %.",
         {"rms_mm": "mm"}),
    Kind("wand_length_wrong_here", "calibrate", "amber", "The wand's length is wrong about one place.",
         {"place_mm_list": "mm", "error_mm": "mm"}),
    Kind("film_halves_differ", "calibrate", "amber", "One half of a wand's or marker's film fits cameras of its own "
         "much better than those of all frames: the squares of its residuals are so many times less. Red above twice.",
         {"ratio": "ratio"}),
    Kind("wand_gaps_differ", "calibrate", "amber", "The images show other gaps between the wand's markers than stated; "
         "theirs were taken, the length as a whole as stated. Info below 0.2 % of the length.",
         {"stated_mm_list": "mm", "seen_mm_list": "mm"}),
    Kind("camera_moved_while_calibrating", "calibrate", "amber", "From a frame on the cameras do not fit each other as "
         "before, while a wand or marker was waved: a camera's image lies beside by offset_px, from from_s on; no "
         "camera where several would explain it. It was calibrated by the images that were kept: those after the move, "
         "or before it or all, with a larger uncertainty of the camera; then red above 1 px.",
         {"offset_px": "px", "from_s": "s", "kept": "text"}),
    Kind("camera_late_while_calibrating", "calibrate", "amber", "A camera took the images of a waved wand later than "
         "the others, by this many of them; they were moved in time.", {"late_images": "ratio", "delay_ms": "ms"}),
    Kind("camera_lost_images_while_calibrating", "calibrate", "amber", "A camera lost images of a waved wand, before "
         "one of these frames, or took some twice (below 0); the others were put in the frames that they show. Of two "
         "cameras nobody knows which it was, and none is named.", {"images": "count"}),
    Kind("l_frame_moved", "calibrate", "amber", "The L-frame, or something taken for it, stood elsewhere in some "
         "frames, which were left out.", {"frame_count": "count", "read_frames": "count", "off_mm": "mm"}),
    Kind("world_seen_elsewhere", "calibrate", "amber", "What shows the world, an L-frame or surveyed points, is seen "
         "offset_px beside where the other cameras have it, by a camera that was left out there; red where nobody "
         "knows which.", {"offset_px": "px"}),
    Kind("world_points_disagree", "calibrate", "amber", "Surveyed points that show the world do not lie where they are "
         "seen, by up to off_mm; the named ones were left out, and rms_mm is left. Red where these do not agree.",
         {"points_list": "text", "off_mm": "mm", "rms_mm": "mm"}),
    Kind("cameras_mirrored", "calibrate", "amber", "These cameras see the world mirrored, and the others do not."),
    Kind("coordinates_mirrored", "calibrate", "amber", "All cameras see the world mirrored: its coordinates are "
         "left-handed. An info save where v grows against z: counted from the bottom, it grows upwards."),
    Kind("cameras_upside_down", "calibrate", "amber", "All cameras of a rig that comes from detections and an L-frame "
         "are upside down: where v is counted from the bottom, the world is mirrored."),
    Kind("precision_low", "calibrate", "amber", "Standard deviation of a position per axis in 95 % of the volume; red "
         "above 10 mm.", {"sd_mm": "mm"}),
    Kind("room_uncertain", "calibrate", "info", "All positions together may lie elsewhere in the room by more than "
         "they are uncertain by themselves: standard deviation per axis in 95 % of the volume. Amber above 2 mm.",
         {"sd_mm": "mm"}),
    Kind("rays_nearly_parallel", "calibrate", "amber", "In that share of the volume all rays meet at a small angle.",
         {"volume_share": "share", "limit_deg": "deg"}),
    Kind("no_uncertainty_stated", "calibrate", "amber", "The calibration states no uncertainty: what error it leaves "
         "is not known."),
    Kind("no_lens_correction", "calibrate", "info", "These cameras have no lens correction."),
    Kind("lens_term_missing", "calibrate", "amber", "Residuals of these cameras go with the place in the image, RMS "
         "and as a share of their noise: lens terms that were not fitted, radial ones, or sideways ones (tangential, "
         "or the principal point). Info where it does no harm.",
         {"max_px": "px", "noise_share": "share", "radial": "flag", "sideways": "flag"}),
    Kind("grid_rows_bent", "calibrate", "amber", "Rows of the linearisation grid stay bent in these cameras."),
    Kind("cameras_moved_since", "calibrate", "info", "These cameras moved against the others since the former "
         "calibration."),
    Kind("world_of_first_camera", "calibrate", "amber", "Nothing says where the laboratory's frame is."),
    Kind("grid_partly_used", "calibrate", "amber", "Only a part of the linearisation grid in an image was used; reason "
         "is the message of the search.", {"reason": "text"}),
    Kind("grid_image_unused", "calibrate", "amber", "An image of the linearisation grid was not used; reason is the "
         "message of the search.", {"reason": "text"}),
    # What the verdict says
    Kind("calibration_good", "calibrate", "info", "The verdict: good for this standard deviation in that share of the "
         "volume.", {"sd_mm": "mm", "volume_share": "share"}),
    Kind("calibration_usable", "calibrate", "info", "The verdict: usable with care.",
         {"sd_mm": "mm", "volume_share": "share"}),
    Kind("calibration_unknown", "calibrate", "info", "The verdict: what it is good for is not known, since it states "
         "no uncertainty."),
    Kind("calibration_unusable", "calibrate", "info", "The verdict: not to be used."),
    Kind("calibrated_by", "calibrate", "info", "How it was made and how well it fits.",
         {"way": "text", "camera_count": "count", "residual_px": "px", "images": "count", "points": "count",
          "left_out_px": "px"}),
    Kind("wand_lengths", "calibrate", "info", "The wand's lengths in poses that took no part.",
         {"poses": "count", "known_mm_list": "mm", "error_abs_mm": "mm", "error_mean_mm": "mm", "error_sd_mm": "mm"}),
    Kind("length_check", "calibrate", "info", "A length that took no part.",
         {"length": "text", "known_mm": "mm", "found_mm": "mm"}),
    Kind("predicted_deviation", "calibrate", "info", "Standard deviation of a position in 95 % of the volume, along an "
         "axis and along its largest axis, for centroids of that noise.",
         {"centroid_sd_px": "px", "calibration_known": "flag", "sd_mm": "mm", "largest_axis_mm": "mm"}),
    Kind("room_deviation", "calibrate", "info", "Standard deviation per axis in 95 % of the volume by which all "
         "positions together may lie elsewhere in the room, and of the turn and the shift where it was given.",
         {"sd_mm": "mm", "turn_deg": "deg", "origin_mm": "mm"}),
    Kind("volume_seen", "calibrate", "info", "Shares of the volume that two and three cameras see, and how many times "
         "as large the error is without the camera that matters most.",
         {"two_share": "share", "three_share": "share", "ratio": "ratio"}),
)  # fmt: skip
