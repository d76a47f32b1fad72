"""Missing samples: fillers, which of them to trust, and how far off they may be."""

from .cyclic import Cyclic, fill_cyclic
from .edges import Edges, Trimmed, trim_edges
from .low_rank_kalman import LowRankKalman, fill_low_rank_kalman
from .motion import Gap, Motion, Prediction, find_gaps
from .pattern import Pattern, fill_pattern
from .pca import PCA, fill_pca
from .polynomials import Cubic, Linear, fill_cubic, fill_linear
from .relational import Relational, fill_relational
from .rigid_body import RigidBody, fill_rigid_body
from .static import FromStatic, Placed, place_absent
from .static_shape import StaticShape
from .woltring import Quintic, fill_quintic

__all__ = [
    "PCA",
    "Cubic",
    "Cyclic",
    "Edges",
    "FromStatic",
    "Gap",
    "Linear",
    "LowRankKalman",
    "Motion",
    "Pattern",
    "Placed",
    "Prediction",
    "Quintic",
    "Relational",
    "RigidBody",
    "StaticShape",
    "Trimmed",
    "fill_cubic",
    "fill_cyclic",
    "fill_linear",
    "fill_low_rank_kalman",
    "fill_pattern",
    "fill_pca",
    "fill_quintic",
    "fill_relational",
    "fill_rigid_body",
    "find_gaps",
    "place_absent",
    "trim_edges",
]
