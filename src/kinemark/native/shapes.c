/* Shapes fitted to the grey levels of patches, as shape_fits.py; their light is that of shape_images.py. */

#include <math.h>

#include "native.h"

enum { DISCS, ELLIPSE, MOTION, CUT };            /* kinds, as in shape_fits.py */
enum { MOST = 24, NODES = 7, NODES_CORNER = 6 }; /* parameters; nodes of the rules, as in shape_images.py */
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

typedef struct {
    const double *x, *y, *grey, *root; /* root of the weight */
    double white;
} Patch;

/* Where the fit stands, or would after a step. */
typedef struct {
    double p[MOST], chi2, H[MOST][MOST], g[MOST];
} State;

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

/* (2) of two outlines: Φ₂, and what φ(h) and φ(k), which are known, are multiplied by in its derivatives. */
static double both(const Fit *fit, double h, double k, double of_h, double of_k, double rho, double *by_h, double *by_k)
{
    double product = of_h * of_k, none;
    *by_h = of_k, *by_k = of_h;
    if (!(fabs(h) < CORNER && fabs(k) < CORNER))
        return product;
    rho = rho > MOST_CORRELATION ? MOST_CORRELATION : rho < -MOST_CORRELATION ? -MOST_CORRELATION : rho;
    double root = sqrt(1 - rho * rho), end = asin(rho), sum = 0;
    *by_h = normal(fit, (k - rho * h) / root, &none);
    *by_k = normal(fit, (h - rho * k) / root, &none);
    for (int i = 0; i < NODES_CORNER; i++) {
        double sine = sin(end * fit->corner[i]);
        sum += fit->corner_weight[i] * exp((h * k * sine - (h * h + k * k) / 2) / (1 - sine * sine));
    }
    return product + end / 6.283185307179586 * sum;
}

/* (4): U at a pixel, and its derivatives by the discs' x, y, r and by w, which are not set where U is 0. */
static inline double discs(const Fit *fit, int k, const double *p, double w, double x, double y, double *J)
{
    int a = 0, b = -1, near = 0; /* the two outlines that are nearest or deepest */
    double s[MOST / 3], gx[MOST / 3], gy[MOST / 3], square[MOST / 3];
    double f[2], slope[2], by[2] = {1, 1}, U, scale = 1 / w, reach = FAR * w;
    for (int i = 0; i < k; i++) {
        double dx = x - p[3 * i], dy = y - p[3 * i + 1], out = p[3 * i + 2] + reach;
        gx[i] = dx, gy[i] = dy, square[i] = dx * dx + dy * dy;
        near |= out > 0 && square[i] < out * out;
    }
    if (!near) /* what most pixels are, and no root is needed to see it */
        return square[0] != square[0] ? square[0] : 0;
    for (int i = 0; i < k; i++) {
        double far = sqrt(square[i]) + TINY, unit = 1 / far;
        s[i] = p[3 * i + 2] - far, gx[i] *= unit, gy[i] *= unit;
        J[3 * i] = J[3 * i + 1] = J[3 * i + 2] = 0;
        if (i > 0 && s[i] > s[a])
            b = a, a = i;
        else if (i > 0 && (b < 0 || s[i] > s[b]))
            b = i;
    }
    f[0] = normal(fit, s[a] * scale, &slope[0]);
    U = f[0];
    if (k > 1) { /* (3) */
        f[1] = normal(fit, s[b] * scale, &slope[1]);
        U = 1 - both(fit, -s[a] * scale, -s[b] * scale, 1 - f[0], 1 - f[1], gx[a] * gx[b] + gy[a] * gy[b], &by[0],
                     &by[1]);
    }
    J[3 * k] = 0;
    for (int j = 0; j < (k > 1 ? 2 : 1); j++) {
        int i = j ? b : a;
        double rise = slope[j] * by[j] * scale;
        J[3 * i] = rise * gx[i], J[3 * i + 1] = rise * gy[i], J[3 * i + 2] = rise;
        J[3 * k] -= rise * s[i] * scale;
    }
    return U;
}

/* (5) */
static inline double ellipse(const Fit *fit, const double *p, double w, double x, double y, double *J)
{
    double dx = x - p[0], dy = y - p[1], xx = p[2], xy = p[3], yy = p[4];
    double mx = xx * dx + xy * dy, my = xy * dx + yy * dy, q = sqrt(mx * mx + my * my) + TINY;
    double qx = (xx * mx + xy * my) / q, qy = (xy * mx + yy * my) / q, steepness = sqrt(qx * qx + qy * qy) + TINY;
    double z = (1 - q) / (steepness * w), bell, U = normal(fit, z, &bell), by_q = bell / w / steepness;
    J[0] = by_q * qx, J[1] = by_q * qy;
    by_q /= -q;
    J[2] = by_q * (mx * dx), J[3] = by_q * (mx * dy + my * dx), J[4] = by_q * (my * dy);
    J[5] = -z * (bell / w);
    return U;
}

/* (6) */
static inline double motion(const Fit *fit, const double *p, double w, double x, double y, double *J)
{
    double U = 0, part[4];
    for (int i = 0; i < 6; i++)
        J[i] = 0;
    for (int i = 0; i < NODES; i++) {
        double t = fit->t[i], share = fit->t_weight[i], moved[3] = {p[0] + t * p[3], p[1] + t * p[4], p[2]};
        double of = discs(fit, 1, moved, w, x, y, part);
        if (of == 0)
            continue;
        U += share * of;
        J[0] += share * part[0], J[1] += share * part[1], J[2] += share * part[2];
        J[3] += share * t * part[0], J[4] += share * t * part[1], J[5] += share * part[3];
    }
    return U;
}

/* (7), with c and s the cosine and sine of θ */
static inline double cut(const Fit *fit, const double *p, double w, double c, double s, double x, double y, double *J)
{
    double dx = x - p[0], dy = y - p[1], far = sqrt(dx * dx + dy * dy) + TINY, bell[2], by[2];
    double s1 = p[2] - far, s2 = p[4] - (x * c + y * s);
    double f1 = normal(fit, s1 / w, &bell[0]), f2 = normal(fit, s2 / w, &bell[1]);
    double U = both(fit, s1 / w, s2 / w, f1, f2, (dx * c + dy * s) / far, &by[0], &by[1]);
    double k1 = by[0] * bell[0] / w, k2 = by[1] * bell[1] / w;
    J[0] = k1 * dx / far, J[1] = k1 * dy / far, J[2] = k1;
    J[3] = k2 * (x * s - y * c), J[4] = k2, J[5] = -(k1 * s1 + k2 * s2) / w;
    return U;
}

/* Σ a b over n numbers, in four sums that the processor forms side by side. */
static inline double dot(int64_t n, const double *a, const double *b)
{
    double sum[4] = {0, 0, 0, 0};
    int64_t t = 0;
    for (; t + 4 <= n; t += 4)
        for (int i = 0; i < 4; i++)
            sum[i] += a[t + i] * b[t + i];
    for (; t < n; t++)
        sum[0] += a[t] * b[t];
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/* χ², the normal matrix and its right side at state->p; the model too. work (P + 1, N): weighted derivatives and rest
   of the pixels at an outline, the others count in four sums alone. */
static void evaluate(const Fit *fit, const Patch *patch, State *state, double *model, double *work)
{
    const int P = fit->P, A = P - 2, b = P - 1;
    const double *p = state->p, w = p[P - 3];
    const double c = fit->kind == CUT ? cos(p[3]) : 0, s = fit->kind == CUT ? sin(p[3]) : 0;
    double J[MOST], AA = 0, Ab = 0, bb = 0, gA = 0, gb = 0, chi2 = 0, *rest = work + P * fit->N;
    int64_t m = 0;
    for (int64_t t = 0; t < fit->N; t++) {
        double x = patch->x[t], y = patch->y[t], root = patch->root[t], U;
        if (fit->kind == DISCS)
            U = P == 6 ? discs(fit, 1, p, w, x, y, J) : P == 9 ? discs(fit, 2, p, w, x, y, J)
                                                               : discs(fit, P / 3 - 1, p, w, x, y, J);
        else if (fit->kind == ELLIPSE)
            U = ellipse(fit, p, w, x, y, J);
        else
            U = fit->kind == MOTION ? motion(fit, p, w, x, y, J) : cut(fit, p, w, c, s, x, y, J);
        double grey = p[b] + p[A] * U, off;
        if (!(grey < patch->white) && patch->white < INFINITY) { /* (8) */
            model[t] = grey != grey ? grey : patch->white;
            off = root * (patch->grey[t] - model[t]);
            chi2 += off * off;
            continue;
        }
        model[t] = grey;
        off = root * (patch->grey[t] - grey);
        chi2 += off * off;
        if (U == 0 || U == 1) { /* no outline is near */
            double rooted = root * root, bright = root * U;
            AA += rooted * U * U, Ab += rooted * U, bb += rooted, gA += bright * off, gb += root * off;
            continue;
        }
        for (int i = 0; i < A; i++)
            work[i * fit->N + m] = root * p[A] * J[i];
        work[A * fit->N + m] = root * U, work[b * fit->N + m] = root, rest[m] = off;
        m++;
    }
    for (int i = 0; i < P; i++) {
        for (int j = 0; j <= i; j++)
            state->H[i][j] = state->H[j][i] = dot(m, work + i * fit->N, work + j * fit->N);
        state->g[i] = dot(m, work + i * fit->N, rest);
    }
    state->H[A][A] += AA, state->H[b][b] += bb, state->H[A][b] = state->H[b][A] = state->H[A][b] + Ab;
    state->g[A] += gA, state->g[b] += gb, state->chi2 = chi2;
}

/* The step of Levenberg and Marquardt, by Cholesky's factors of the scaled normal matrix; 0 where there is none. */
static int step_of(const Fit *fit, const State *now, double damping, double *step)
{
    const int P = fit->P;
    double d[MOST], L[MOST][MOST];
    for (int i = 0; i < P; i++)
        d[i] = sqrt(now->H[i][i] > 1e-12 ? now->H[i][i] : 1e-12);
    for (int i = 0; i < P; i++) {
        double sum;
        for (int j = 0; j < i; j++) {
            sum = now->H[i][j] / (d[i] * d[j]);
            for (int k = 0; k < j; k++)
                sum -= L[i][k] * L[j][k];
            L[i][j] = sum / L[j][j];
        }
        sum = now->H[i][i] / (d[i] * d[i]) + damping + 1e-9;
        for (int k = 0; k < i; k++)
            sum -= L[i][k] * L[i][k];
        if (!(sum > 0 && sum < INFINITY))
            return 0;
        L[i][i] = sqrt(sum);
        step[i] = now->g[i] / d[i];
        for (int k = 0; k < i; k++)
            step[i] -= L[i][k] * step[k];
        step[i] /= L[i][i];
    }
    for (int i = P - 1; i >= 0; i--) {
        for (int k = i + 1; k < P; k++)
            step[i] -= L[k][i] * step[k];
        step[i] /= L[i][i];
    }
    for (int i = 0; i < P; i++) {
        step[i] /= d[i];
        step[i] = step[i] > 50 ? 50 : step[i] < -50 ? -50 : step[i];
    }
    return 1;
}

/* Whether the step was small, or brought little, or the fit is good enough. */
static int converged(const Fit *fit, const State *now, const State *tried, double used, double wanted, double enough)
{
    double moved = 0, mean = tried->chi2 / used;
    double small = tried->chi2 > wanted ? fit->hopeless * tried->chi2 : fit->small_gain * (mean > 1 ? mean : 1);
    for (int i = 0; i < fit->P - 2; i++) {
        double by = fabs(tried->p[i] - now->p[i]);
        moved = by > moved ? by : moved;
    }
    return moved < fit->small_step || now->chi2 - tried->chi2 < small || tried->chi2 < enough;
}

/* The fit of one patch, from state->p; the model is that of where it ends. work (P + 2, N). */
static void fit_one(const Fit *fit, const Patch *patch, int64_t steps, double used, double wanted, double enough,
                    State *now, double *model, double *work)
{
    const int P = fit->P;
    double damping = fit->damping, step[MOST], *other = work + (P + 1) * fit->N;
    evaluate(fit, patch, now, model, work);
    for (int64_t n = 0; n < steps; n++) {
        State tried;
        int better = 0;
        if (step_of(fit, now, damping, step)) {
            for (int i = 0; i < P; i++)
                tried.p[i] = now->p[i] + step[i];
            double *w = &tried.p[P - 3], *A = &tried.p[P - 2];
            *w = *w < fit->least_w ? fit->least_w : *w > fit->most_w ? fit->most_w : *w;
            *A = *A < 1 ? 1 : *A;
            evaluate(fit, patch, &tried, other, work);
            better = now->chi2 - tried.chi2 >= 0;
        }
        damping *= better ? fit->down : fit->up;
        int done = better && converged(fit, now, &tried, used, wanted, enough);
        if (better) {
            *now = tried;
            for (int64_t t = 0; t < fit->N; t++)
                model[t] = other[t];
        }
        if (done || damping > fit->most_damping)
            break;
    }
}

/* Shapes of one kind with P parameters in n patches of N pixels: parameters (n, P) are where each begins, and then
   where it ends, with χ² (n), the model (n, N) and the normal matrix (n, P, P). rules are the numbers of `Fit` from
   damping on; nodes and weights come in rows of NODES (2, 7) and NODES_CORNER (2, 6); work (P + 3, N).
   0 where there is no such kind with so many parameters. */
API int64_t fit_shapes(int64_t kind, int64_t n, int64_t N, int64_t P, int64_t steps, const double *rules,
                       const double *nodes, const double *nodes_corner, const double *x, const double *y,
                       const double *grey, const double *weight, const double *white, const double *wanted,
                       const double *enough, double *parameters, double *chi2, double *model, double *normals,
                       double *work)
{
    if (P > MOST || (kind == DISCS ? P < 6 || P % 3 : kind < ELLIPSE || kind > CUT || P != 8))
        return 0;
    Fit fit = {(int)kind, (int)P, N, rules[0], rules[1], rules[2], rules[3], rules[4], rules[5], rules[6], rules[7],
               rules[8], nodes, nodes + NODES, nodes_corner, nodes_corner + NODES_CORNER, {{0}}};
    fill_series(&fit);
    double *root = work + (P + 2) * N;
    for (int64_t k = 0; k < n; k++) {
        State state;
        Patch patch = {x + k * N, y + k * N, grey + k * N, root, white[k]};
        double used = 0;
        for (int64_t t = 0; t < N; t++) {
            double own = weight[k * N + t];
            root[t] = own < 0 ? 0 : sqrt(own);
            used += own > 0;
        }
        for (int64_t i = 0; i < P; i++)
            state.p[i] = parameters[k * P + i];
        fit_one(&fit, &patch, steps, used > 1 ? used : 1, wanted[k], enough[k], &state, model + k * N, work);
        chi2[k] = state.chi2;
        for (int64_t i = 0; i < P; i++) {
            parameters[k * P + i] = state.p[i];
            for (int64_t j = 0; j < P; j++)
                normals[(k * P + i) * P + j] = state.H[i][j];
        }
    }
    return 1;
}
