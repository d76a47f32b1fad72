/* Symmetric 3 × 3 matrices, as symmetric3.py. */

#ifndef KINEMARK_SYMMETRIC3_H
#define KINEMARK_SYMMETRIC3_H

#include <math.h>

/* The cofactors of A; returns its determinant. */
static inline double cofactors(double A[3][3], double out[3][3])
{
    double a = A[0][0], b = A[0][1], c = A[0][2], d = A[1][1], e = A[1][2], f = A[2][2];
    out[0][0] = d * f - e * e;
    out[1][1] = a * f - c * c;
    out[2][2] = a * d - b * b;
    out[0][1] = out[1][0] = c * e - b * f;
    out[0][2] = out[2][0] = b * e - c * d;
    out[1][2] = out[2][1] = b * c - a * e;
    return a * out[0][0] + b * out[0][1] + c * out[0][2];
}

/* The inverse of A; not finite where A is singular. */
static inline void inverse(double A[3][3], double out[3][3])
{
    double scale = 1 / cofactors(A, out);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            out[i][j] *= scale;
}

/* x of A x = b; NaN where A is singular. */
static inline void solve(double A[3][3], const double b[3], double x[3])
{
    double adjoint[3][3], det = cofactors(A, adjoint);
    if (!(fabs(det) > 1e-13 * (fabs(A[0][0] * A[1][1] * A[2][2]) + 1e-300)))
        det = NAN;
    for (int i = 0; i < 3; i++)
        x[i] = (adjoint[i][0] * b[0] + adjoint[i][1] * b[1] + adjoint[i][2] * b[2]) / det;
}

#endif
