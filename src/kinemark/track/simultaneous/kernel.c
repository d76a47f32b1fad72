/* The arithmetic of tracking: points in motion, where cameras should see them, and which images lie there.

   Plain C99 that knows nothing of Python: compiled.py loads it with ctypes. What is computed, and why, stands in
   motion.py, claims.py and groups.py, where NumPy does the same and which the tests hold against this file; the
   equations numbered here are theirs. Arrays lie as there, the points along the last axis.

   Whoever calls gives all memory, and its size. Rows of images beyond their number count as none. */

#include <math.h>
#include <stdint.h>

#ifdef _WIN32
#define API __declspec(dllexport)
void *PyInit__kernel(void) { return 0; } /* the linker of a Python extension asks for this name; nobody calls it */
#else
#define API __attribute__((visibility("default")))
#endif

enum { VERSION = 1 }; /* as in compiled.py; a library left over from another version is not used */

enum { W = 8 }; /* points that are worked on side by side, so that the compiler can use the wide registers */

API int64_t kernel_version(void) { return VERSION; }

/* ---- Symmetric 3 × 3 matrices ---- */

/* The cofactors of A; its determinant. */
static double cofactors(double A[3][3], double out[3][3])
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

/* As motion.inverse: not finite where A is singular. */
static void inverse(double A[3][3], double out[3][3])
{
    double scale = 1 / cofactors(A, out);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            out[i][j] *= scale;
}

/* As geometry.solve3: x of A x = b, NaN where A is singular. */
static void solve(double A[3][3], const double b[3], double x[3])
{
    double adjoint[3][3], det = cofactors(A, adjoint);
    if (!(fabs(det) > 1e-13 * (fabs(A[0][0] * A[1][1] * A[2][2]) + 1e-300)))
        det = NAN;
    for (int i = 0; i < 3; i++)
        x[i] = (adjoint[i][0] * b[0] + adjoint[i][1] * b[1] + adjoint[i][2] * b[2]) / det;
}

/* ---- motion.py ---- */

/* x (9, n) and V (9, 9, n) a time T (n) later, by (1) and (2). */
API void ahead(int64_t n, double q, const double *T, const double *x, const double *V, double *x_out, double *V_out)
{
    for (int i = 0; i < 3; i++)
        for (int64_t t = 0; t < n; t++) {
            double p = x[i * n + t], v = x[(3 + i) * n + t], a = x[(6 + i) * n + t];
            x_out[i * n + t] = p + T[t] * v + T[t] * T[t] / 2 * a;
            x_out[(3 + i) * n + t] = v + T[t] * a;
            x_out[(6 + i) * n + t] = a;
        }
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            const double *in[3][3];
            double *out[3][3], noise = i == j ? q * q : 0;
            for (int a = 0; a < 3; a++)
                for (int b = 0; b < 3; b++) {
                    int64_t at = ((3 * a + i) * 9 + 3 * b + j) * n;
                    in[a][b] = V + at;
                    out[a][b] = V_out + at;
                }
            for (int64_t t = 0; t < n; t++) {
                double h = T[t], hh = h * h, half[3][3];
                double G[3][3] = {{hh * hh * h / 20, hh * hh / 8, hh * h / 6}, {hh * hh / 8, hh * h / 3, hh / 2},
                                  {hh * h / 6, hh / 2, h}};
                for (int b = 0; b < 3; b++) {
                    double p = in[0][b][t], v = in[1][b][t], a = in[2][b][t];
                    half[0][b] = p + h * v + hh / 2 * a;
                    half[1][b] = v + h * a;
                    half[2][b] = a;
                }
                for (int a = 0; a < 3; a++) {
                    out[a][0][t] = half[a][0] + h * half[a][1] + hh / 2 * half[a][2] + noise * G[a][0];
                    out[a][1][t] = half[a][1] + h * half[a][2] + noise * G[a][1];
                    out[a][2][t] = half[a][2] + noise * G[a][2];
                }
            }
        }
}

/* (3): V₀⁻¹ P and R of one point. */
static void gain_of(double V0[3][3], double N[3][3], double gain[3][3], double R[3][3])
{
    double before[3][3], sum[3][3], P[3][3];
    inverse(V0, before);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            sum[i][j] = before[i][j] + N[i][j];
    inverse(sum, P);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            gain[i][k] = before[i][0] * P[0][k] + before[i][1] * P[1][k] + before[i][2] * P[2][k];
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            R[i][k] = before[i][k] -
                      (gain[i][0] * before[0][k] + gain[i][1] * before[1][k] + gain[i][2] * before[2][k]);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < i; k++)
            R[i][k] = R[k][i] = (R[i][k] + R[k][i]) / 2;
}

/* x (9, n) and V (9, 9, n) after measurements N (3, 3, n), g (3, n), by (3) and (4); m ≤ W of them from t on. */
static void told_some(int64_t n, int64_t t, int m, const double *x, const double *V, const double *N, const double *g,
                      double *x_out, double *V_out)
{
    double with_p[9][3][W] = {{{0}}}, R[3][3][W] = {{{0}}}, pull[3][W] = {{0}};
    for (int a = 0; a < 9; a++)
        for (int i = 0; i < 3; i++)
            for (int w = 0; w < m; w++)
                with_p[a][i][w] = V[(a * 9 + i) * n + t + w];
    for (int w = 0; w < m; w++) {
        double V0[3][3], own[3][3], gain[3][3], left[3][3];
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                V0[i][j] = with_p[i][j][w];
                own[i][j] = N[(i * 3 + j) * n + t + w];
            }
        gain_of(V0, own, gain, left);
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                R[i][j][w] = left[i][j];
                pull[i][w] += gain[i][j] * g[j * n + t + w];
            }
    }
    for (int a = 0; a < 9; a++) {
        double U[3][W] = {{0}}, moved[W] = {0};
        for (int i = 0; i < 3; i++)
            for (int w = 0; w < W; w++) {
                moved[w] += with_p[a][i][w] * pull[i][w];
                for (int j = 0; j < 3; j++)
                    U[j][w] += with_p[a][i][w] * R[i][j][w];
            }
        for (int w = 0; w < m; w++)
            x_out[a * n + t + w] = x[a * n + t + w] + moved[w];
        for (int b = 0; b < 9; b++) {
            double less[W];
            for (int w = 0; w < W; w++)
                less[w] = U[0][w] * with_p[b][0][w] + U[1][w] * with_p[b][1][w] + U[2][w] * with_p[b][2][w];
            for (int w = 0; w < m; w++)
                V_out[(a * 9 + b) * n + t + w] = V[(a * 9 + b) * n + t + w] - less[w];
        }
    }
}

API void told(int64_t n, const double *x, const double *V, const double *N, const double *g, double *x_out,
              double *V_out)
{
    for (int64_t t = 0; t < n; t += W)
        told_some(n, t, (int)(n - t < W ? n - t : W), x, V, N, g, x_out, V_out);
}

/* ---- claims.py ---- */

/* Where a camera P (3, 4) sees a point, NaN behind it, and how that changes with the point, px/mm. */
static void project(const double *P, const double xyz[3], double uv[2], double J[2][3])
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
API void expect(int64_t C, int64_t n, const double *P, const double *xyz, const double *cov, double *uv, double *J,
                double *S)
{
    for (int64_t c = 0; c < C; c++, P += 12, uv += 2 * n, J += 6 * n, S += 3 * n)
        for (int64_t t = 0; t < n; t++) {
            double at[2], D[2][3], DV[2][3], own[3] = {xyz[t], xyz[n + t], xyz[2 * n + t]};
            project(P, own, at, D);
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

/* The first of the places first … stop − 1 of rising keys at which one is not less than `wanted`; stop if none is. */
static int64_t place_of(const double *key, int64_t first, int64_t stop, double wanted)
{
    while (first < stop) {
        int64_t middle = first + (stop - first) / 2;
        if (key[middle] < wanted)
            first = middle + 1;
        else
            stop = middle;
    }
    return first;
}

/* The images of a recording: N usable ones by cell and u with their places, the first of each cell; of all D their uv
   (D, 2), variance and whether they are free; least u and width of all. */
typedef struct {
    int64_t n, d, cells;
    const double *key;
    const int64_t *order, *first;
    const double *uv, *variance;
    const uint8_t *free;
    double low, width;
} Images;

/* The free images of which the squared distance (2) of a place is less than `gate`: n places in cells, at uv (2, n), S
   (3, n), within reach (n) in u. own, row, squared (2), det |S| of the first `most`; returns the number of all. */
API int64_t candidates(const Images *images, int64_t n, const int64_t *cell, const double *uv, const double *S,
                       const double *reach, double gate, int64_t most, int64_t *own, int64_t *row, double *squared,
                       double *det)
{
    int64_t found = 0;
    for (int64_t i = 0; i < n; i++) {
        double u = uv[i], v = uv[n + i], far = reach[i];
        if (cell[i] < 0 || cell[i] >= images->cells || !(far > 0) || u != u)
            continue;
        int64_t from = images->first[cell[i]], stop = images->first[cell[i] + 1];
        if (from < 0 || stop > images->n)
            continue;
        double wanted = (double)cell[i] + (u - far - images->low) / images->width;
        for (int64_t k = place_of(images->key, from, stop, wanted); k < stop; k++) {
            int64_t r = images->order[k];
            if (r < 0 || r >= images->d)
                continue;
            double x = images->uv[2 * r] - u, y = images->uv[2 * r + 1] - v;
            if (x > far)
                break;
            if (!images->free[r])
                continue;
            double a = S[i] + images->variance[r], b = S[n + i], d = S[2 * n + i] + images->variance[r];
            double area = a * d - b * b, off = (d * x * x - 2 * b * x * y + a * y * y) / area; /* (2) */
            if (!(off < gate))
                continue;
            if (found < most) {
                own[found] = i;
                row[found] = r;
                squared[found] = off;
                det[found] = area;
            }
            found++;
        }
    }
    return found;
}

/* What claimed images say of n points: N (3, 3, n) and g (3, n), both 0 before; row, variance (C, n); uv of all D. */
API void information(int64_t C, int64_t n, int64_t d, const double *uv, const double *J, const int64_t *row,
                     const double *variance, const double *images, double *N, double *g)
{
    for (int64_t c = 0; c < C; c++, uv += 2 * n, J += 6 * n, row += n, variance += n)
        for (int64_t t = 0; t < n; t++) {
            int64_t r = row[t];
            if (r < 0 || r >= d)
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
}

/* ---- groups.py ---- */

/* An image that is there: the camera P (3, 4) that saw it, its uv (2) and variance. */
typedef struct {
    const double *P, *uv;
    double variance;
} Image;

/* The image of row `row` of a camera; P is 0 where there is none. */
static Image image_of(int64_t C, const double *P, int64_t d, const double *uv, const double *variance, int64_t camera,
                      int64_t row)
{
    Image none = {0, 0, 0};
    if (row < 0 || row >= d || camera < 0 || camera >= C)
        return none;
    Image own = {P + 12 * camera, uv + 2 * row, variance[row]};
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
    project(image.P, xyz, uv, J);
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
    project(image.P, xyz, uv, J);
    for (int a = 0; a < 2; a++) {
        double left = image.uv[a] - uv[a] - (J[a][0] * moved[0] + J[a][1] * moved[1] + J[a][2] * moved[2]);
        sum += left * left;
    }
    sum /= image.variance;
    return sum == sum ? sum : INFINITY;
}

/* Where n views (k, n) of images meet: xyz (3, n), cov (3, 3, n) and squared (k, n), −1 unseen. Cameras P (C, 3, 4),
   `camera` (k, n) which of them; uv (D, 2) and variance of all images. */
API void placed(int64_t C, int64_t k, int64_t n, int64_t d, const double *P, const double *uv, const double *variance,
                const int64_t *view, const int64_t *camera, double *xyz, double *cov, double *squared)
{
    for (int64_t t = 0; t < n; t++) {
        double A[3][3] = {{0}}, b[3] = {0}, N[3][3] = {{0}}, g[3] = {0}, at[3], V[3][3], moved[3];
        Image image;
        for (int64_t c = t; c < k * n; c += n)
            if ((image = image_of(C, P, d, uv, variance, camera[c], view[c])).P)
                add_linear(image, A, b);
        solve(A, b, at);
        for (int64_t c = t; c < k * n; c += n)
            if ((image = image_of(C, P, d, uv, variance, camera[c], view[c])).P)
                add_seen(image, at, N, g);
        inverse(N, V);
        for (int i = 0; i < 3; i++) {
            moved[i] = V[i][0] * g[0] + V[i][1] * g[1] + V[i][2] * g[2];
            xyz[i * n + t] = at[i] + moved[i];
            for (int j = 0; j < 3; j++)
                cov[(3 * i + j) * n + t] = V[i][j];
        }
        for (int64_t c = t; c < k * n; c += n) {
            image = image_of(C, P, d, uv, variance, camera[c], view[c]);
            squared[c] = image.P ? squared_off(image, at, moved) : -1;
        }
    }
}
