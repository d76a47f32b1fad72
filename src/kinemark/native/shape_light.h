/* The light of shapes and its derivatives, as shape_images.py: included by shapes.c alone. */

#ifndef KINEMARK_SHAPE_LIGHT_H
#define KINEMARK_SHAPE_LIGHT_H

#include <math.h>

#include "native.h"

enum { DISCS, ELLIPSE, MOTION, CUT };            /* kinds, as in shape_fits.py */
enum { MOST = 24, NODES = 7, NODES_CORNER = 6 }; /* parameters; nodes of the rules, as in shape_images.py */
enum { BLOCK = 64 };                             /* pixels that the processor works on side by side; chosen */
enum { PER_UNIT = 32, FAR = 6, ROWS = 2 * FAR * PER_UNIT + 1 }; /* of the table: rows to 1, and where it ends */

static const double TINY = 1e-9, CORNER = 3.5, MOST_CORRELATION = 0.999; /* as in shape_images.py */

/* What holds for a call. */
typedef struct {
    int kind, P; /* P parameters, of them the last three w, A and b */
    int64_t N;   /* pixels of a patch */
    double damping, down, up, most_damping, small_step, small_gain, hopeless, least_w, most_w;
    const double *t, *t_weight, *corner, *corner_weight; /* the rules' nodes and weights */
    double series[ROWS][6];                              /* of Φ and φ at steps of 1 / PER_UNIT from −FAR on */
} Fit;

/* U at the pixels of a block, and its derivatives by the shape's parameters and by w; in `evaluate` also by A and b. */
typedef struct {
    double U[BLOCK], J[MOST][BLOCK];
} Light;

/* Φ(z), and φ(z) to *bell, by Taylor's series about the nearest row. */
static inline double normal(const Fit *fit, double z, double *bell)
{
    if (!(fabs(z) < FAR)) {
        *bell = z != z ? z : 0;
        return z != z ? z : z > 0;
    }
    int row = (int)((z + FAR) * PER_UNIT + 0.5);
    double d = z - (row * (1.0 / PER_UNIT) - FAR);
    const double *c = fit->series[row];
    *bell = c[1] + d * (c[2] + d * (c[3] + d * (c[4] + d * c[5])));
    return c[0] + d * (c[1] + d * (c[2] * (1.0 / 2) + d * (c[3] * (1.0 / 3) + d * (c[4] * (1.0 / 4) + d * c[5] * (1.0 / 5)))));
}

/* The same at n distances s from outlines. */
static inline void normals(const Fit *fit, int64_t n, const double *s, double scale, double *U, double *bell)
{
    for (int64_t t = 0; t < n; t++)
        U[t] = normal(fit, s[t] * scale, &bell[t]);
}

/* The series: Φ, then those of φ, whose n-th derivative is (−1)ⁿ Heₙ φ with He of Hermite. */
static void fill_series(Fit *fit)
{
    for (int row = 0; row < ROWS; row++) {
        double a = row / (double)PER_UNIT - FAR, aa = a * a, bell = 0.3989422804014327 * exp(-aa / 2);
        double *c = fit->series[row];
        c[0] = erfc(-a * 0.7071067811865476) / 2;
        c[1] = bell, c[2] = -a * bell, c[3] = (aa - 1) / 2 * bell, c[4] = -a * (aa - 3) / 6 * bell;
        c[5] = ((aa - 6) * aa + 3) / 24 * bell;
    }
}

/* Sines of n angles within ± π/2, an angle times what is in a row, by their series to where nothing is left of it. */
static inline void sines(int n, double angle, const double *times, double *sine)
{
    for (int i = 0; i < n; i++) {
        double a = angle * times[i], aa = a * a, sum = 1;
        for (int k = 20; k > 0; k -= 2)
            sum = 1 - aa * (1.0 / (k * (k + 1))) * sum;
        sine[i] = a * sum;
    }
}

/* What (2) adds to the product of the two chances where both outlines are near, and what φ(h) and φ(k) are then
   multiplied by in its derivatives. */
static double corner(const Fit *fit, double h, double k, double rho, double *by_h, double *by_k)
{
    rho = rho > MOST_CORRELATION ? MOST_CORRELATION : rho < -MOST_CORRELATION ? -MOST_CORRELATION : rho;
    double root = sqrt(1 - rho * rho), end = asin(rho), sum = 0, none, sine[NODES_CORNER];
    *by_h = normal(fit, (k - rho * h) / root, &none);
    *by_k = normal(fit, (h - rho * k) / root, &none);
    sines(NODES_CORNER, end, fit->corner, sine);
    for (int i = 0; i < NODES_CORNER; i++)
        sum += fit->corner_weight[i] * exp((h * k * sine[i] - (h * h + k * k) / 2) / (1 - sine[i] * sine[i]));
    return end / 6.283185307179586 * sum;
}

/* A disc's signed distances s and the unit vectors towards n pixels. */
static inline void distances(const double *p, int64_t n, const double *x, const double *y, double *s, double *gx, double *gy)
{
    for (int64_t t = 0; t < n; t++) {
        double dx = x[t] - p[0], dy = y[t] - p[1], far = sqrt(dx * dx + dy * dy) + TINY, unit = 1 / far;
        s[t] = p[2] - far, gx[t] = dx * unit, gy[t] = dy * unit;
    }
}

/* The two outlines of k that are nearest to the pixel t or deepest there. */
static inline void nearest(int k, double (*s)[BLOCK], int64_t t, int *a, int *b)
{
    *a = s[1][t] > s[0][t], *b = !*a;
    for (int i = 2; i < k; i++)
        if (s[i][t] > s[*a][t])
            *b = *a, *a = i;
        else if (s[i][t] > s[*b][t])
            *b = i;
}

/* (4) */
CLONES static void discs(const Fit *fit, int k, const double *p, double w, int64_t n, const double *x, const double *y,
                         Light *light)
{
    double s[MOST / 3][BLOCK], gx[MOST / 3][BLOCK], gy[MOST / 3][BLOCK];
    double f[MOST / 3][BLOCK], bell[MOST / 3][BLOCK], scale = 1 / w;
    for (int i = 0; i < k; i++) {
        distances(p + 3 * i, n, x, y, s[i], gx[i], gy[i]);
        normals(fit, n, s[i], scale, f[i], bell[i]);
    }
    for (int64_t t = 0; k == 1 && t < n; t++)
        light->U[t] = f[0][t];
    for (int64_t t = 0; k > 1 && t < n; t++) { /* (3) */
        int a, b;
        nearest(k, s, t, &a, &b);
        double h = -s[a][t] * scale, l = -s[b][t] * scale, by_a = 1 - f[b][t], by_b = 1 - f[a][t], both = by_a * by_b;
        if (fabs(h) < CORNER && fabs(l) < CORNER)
            both += corner(fit, h, l, gx[a][t] * gx[b][t] + gy[a][t] * gy[b][t], &by_a, &by_b);
        light->U[t] = 1 - both;
        by_a *= bell[a][t], by_b *= bell[b][t];
        for (int i = 0; i < k; i++)
            bell[i][t] = 0;
        bell[a][t] = by_a, bell[b][t] = by_b;
    }
    for (int64_t t = 0; t < n; t++)
        light->J[3 * k][t] = 0;
    for (int i = 0; i < k; i++)
        for (int64_t t = 0; t < n; t++) {
            double rise = bell[i][t] * scale;
            light->J[3 * i][t] = rise * gx[i][t], light->J[3 * i + 1][t] = rise * gy[i][t];
            light->J[3 * i + 2][t] = rise, light->J[3 * k][t] -= rise * s[i][t] * scale;
        }
}

/* (5) */
CLONES static void ellipse(const Fit *fit, const double *p, double w, int64_t n, const double *x, const double *y,
                           Light *light)
{
    double s[BLOCK], bell[BLOCK], xx = p[2], xy = p[3], yy = p[4], scale = 1 / w;
    for (int64_t t = 0; t < n; t++) {
        double dx = x[t] - p[0], dy = y[t] - p[1], mx = xx * dx + xy * dy, my = xy * dx + yy * dy;
        double q = sqrt(mx * mx + my * my) + TINY, of_q = 1 / q;
        double qx = (xx * mx + xy * my) * of_q, qy = (xy * mx + yy * my) * of_q;
        double unit = 1 / (sqrt(qx * qx + qy * qy) + TINY);
        s[t] = (1 - q) * unit, unit *= scale;
        light->J[0][t] = unit * qx, light->J[1][t] = unit * qy, unit *= -of_q;
        light->J[2][t] = unit * (mx * dx), light->J[3][t] = unit * (mx * dy + my * dx);
        light->J[4][t] = unit * (my * dy), light->J[5][t] = -s[t] * scale * scale;
    }
    normals(fit, n, s, scale, light->U, bell);
    for (int i = 0; i < 6; i++)
        for (int64_t t = 0; t < n; t++)
            light->J[i][t] *= bell[t];
}

/* (6) */
CLONES static void motion(const Fit *fit, const double *p, double w, int64_t n, const double *x, const double *y,
                          Light *light)
{
    double s[BLOCK], gx[BLOCK], gy[BLOCK], f[BLOCK], bell[BLOCK], scale = 1 / w;
    for (int64_t t = 0; t < n; t++) {
        light->U[t] = 0;
        for (int i = 0; i < 6; i++)
            light->J[i][t] = 0;
    }
    for (int i = 0; i < NODES; i++) {
        double at = fit->t[i], share = fit->t_weight[i], moved[3] = {p[0] + at * p[3], p[1] + at * p[4], p[2]};
        distances(moved, n, x, y, s, gx, gy);
        normals(fit, n, s, scale, f, bell);
        for (int64_t t = 0; t < n; t++) {
            double rise = share * scale * bell[t], along = rise * gx[t], across = rise * gy[t];
            light->U[t] += share * f[t];
            light->J[0][t] += along, light->J[1][t] += across, light->J[2][t] += rise;
            light->J[3][t] += at * along, light->J[4][t] += at * across, light->J[5][t] -= rise * s[t] * scale;
        }
    }
}

/* (7) */
CLONES static void cut(const Fit *fit, const double *p, double w, int64_t n, const double *x, const double *y, Light *light)
{
    double s[2][BLOCK], gx[BLOCK], gy[BLOCK], f[2][BLOCK], bell[2][BLOCK];
    double scale = 1 / w, cosine = cos(p[3]), sine = sin(p[3]);
    distances(p, n, x, y, s[0], gx, gy);
    for (int64_t t = 0; t < n; t++)
        s[1][t] = p[4] - (x[t] * cosine + y[t] * sine);
    for (int i = 0; i < 2; i++)
        normals(fit, n, s[i], scale, f[i], bell[i]);
    for (int64_t t = 0; t < n; t++) {
        double h = s[0][t] * scale, k = s[1][t] * scale, by_h = f[1][t], by_k = f[0][t], U = by_h * by_k;
        if (fabs(h) < CORNER && fabs(k) < CORNER)
            U += corner(fit, h, k, gx[t] * cosine + gy[t] * sine, &by_h, &by_k);
        double of_h = by_h * bell[0][t] * scale, of_k = by_k * bell[1][t] * scale;
        light->U[t] = U;
        light->J[0][t] = of_h * gx[t], light->J[1][t] = of_h * gy[t], light->J[2][t] = of_h;
        light->J[3][t] = of_k * (x[t] * sine - y[t] * cosine), light->J[4][t] = of_k;
        light->J[5][t] = -(of_h * h + of_k * k);
    }
}

/* U at n pixels, and its derivatives by the shape's parameters and by w. */
static void light_of(const Fit *fit, const double *p, int64_t n, const double *x, const double *y, Light *light)
{
    double w = p[fit->P - 3];
    if (fit->kind == DISCS && fit->P == 9)
        discs(fit, 2, p, w, n, x, y, light);
    else if (fit->kind == DISCS)
        discs(fit, fit->P / 3 - 1, p, w, n, x, y, light);
    else if (fit->kind == ELLIPSE)
        ellipse(fit, p, w, n, x, y, light);
    else if (fit->kind == MOTION)
        motion(fit, p, w, n, x, y, light);
    else
        cut(fit, p, w, n, x, y, light);
}

#endif
