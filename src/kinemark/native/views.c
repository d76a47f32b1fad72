/* Points in cameras, as point_projection.py, image_index.py and ray_intersection.py. The points are along the last axis of
   every array. */

#include "native.h"
#include "symmetric3.h"

/* ---- Projection ---- */

/* Where a camera P (3, 4) sees a point, NaN behind it, and how that changes with the point, px/mm. */
static void project_point(const double *P, const double xyz[3], double uv[2], double J[2][3])
{
    double h[3];
    for (int i = 0; i < 3; i++)
        h[i] = P[4 * i] * xyz[0] + P[4 * i + 1] * xyz[1] + P[4 * i + 2] * xyz[2] + P[4 * i + 3];
    double per = h[2] > 0 ? 1 / h[2] : NAN;
    for (int a = 0; a < 2; a++) {
        uv[a] = h[a] * per;
        for (int i = 0; i < 3; i++)
            J[a][i] = (P[4 * a + i] - uv[a] * P[8 + i]) * per;
    }
}

/* Where cameras P (C, 3, 4) see points (3, n) of covariance (3, 3, n): uv (C, 2, n), J (C, 2, 3, n), S (C, 3, n). */
API void project(int64_t C, int64_t n, const double *P, const double *xyz, const double *cov, double *uv, double *J,
                 double *S)
{
    for (int64_t c = 0; c < C; c++, P += 12, uv += 2 * n, J += 6 * n, S += 3 * n)
        for (int64_t t = 0; t < n; t++) {
            double at[2], D[2][3], DV[2][3], own[3] = {xyz[t], xyz[n + t], xyz[2 * n + t]};
            project_point(P, own, at, D);
            for (int a = 0; a < 2; a++) {
                uv[a * n + t] = at[a];
                for (int i = 0; i < 3; i++)
                    J[(3 * a + i) * n + t] = D[a][i];
                for (int j = 0; j < 3; j++)
                    DV[a][j] =
                        D[a][0] * cov[j * n + t] + D[a][1] * cov[(3 + j) * n + t] + D[a][2] * cov[(6 + j) * n + t];
            }
            S[t] = DV[0][0] * D[0][0] + DV[0][1] * D[0][1] + DV[0][2] * D[0][2]; /* (1) */
            S[n + t] = DV[0][0] * D[1][0] + DV[0][1] * D[1][1] + DV[0][2] * D[1][2];
            S[2 * n + t] = DV[1][0] * D[1][0] + DV[1][1] * D[1][1] + DV[1][2] * D[1][2];
        }
}

/* What images say of n points: N (3, 3, n) and g (3, n), both 0 before; detection (C, n), −1 for none, and variance
   (C, n); uv of all D. Returns 0 where an index is out of range, else 1. */
API int64_t information(int64_t C, int64_t n, int64_t d, const double *uv, const double *J, const int64_t *detection,
                        const double *variance, const double *images, double *N, double *g)
{
    for (int64_t c = 0; c < C; c++, uv += 2 * n, J += 6 * n, detection += n, variance += n)
        for (int64_t t = 0; t < n; t++) {
            int64_t r = detection[t];
            if (r < -1 || r >= d)
                return 0;
            if (r < 0)
                continue;
            for (int a = 0; a < 2; a++) {
                double off = images[2 * r + a] - uv[a * n + t], D[3];
                for (int i = 0; i < 3; i++)
                    D[i] = J[(3 * a + i) * n + t];
                for (int i = 0; i < 3; i++) {
                    double weighed = D[i] / variance[t];
                    g[i * n + t] += weighed * off;
                    for (int j = 0; j < 3; j++)
                        N[(3 * i + j) * n + t] += weighed * D[j];
                }
            }
        }
    return 1;
}

/* ---- Images near a place ---- */

/* The first of the places first … stop − 1 of `order`, by u, at which u is not less than `wanted`; stop if none is.
   What is no row of the D images counts as less. */
static int64_t place_of(const int32_t *order, const double *images, int64_t D, int64_t first, int64_t stop,
                        double wanted)
{
    while (first < stop) {
        int64_t middle = first + (stop - first) / 2, r = order[middle];
        if (r < 0 || r >= D || images[2 * r] < wanted)
            first = middle + 1;
        else
            stop = middle;
    }
    return first;
}

/* The images near places, n places in cells at uv (2, n), S (3, n), within reach (n) in u: those that are free and of
   which the squared distance (2) is less than `gate`.

   order (N), first (cells + 1): the index of the usable images.
   images (D, 2), variance (D), is_free (D): of all images.
   own, detection, squared (2), det |S|: of the first `room` that are found. Returns the number of all, or −1 where
      there is no such cell. */
API int64_t candidates(int64_t N, int64_t D, int64_t cells, const int32_t *order, const int64_t *first,
                       const double *images, const double *variance, const uint8_t *is_free, int64_t n,
                       const int64_t *cell, const double *uv, const double *S, const double *reach, double gate,
                       int64_t room, int64_t *own, int64_t *detection, double *squared, double *det)
{
    int64_t found = 0;
    for (int64_t i = 0; i < n; i++) {
        double u = uv[i], v = uv[n + i], far = reach[i];
        if (cell[i] < 0 || cell[i] >= cells)
            return -1;
        if (!(far > 0) || u != u)
            continue;
        int64_t from = first[cell[i]], stop = first[cell[i] + 1];
        if (from < 0 || stop > N)
            continue;
        for (int64_t k = place_of(order, images, D, from, stop, u - far); k < stop; k++) {
            int64_t r = order[k];
            if (r < 0 || r >= D)
                continue;
            double x = images[2 * r] - u, y = images[2 * r + 1] - v;
            if (x > far)
                break;
            if (!is_free[r])
                continue;
            double a = S[i] + variance[r], b = S[n + i], d = S[2 * n + i] + variance[r];
            double least = variance[r] * (a + d - variance[r]); /* |S + r I| ≥ r (tr S + r), whatever rounding left */
            double area = fmax(a * d - b * b, least), off = (d * x * x - 2 * b * x * y + a * y * y) / area; /* (2) */
            if (!(off < gate))
                continue;
            if (found < room) {
                own[found] = i;
                detection[found] = r;
                squared[found] = off;
                det[found] = area;
            }
            found++;
        }
    }
    return found;
}

/* ---- Intersection of rays ---- */

/* An image that is there: the camera P (3, 4) that saw it, its uv (2) and variance. */
typedef struct {
    const double *P, *uv;
    double variance;
} Image;

/* The image of a detection of a camera; P is 0 where there is none. */
static Image image_of(const double *P, const double *uv, const double *variance, int64_t camera, int64_t detection)
{
    Image none = {0, 0, 0};
    if (detection < 0)
        return none;
    Image own = {P + 12 * camera, uv + 2 * detection, variance[detection]};
    return own;
}

/* Add its two equations of the linear solution, (1) of geometry.triangulate, to A x = b. */
static void add_linear(Image image, double A[3][3], double b[3])
{
    for (int a = 0; a < 2; a++) {
        double line[4];
        for (int i = 0; i < 4; i++)
            line[i] = image.P[4 * a + i] - image.uv[a] * image.P[8 + i];
        for (int i = 0; i < 3; i++) {
            b[i] -= line[i] * line[3];
            for (int j = 0; j < 3; j++)
                A[i][j] += line[i] * line[j];
        }
    }
}

/* Add what it says near xyz to the information N and the pull g. */
static void add_seen(Image image, const double xyz[3], double N[3][3], double g[3])
{
    double uv[2], J[2][3];
    project_point(image.P, xyz, uv, J);
    for (int a = 0; a < 2; a++)
        for (int i = 0; i < 3; i++) {
            double weighed = J[a][i] / image.variance;
            g[i] += weighed * (image.uv[a] - uv[a]);
            for (int j = 0; j < 3; j++)
                N[i][j] += weighed * J[a][j];
        }
}

/* d²/s² where the point has gone on from xyz by `moved`, as if the projection were linear; infinite where unknown. */
static double squared_off(Image image, const double xyz[3], const double moved[3])
{
    double uv[2], J[2][3], sum = 0;
    project_point(image.P, xyz, uv, J);
    for (int a = 0; a < 2; a++) {
        double left = image.uv[a] - uv[a] - (J[a][0] * moved[0] + J[a][1] * moved[1] + J[a][2] * moved[2]);
        sum += left * left;
    }
    sum /= image.variance;
    return sum == sum ? sum : INFINITY;
}

/* Where the rays of n points with detections (k, n) meet: xyz (3, n), cov (3, 3, n) and squared (k, n), −1 unseen.
   Cameras P (C, 3, 4), `camera` (k, n) which of them; uv (D, 2) and variance of all images. Returns 0 where an index is
   out of range, else 1. */
API int64_t intersect(int64_t C, int64_t k, int64_t n, int64_t d, const double *P, const double *uv,
                      const double *variance, const int64_t *detection, const int64_t *camera, double *xyz, double *cov,
                      double *squared)
{
    for (int64_t i = 0; i < k * n; i++)
        if (detection[i] < -1 || detection[i] >= d || camera[i] < 0 || camera[i] >= C)
            return 0;
    for (int64_t t = 0; t < n; t++) {
        double A[3][3] = {{0}}, b[3] = {0}, N[3][3] = {{0}}, g[3] = {0}, at[3], V[3][3], moved[3];
        Image image;
        for (int64_t c = t; c < k * n; c += n)
            if ((image = image_of(P, uv, variance, camera[c], detection[c])).P)
                add_linear(image, A, b);
        solve(A, b, at);
        for (int64_t c = t; c < k * n; c += n)
            if ((image = image_of(P, uv, variance, camera[c], detection[c])).P)
                add_seen(image, at, N, g);
        inverse(N, V);
        for (int i = 0; i < 3; i++) {
            moved[i] = V[i][0] * g[0] + V[i][1] * g[1] + V[i][2] * g[2];
            xyz[i * n + t] = at[i] + moved[i];
            for (int j = 0; j < 3; j++)
                cov[(3 * i + j) * n + t] = V[i][j];
        }
        for (int64_t c = t; c < k * n; c += n) {
            image = image_of(P, uv, variance, camera[c], detection[c]);
            squared[c] = image.P ? squared_off(image, at, moved) : -1;
        }
    }
    return 1;
}
