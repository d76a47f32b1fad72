/* Shapes fitted to the grey levels of patches, as shape_fits.py; their light is that of shape_images.py. */

#include <math.h>
#include <string.h>

#include "native.h"
#include "shape_light.h"

/* The m pixels of a patch that have weight, root that of it. */
typedef struct {
    double *x, *y, *grey, *root, white;
    int64_t m;
} Patch;

/* Where the fit stands, or would after a step. */
typedef struct {
    double p[MOST], chi2, H[MOST][MOST], g[MOST];
} State;

/* The pixels with weight of N, in work (4, N). */
static Patch used(int64_t N, const double *x, const double *y, const double *grey, const double *weight, double white,
                  double *work)
{
    Patch patch = {work, work + N, work + 2 * N, work + 3 * N, white, 0};
    for (int64_t t = 0; t < N; t++)
        if (!(weight[t] <= 0)) {
            patch.x[patch.m] = x[t], patch.y[patch.m] = y[t], patch.grey[patch.m] = grey[t];
            patch.root[patch.m++] = sqrt(weight[t]);
        }
    return patch;
}

/* (8): a grey level as the sensor shows it. */
static inline double shown(double grey, double white)
{
    return grey < white || !(white < INFINITY) || grey != grey ? grey : white;
}

/* Σ a b over n numbers, in sums that the processor forms side by side. */
static inline double dot(int64_t n, const double *a, const double *b)
{
    double sum[8] = {0, 0, 0, 0, 0, 0, 0, 0};
    int64_t t = 0;
    for (; t + 8 <= n; t += 8)
        for (int i = 0; i < 8; i++)
            sum[i] += a[t + i] * b[t + i];
    for (; t < n; t++)
        sum[0] += a[t] * b[t];
    return ((sum[0] + sum[4]) + (sum[2] + sum[6])) + ((sum[1] + sum[5]) + (sum[3] + sum[7]));
}

/* What n pixels of a patch say from the one of this number on: the derivatives of their grey levels at p, and what the
   model leaves of these, both times the roots of the weights. */
static inline void rows_of(const Fit *fit, const Patch *patch, const double *p, int64_t first, int64_t n, Light *light,
                           double *rest)
{
    const int A = fit->P - 2, b = fit->P - 1;
    const double *grey = patch->grey + first, *root = patch->root + first;
    light_of(fit, p, n, patch->x + first, patch->y + first, light);
    for (int64_t t = 0; t < n; t++) {
        double all = p[b] + p[A] * light->U[t], seen = shown(all, patch->white);
        rest[t] = root[t] * (grey[t] - seen);
        light->J[b][t] = seen == all ? root[t] : 0; /* what is white says nothing */
    }
    for (int64_t t = 0; t < n; t++)
        light->J[A][t] = light->J[b][t] * light->U[t];
    for (int i = 0; i < A; i++)
        for (int64_t t = 0; t < n; t++)
            light->J[i][t] *= light->J[b][t] * p[A];
}

/* Add what n pixels say of P parameters to χ², the normal matrix below its diagonal, and its right side. */
static inline void add_rows(int P, int64_t n, const Light *light, const double *rest, State *state)
{
    for (int i = 0; i < P; i++) {
        for (int j = 0; j <= i; j++)
            state->H[i][j] += dot(n, light->J[i], light->J[j]);
        state->g[i] += dot(n, light->J[i], rest);
    }
    state->chi2 += dot(n, rest, rest);
}

/* χ², the normal matrix and its right side at state->p. */
CLONES static void evaluate(const Fit *fit, const Patch *patch, State *state)
{
    Light light;
    double rest[BLOCK];
    state->chi2 = 0;
    memset(state->H, 0, sizeof state->H), memset(state->g, 0, sizeof state->g);
    for (int64_t first = 0; first < patch->m; first += BLOCK) {
        const int64_t n = patch->m - first < BLOCK ? patch->m - first : BLOCK;
        rows_of(fit, patch, state->p, first, n, &light, rest);
        add_rows(fit->P, n, &light, rest, state);
    }
    for (int i = 0; i < fit->P; i++)
        for (int j = 0; j < i; j++)
            state->H[j][i] = state->H[i][j];
}

/* The grey levels (N) of all pixels of a patch. */
CLONES static void show(const Fit *fit, const double *p, const double *x, const double *y, double white, double *model)
{
    Light light;
    for (int64_t first = 0; first < fit->N; first += BLOCK) {
        const int64_t n = fit->N - first < BLOCK ? fit->N - first : BLOCK;
        light_of(fit, p, n, x + first, y + first, &light);
        for (int64_t t = 0; t < n; t++)
            model[first + t] = shown(p[fit->P - 1] + p[fit->P - 2] * light.U[t], white);
    }
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
static int converged(const Fit *fit, const State *now, const State *tried, double number, double wanted, double enough)
{
    double moved = 0, mean = tried->chi2 / number;
    double small = tried->chi2 > wanted ? fit->hopeless * tried->chi2 : fit->small_gain * (mean > 1 ? mean : 1);
    for (int i = 0; i < fit->P - 2; i++) {
        double by = fabs(tried->p[i] - now->p[i]);
        moved = by > moved ? by : moved;
    }
    return moved < fit->small_step || now->chi2 - tried->chi2 < small || tried->chi2 < enough;
}

/* The fit of one patch, from now->p. */
static void fit_one(const Fit *fit, const Patch *patch, int64_t steps, double wanted, double enough, State *now)
{
    const int P = fit->P;
    const double number = patch->m > 1 ? (double)patch->m : 1;
    double damping = fit->damping, step[MOST];
    evaluate(fit, patch, now);
    for (int64_t n = 0; n < steps; n++) {
        State tried;
        int better = 0;
        if (step_of(fit, now, damping, step)) {
            for (int i = 0; i < P; i++)
                tried.p[i] = now->p[i] + step[i];
            double *w = &tried.p[P - 3], *A = &tried.p[P - 2];
            *w = *w < fit->least_w ? fit->least_w : *w > fit->most_w ? fit->most_w : *w;
            *A = *A < 1 ? 1 : *A;
            evaluate(fit, patch, &tried);
            better = now->chi2 - tried.chi2 >= 0;
        }
        damping *= better ? fit->down : fit->up;
        int done = better && converged(fit, now, &tried, number, wanted, enough);
        if (better)
            *now = tried;
        if (done || damping > fit->most_damping)
            break;
    }
}

/* Whether there is such a kind with P parameters. */
static int is_shape(int64_t kind, int64_t P)
{
    return P <= MOST && (kind == DISCS ? P >= 6 && P % 3 == 0 : kind >= ELLIPSE && kind <= CUT && P == 8);
}

/* What holds for a call, of arguments as `fit_shapes` takes them. */
static Fit fit_of(int64_t kind, int64_t P, int64_t N, const double *rules, const double *nodes,
                  const double *nodes_corner)
{
    Fit fit = {(int)kind, (int)P, N, rules[0], rules[1], rules[2], rules[3], rules[4], rules[5], rules[6], rules[7],
               rules[8], nodes, nodes + NODES, nodes_corner, nodes_corner + NODES_CORNER, {{0}}};
    fill_series(&fit);
    return fit;
}

/* Shapes of one kind with P parameters in n patches of N pixels: parameters (n, P) are where each begins, and then
   where it ends, with χ² (n), the model (n, N) and the normal matrix (n, P, P). rules are the numbers of `Fit` from
   damping on; nodes and weights come in rows of NODES (2, 7) and NODES_CORNER (2, 6); work (4, N).
   0 where there is no such kind with so many parameters. */
API int64_t fit_shapes(int64_t kind, int64_t n, int64_t N, int64_t P, int64_t steps, const double *rules,
                       const double *nodes, const double *nodes_corner, const double *x, const double *y,
                       const double *grey, const double *weight, const double *white, const double *wanted,
                       const double *enough, double *parameters, double *chi2, double *model, double *normals,
                       double *work)
{
    if (!is_shape(kind, P))
        return 0;
    const Fit fit = fit_of(kind, P, N, rules, nodes, nodes_corner);
    for (int64_t k = 0; k < n; k++) {
        State state;
        const Patch patch = used(N, x + k * N, y + k * N, grey + k * N, weight + k * N, white[k], work);
        for (int64_t i = 0; i < P; i++)
            state.p[i] = parameters[k * P + i];
        fit_one(&fit, &patch, steps, wanted[k], enough[k], &state);
        show(&fit, state.p, x + k * N, y + k * N, white[k], model + k * N);
        chi2[k] = state.chi2;
        for (int64_t i = 0; i < P; i++) {
            parameters[k * P + i] = state.p[i];
            for (int64_t j = 0; j < P; j++)
                normals[(k * P + i) * P + j] = state.H[i][j];
        }
    }
    return 1;
}

/* ---- Light from a side, as side_light.py ---- */

/* What the pixels of a patch say at state->p of the P parameters and of a and b of (1), about the middle (2). */
CLONES static void evaluate_sides(const Fit *fit, const Patch *patch, const double *middle, State *state)
{
    const int P = fit->P;
    Light light;
    double rest[BLOCK];
    state->chi2 = 0;
    memset(state->H, 0, sizeof state->H), memset(state->g, 0, sizeof state->g);
    for (int64_t first = 0; first < patch->m; first += BLOCK) {
        const int64_t n = patch->m - first < BLOCK ? patch->m - first : BLOCK;
        const double *x = patch->x + first, *y = patch->y + first, *root = patch->root + first;
        rows_of(fit, patch, state->p, first, n, &light, rest);
        for (int64_t t = 0; t < n; t++) {
            double bright = root[t] * patch->grey[first + t] - rest[t] - root[t] * state->p[P - 1];
            light.J[P][t] = bright * (x[t] - middle[0]), light.J[P + 1][t] = bright * (y[t] - middle[1]);
        }
        add_rows(P + 2, n, &light, rest, state);
    }
}

/* Add to the model (N) at p what a step (P + 2) changes in it. */
CLONES static void add_step(const Fit *fit, const double *p, const double *step, const double *middle, const double *x,
                            const double *y, double white, double *model)
{
    const int P = fit->P;
    Light light;
    for (int64_t first = 0; first < fit->N; first += BLOCK) {
        const int64_t n = fit->N - first < BLOCK ? fit->N - first : BLOCK;
        light_of(fit, p, n, x + first, y + first, &light);
        for (int64_t t = 0; t < n; t++) {
            double all = p[P - 1] + p[P - 2] * light.U[t], seen = shown(all, white), change = step[P - 1];
            double side = step[P] * (x[first + t] - middle[0]) + step[P + 1] * (y[first + t] - middle[1]);
            for (int i = 0; i < P - 2; i++)
                change += step[i] * p[P - 2] * light.J[i][t];
            change += step[P - 2] * light.U[t];
            model[first + t] = seen + (seen == all ? change : 0) + side * (seen - p[P - 1]);
        }
    }
}

/* One linear step of shapes whose parameters (n, P) `fit_shapes` found, and of the sides from which they are lit:
   model (n, N), and χ² (n), which are those without it where it does not help. Other arguments as there.
   0 where there is no such kind with so many parameters. */
API int64_t light_sides(int64_t kind, int64_t n, int64_t N, int64_t P, const double *rules, const double *nodes,
                        const double *nodes_corner, const double *x, const double *y, const double *grey,
                        const double *weight, const double *white, const double *parameters, double *chi2,
                        double *model, double *work)
{
    if (!is_shape(kind, P) || P + 2 > MOST)
        return 0;
    const Fit fit = fit_of(kind, P, N, rules, nodes, nodes_corner);
    Fit wide = fit; /* of which the steps are */
    wide.P += 2;
    for (int64_t k = 0; k < n; k++, x += N, y += N, grey += N, weight += N, parameters += P, model += N) {
        State state;
        const Patch patch = used(N, x, y, grey, weight, white[k], work);
        double step[MOST], middle[2] = {0, 0}, left = 0;
        for (int64_t t = 0; t < patch.m; t++)
            middle[0] += patch.x[t] / (double)patch.m, middle[1] += patch.y[t] / (double)patch.m;
        memcpy(state.p, parameters, (size_t)P * sizeof *parameters);
        evaluate_sides(&fit, &patch, middle, &state);
        chi2[k] = state.chi2;
        if (step_of(&wide, &state, 0, step)) {
            add_step(&fit, state.p, step, middle, x, y, white[k], model);
            for (int64_t t = 0; t < N; t++)
                left += weight[t] <= 0 ? 0 : weight[t] * (grey[t] - model[t]) * (grey[t] - model[t]);
            if (left < state.chi2) {
                chi2[k] = left;
                continue;
            }
        }
        show(&fit, state.p, x, y, white[k], model);
    }
    return 1;
}
