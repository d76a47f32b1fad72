"""Where the detections of a trial come from: images, a file of detections, or images that an operator digitises.

A source is a plain value: the session's folder and settings, the trial's entry, the cameras. It opens what it names
when it is asked, so that it can be sent to another process.
"""

from ..settings import is_da
from .detection_file import DetectionFile, NamedDetectionFile, names_markers
from .excerpt import frame_of
from .images import Images
from .operated import DigitisedFiles, OperatedImages
from .recording import Frames, Recording
from .trial_source import OperatorIdentities, TrialSource, beside_key, recorded_beside

__all__ = [
    "Frames",
    "OperatedImages",
    "OperatorIdentities",
    "Recording",
    "TrialSource",
    "beside_key",
    "frame_of",
    "identifies",
    "recorded_beside",
    "source_of",
]


def identifies(source: TrialSource) -> bool:
    """Whether a source says which marker each detection is, so that nothing is matched or tracked."""
    return source.of.entry.operated or isinstance(source, NamedDetectionFile)


def source_of(of: Recording) -> TrialSource:
    """The source that a trial's entry names."""
    if of.entry.images is None:
        if is_da(of.root / str(of.entry.detections)):
            return DigitisedFiles(of)
        return NamedDetectionFile(of) if names_markers(of) else DetectionFile(of)
    return OperatedImages(of) if of.entry.answers is not None else Images(of)
