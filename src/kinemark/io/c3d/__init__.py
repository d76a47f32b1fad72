"""C3D, the format in which laboratories exchange recordings: see `docs/reference/files-c3d.md`."""

from .about import prefixes_of, subject_of
from .analog_rates import on_frames
from .document import C3D, with_parameters
from .header import HeaderEvent
from .numbers import ByteOrder
from .parameters import Group, Parameter
from .points import modeled_points
from .reading import decode_document, read_document
from .storing import document_of, stored, write_c3d
from .to_trial import read_c3d, trial_of
from .writing import encode_document, write_document

__all__ = [
    "C3D",
    "ByteOrder",
    "Group",
    "HeaderEvent",
    "Parameter",
    "decode_document",
    "document_of",
    "encode_document",
    "modeled_points",
    "on_frames",
    "prefixes_of",
    "read_c3d",
    "read_document",
    "stored",
    "subject_of",
    "trial_of",
    "with_parameters",
    "write_c3d",
    "write_document",
]
