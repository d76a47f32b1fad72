"""The origin of the world is arbitrary: a trial 10 km away gives the same answer, 10 km away.

Each public function that takes positions has a case in the modules `support.shift_*`: what it gives in a world moved
by `by`. Places must move along, and all else must stay: distances, angles, covariances, pixels, names, choices. Inputs
lie on a grid that such a move does not round, so that what is left is the rounding of the computation; 10 km has ulp
1.9e-9 mm.
"""

import importlib
import inspect
import pkgutil
from dataclasses import replace

import numpy as np
import pytest

import kinemark
from kinemark.fill import Linear, fill
from support import shift_edits, shift_files, shift_gait, shift_motion, shift_scene, shift_space, shift_tracks
from support.shift_law import CASES, FAR, differences, moved

MODULES = shift_gait, shift_motion, shift_space, shift_tracks, shift_files, shift_edits
"""Of cases."""


@pytest.mark.parametrize("name", CASES)
def test_far_away_the_answer_is_the_same(name):
    case, mm, share, _ = CASES[name]
    places, rest = differences(case(np.zeros(3)), case(FAR), FAR)
    assert places <= mm and rest <= share, f"places are off by {places:.2g} mm, the rest by {rest:.2g} of itself"


NO_POSITIONS = {
    "pixels, images and their files": """
        calibrate.aspect_ratio calibrate.corrected calibrate.find_corners calibrate.find_marks calibrate.linearise
        calibrate.mark_shift calibrate.order_grid calibrate.part_of_grid calibrate.reference_shift
        calibrate.rows_of_points calibrate.straightness calibrate.thinned calibrate.unknown_optics
        calibrate.wand_points detect.combined_masks detect.detect detect.detect_frames detect.detect_nearest
        detect.detect_scanning detect.learn_masks detect.propose digitise.clicked digitise.identified
        digitise.find_markers digitise.nearest_free digitise.threshold_of io.open_images io.read_da io.read_da_set
        io.read_detections_csv
        io.read_rf io.write_da io.write_detections_csv io.write_rf""",
    "cameras found from images alone, in a world of their own": """
        calibrate.calibrate_points calibrate.calibrate_sticks calibrate.calibrate_wand calibrate.start""",
    "the operator's questions and answers": """
        data.answer_text data.parse_answer digitise.advance digitise.begin digitise.drive digitise.given
        digitise.question_of digitise.result digitise.words""",
    "which detection is which": """
        digitise.identified_matches digitise.identified_tracks geometry.check_cameras
        signal.assign signal.assign_nearest signal.cheapest_first""",
    "directions, rotations, angles, phases and their files": """
        signal.component_angles fill.cycle_events fill.intervals fill.model_events geometry.nearest_rotations
        gait.five_point gait.five_point_slope gait.gait_curves gait.spline_acceleration
        geometry.polar_rotations io.read_angles io.write_angles kinematics.cycles
        data.outside kinematics.inverse_cosines kinematics.principal kinematics.resampled kinematics.spans_of
        kinematics.turned sensitivity.cycle_weights""",
    "numbers, matrices, settings, models, names": """
        calibrate.centroid_deviation calibrate.free_parameters calibrate.marker_places data.same
        data.make_finding reconstruct.image_errors io.camera_number io.read_measures
        io.load_model io.on_frames io.files_of_set io.subject_of io.with_parameters data.named_angles
        report.evidence_text edit.name_probability edit.in_trial
        track.diagnose_model engine.before engine.load_named
        engine.save_named label.figure_template data.sides_by_name label.template_of_subjects io.marker_sets
        io.read_marker_set io.write_marker_set io.prefixes_of io.modeled_points
        sensitivity.placed_points sensitivity.typical
        engine.calibrate_method engine.frame_of engine.source_of engine.is_da
        engine.answered engine.beside_key engine.earlier_calibrations engine.last_calibration engine.with_facts
        engine.calibration_table
        engine.identifies engine.propose_session engine.recorded_beside
        engine.session_text engine.with_role
        engine.write_first_session engine.method_of engine.methods_text engine.check_camera_names
        engine.methods_figures engine.methods_table_markdown engine.session_schema track.matches_itself
        engine.read_settings signal.gain signal.weights synth.focal_pixels""",
    "findings and their words": """
        report.advice_of report.headline_of report.open_gap_text report.place_of_reason
        report.edit_text report.entry_text report.frames_text report.reason_text report.sentences_of
        report.text_of report.with_words""",
    "compiled parts of functions that have a case": """
        native.candidates native.cluster_pixels native.cut_pixels native.find_runs native.group_peaks native.group_runs
        native.index_images native.information native.intersect native.inverse native.library native.predict
        native.project native.status native.sum_peaks native.sum_pixels native.update""",
    "motions at places of their own": """
        synth.circle_over_cylinder synth.elbow_flexion synth.gait_laboratory synth.tilted_rectangle""",
    "files of what others give: of `quality` and `scene`, of `film` and `truth`; of BTS, which is only read": """
        findings.write_quality report.write_report synth.write_calibration synth.write_session io.read_tdf""",
}
"""By what they take instead, functions without a case."""

BY_THE_ORIGIN = """
    io.read_cp io.read_cp_set io.write_cp"""
"""UM²AS (eq. 2.4) solves for eleven parameters in units of the depth of the world's origin, and writes
them with seven digits: for these the origin is not arbitrary."""


def public_functions():
    """Every function that the package or one of its parts exports, by its part and name."""
    parts = [module.name for module in pkgutil.walk_packages(kinemark.__path__, "kinemark.") if module.ispkg]
    for part in map(importlib.import_module, ["kinemark", *parts]):
        for name in getattr(part, "__all__", ()):
            function = getattr(part, name)
            if inspect.isfunction(function):
                yield f"{function.__module__.split('.')[1]}.{name}", function


def test_every_function_that_takes_positions_has_a_case():
    covered = {function for *_, functions in CASES.values() for function in functions}
    public = dict(public_functions())
    excused = [name for names in (*NO_POSITIONS.values(), BY_THE_ORIGIN) for name in names.split()]
    assert len(set(excused)) == len(excused) and not set(excused) - set(public)
    assert not [name for name in excused if public[name] in covered]
    assert not [name for name, function in public.items() if function not in covered and name not in excused]


def test_a_sample_a_kilometre_from_the_others_is_none_wherever_the_origin_lies():
    """Walks 2 km from the origin were filled by `body` and refused by `linear`."""
    trial = shift_scene.trial()
    wild = trial.xyz
    wild[4, 12] += [0.0, 0.0, 1.1e6]
    paths = [replace(path, xyz=xyz) for path, xyz in zip(trial, wild, strict=True)]
    for by in (np.zeros(3), np.array([2e6, 0.0, 0.0]), FAR):
        filled, gaps = fill(moved(replace(trial, paths=tuple(paths)), by), method=Linear())
        assert {(gap.start, gap.stop) for gap in gaps if gap.method} == {(12, 13), (30, 40)}
        assert np.abs(filled.xyz[4, 12] - by - trial.xyz[4, 12]).max() < 20.0
