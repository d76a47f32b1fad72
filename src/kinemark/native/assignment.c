/* Assignments of the least sum of costs, as assignment.py. */

#include <math.h>

#include "native.h"

/* What one problem of n rows and m columns works with; n is not above m. */
typedef struct {
    int64_t n, m;
    const double *cost;
    double *u, *v, *far;                               /* prices of rows (n) and columns (m); shortest ways to columns (m) */
    int64_t *column, *row, *from, *open, *seen, *done; /* of each row; of each column; on the way; columns left; SR; SC */
} Problem;

static Problem problem_of(int64_t n, int64_t m, const double *cost, double *real, int64_t *whole)
{
    Problem p = {n, m, cost, real, real + n, real + n + m, whole, whole + n, whole + n + m, whole + n + 2 * m,
                 whole + n + 3 * m, whole + 2 * n + 3 * m};
    for (int64_t i = 0; i < n; i++)
        p.u[i] = 0, p.column[i] = -1;
    for (int64_t j = 0; j < m; j++)
        p.v[j] = 0, p.row[j] = -1, p.from[j] = -1;
    return p;
}

/* The free column that is nearest to the row, by Dijkstra's rule in reduced costs; -1 where none is to be reached. */
static int64_t nearest_free(Problem *p, int64_t i, double *least)
{
    int64_t left = p->m;
    for (int64_t j = 0; j < p->m; j++)
        p->open[j] = p->m - j - 1, p->far[j] = INFINITY, p->done[j] = 0; /* backwards: equal costs give the diagonal */
    for (int64_t k = 0; k < p->n; k++)
        p->seen[k] = 0;
    *least = 0;
    while (1) {
        int64_t at = -1;
        double low = INFINITY;
        p->seen[i] = 1;
        for (int64_t k = 0; k < left; k++) {
            int64_t j = p->open[k];
            double r = *least + p->cost[i * p->m + j] - p->u[i] - p->v[j];
            if (r < p->far[j])
                p->from[j] = i, p->far[j] = r;
            if (p->far[j] < low || (p->far[j] == low && p->row[j] < 0)) /* of equal ones a free column */
                low = p->far[j], at = k;
        }
        if (!(low < INFINITY) || at < 0)
            return -1;
        *least = low;
        int64_t j = p->open[at];
        p->done[j] = 1;
        if (p->row[j] < 0)
            return j;
        i = p->row[j];
        p->open[at] = p->open[--left];
    }
}

/* The columns of all rows; 0 where there are none for all of them. */
static int solved(Problem *p)
{
    for (int64_t now = 0; now < p->n; now++) {
        double least;
        int64_t j = nearest_free(p, now, &least), i;
        if (j < 0)
            return 0;
        p->u[now] += least;
        for (i = 0; i < p->n; i++)
            if (p->seen[i] && i != now)
                p->u[i] += least - p->far[p->column[i]];
        for (int64_t k = 0; k < p->m; k++)
            if (p->done[k])
                p->v[k] -= least - p->far[k];
        do {
            int64_t before;
            i = p->from[j], before = p->column[i];
            p->row[j] = i, p->column[i] = j, j = before;
        } while (i != now);
    }
    return 1;
}

/* The column of each of n rows, not more than the m columns, at the least sum of cost (n, m).
   real (n + 2 m), whole (2 n + 4 m), of which the first n are the columns. 0 where there is no such assignment. */
API int64_t assign(int64_t n, int64_t m, const double *cost, double *real, int64_t *whole)
{
    Problem p = problem_of(n, m, cost, real, whole);
    return n <= m && solved(&p);
}

/* Where `name` is among the n names, to which it is added if it is new. */
static int64_t place_of(int64_t name, int64_t *names, int64_t *n)
{
    for (int64_t k = *n; k-- > 0;) /* the last is the likely one */
        if (names[k] == name)
            return k;
    names[*n] = name;
    return (*n)++;
}

/* The pairs of a and b with the greatest sum of scores, no a and no b twice, in each of n groups by itself.

   start: (n + 1) where each group starts among the pairs; most: pairs of the largest group.
   space: (room) the table of a group; real (3 most), whole (10 most); chosen: (pairs), 0 or 1.
   Returns the room that is needed, more than `room` where it was not enough, and -1 where groups are wrong. */
API int64_t assign_pairs(int64_t n, int64_t pairs, int64_t most, int64_t room, const int64_t *start, const int64_t *a,
                         const int64_t *b, const double *score, double *space, double *real, int64_t *whole,
                         uint8_t *chosen)
{
    for (int64_t g = 0; g < n; g++) {
        int64_t head = start[g], size = start[g + 1] - head, counts[2] = {0, 0};
        int64_t *names[2] = {whole, whole + most}, *at[2] = {whole + 2 * most, whole + 3 * most};
        if (head < 0 || size < 0 || size > most || head + size > pairs)
            return -1;
        for (int64_t k = 0; k < size; k++)
            at[0][k] = place_of(a[head + k], names[0], &counts[0]), at[1][k] = place_of(b[head + k], names[1], &counts[1]);
        int wide = counts[0] <= counts[1]; /* rows are the fewer ones */
        int64_t rows = counts[!wide], columns = counts[wide];
        if (rows * columns > room)
            return rows * columns;
        for (int64_t k = 0; k < rows * columns; k++)
            space[k] = 0;
        for (int64_t k = 0; k < size; k++)
            space[at[!wide][k] * columns + at[wide][k]] = -score[head + k];
        Problem p = problem_of(rows, columns, space, real, whole + 4 * most);
        int good = solved(&p);
        for (int64_t k = size; k-- > 0;) { /* the last of pairs that are twice, as its score is the one in the table */
            int64_t *column = p.column + at[!wide][k];
            if ((chosen[head + k] = good && *column == at[wide][k]))
                *column = -1;
        }
    }
    return 0;
}
