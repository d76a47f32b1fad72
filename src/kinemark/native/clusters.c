/* White pixels parted into clusters, as pixel_clusters.py. */

#include <math.h>

#include "native.h"

/* One turn for m pixels: k centres (k, 2) go to the means of the pixels nearest to them, and *spread is the sum of squares
   of what these were from them. Whether a centre has moved. work (k, 3): number and sums. */
static int turn(int64_t m, int64_t k, const double *x, const double *y, double *centres, double *work, double *spread)
{
    int moved = 0;
    *spread = 0;
    for (int64_t i = 0; i < 3 * k; i++)
        work[i] = 0;
    for (int64_t t = 0; t < m; t++) {
        double least = INFINITY, *sums = work;
        for (int64_t i = 0; i < k; i++) {
            double dx = x[t] - centres[2 * i], dy = y[t] - centres[2 * i + 1], far = dx * dx + dy * dy;
            if (far < least)
                least = far, sums = work + 3 * i;
        }
        *spread += least, sums[0] += 1, sums[1] += x[t], sums[2] += y[t];
    }
    for (int64_t i = 0; i < k; i++)
        for (int a = 0; a < 2 && work[3 * i] > 0; a++) {
            double mean = work[3 * i + 1 + a] / work[3 * i];
            moved |= mean != centres[2 * i + a];
            centres[2 * i + a] = mean;
        }
    return moved;
}

/* Lloyd's rule in n groups of N pixels (n, N) with k centres each, (n, k, 2), so many turns; spread (n) of the last.
   work (2 N + 3 k). */
API void cluster_pixels(int64_t n, int64_t N, int64_t k, int64_t turns, const double *x, const double *y,
                        const uint8_t *white, double *centres, double *spread, double *work)
{
    for (int64_t g = 0; g < n; g++) {
        int64_t m = 0;
        for (int64_t t = g * N; t < (g + 1) * N; t++)
            if (white[t])
                work[m] = x[t], work[N + m++] = y[t];
        int moved = k > 0;
        spread[g] = 0;
        for (int64_t i = 0; i < turns && moved; i++)
            moved = turn(m, k, work, work + N, centres + 2 * k * g, work + 2 * N, spread + g);
    }
}
