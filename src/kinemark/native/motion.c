/* The Kalman filter of many points, as point_motion.py. The points are along the last axis of every array. */

#include "native.h"
#include "symmetric3.h"

enum { W = 8 }; /* points that are worked on side by side, so that the compiler can use the wide registers */

/* x (9, n) and V (9, 9, n) a time T (n) later, by (1) and (2). */
API void predict(int64_t n, double q, const double *T, const double *x, const double *V, double *x_out, double *V_out)
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
static void update_some(int64_t n, int64_t t, int m, const double *x, const double *V, const double *N,
                        const double *g, double *x_out, double *V_out)
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

API void update(int64_t n, const double *x, const double *V, const double *N, const double *g, double *x_out,
                double *V_out)
{
    for (int64_t t = 0; t < n; t += W)
        update_some(n, t, (int)(n - t < W ? n - t : W), x, V, N, g, x_out, V_out);
}
