"""What is solved in many places, written once; knows of arrays only.

levenberg_marquardt   least squares, one problem or many at once
schur                 normal equations of which most unknowns appear in small blocks
scaled                inverses and solutions of matrices whose unknowns differ by many powers of ten in size
small_matrices        2 × 2 and 3 × 3 systems, very many at once
robust                weights for observations of which some are wrong
vectors               lengths, cross products and perpendiculars
row_quantiles         medians and quantiles of many rows with gaps
runs                  where a mask is true, or a value stays the same, without a break
"""
