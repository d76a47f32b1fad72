/* The part of pixels.c that reads pixels: included once for 8 and once for 16 bits, as PIXEL and OF_TYPE(name) say. */

/* ---- White runs ---- */

/* Written for compilers that turn a loop of fixed length into vector instructions. */
static inline PIXEL OF_TYPE(peak)(const PIXEL *p, int n)
{
    PIXEL m = 0;
    for (int i = 0; i < n; i++)
        m = p[i] > m ? p[i] : m;
    return m;
}

/* The first of the pixels x to size - 1 brighter than the threshold, or size. */
static int64_t OF_TYPE(next_white)(const PIXEL *image, int64_t x, int64_t size, int64_t threshold)
{
    while (x < size) {
        while (x + BIG <= size && OF_TYPE(peak)(image + x, BIG) <= threshold)
            x += BIG;
        while (x + SMALL <= size && OF_TYPE(peak)(image + x, SMALL) <= threshold)
            x += SMALL;
        for (int64_t end = least(x + SMALL, size); x < end; x++)
            if (image[x] > threshold)
                return x;
    }
    return size;
}

/* The runs of pixels brighter than the threshold in `lines` scan lines, at most `room` of them; returns their number.

   y, first, last: (room) line, first and last column. */
API int64_t OF_TYPE(find_runs)(const PIXEL *image, int64_t lines, int64_t width, int64_t threshold, int64_t room,
                               int64_t *y, int64_t *first, int64_t *last)
{
    int64_t n = 0, x = 0, size = lines * width;

    while (n < room && (x = OF_TYPE(next_white)(image, x, size, threshold)) < size) {
        int64_t line = x / width, begin = line * width, end = begin + width;
        y[n] = line;
        first[n] = x - begin;
        while (x < end && image[x] > threshold)
            x++;
        last[n++] = x - 1 - begin;
    }
    return n;
}

/* ---- Sums ---- */

/* Add the pixels left to right of a scan line to the sums of a group; x counts from column x0, y is that of the line. */
static void OF_TYPE(add_rim)(const PIXEL *row, int64_t left, int64_t right, int64_t x0, int64_t y, double *sum)
{
    int64_t grey = 0, grey_x = 0, grey_xx = 0;
    double dy = (double)y;
    PIXEL top = 0;

    for (int64_t x = left; x <= right; x++) {
        int64_t level = row[x], dx = x - x0;
        grey += level;
        grey_x += level * dx;
        grey_xx += level * dx * dx;
        top = row[x] > top ? row[x] : top;
    }
    int64_t a = left - x0, b = right - x0, one = b - a + 1, one_x = one * (a + b) / 2;
    int64_t one_xx = (b * (b + 1) * (2 * b + 1) - (a - 1) * a * (2 * a - 1)) / 6; /* (5) */
    sum[ONE] += (double)one;
    sum[ONE_X] += (double)one_x;
    sum[ONE_Y] += dy * (double)one;
    sum[ONE_XX] += (double)one_xx;
    sum[ONE_XY] += dy * (double)one_x;
    sum[ONE_YY] += dy * dy * (double)one;
    sum[GREY] += (double)grey;
    sum[GREY_X] += (double)grey_x;
    sum[GREY_Y] += dy * (double)grey;
    sum[GREY_XX] += (double)grey_xx;
    sum[GREY_XY] += dy * (double)grey_x;
    sum[GREY_YY] += dy * dy * (double)grey;
    sum[PEAK] = top > sum[PEAK] ? top : sum[PEAK];
}

/* Add the pixels left to right of a scan line, as far as they lie in it, to the background of a group. */
static void OF_TYPE(add_ring)(const PIXEL *row, int64_t left, int64_t right, int64_t width, double *sum)
{
    int64_t number = 0, grey = 0, squares = 0;

    right = least(right, width - 1);
    for (int64_t x = most(left, 0); x <= right; x++) {
        int64_t level = row[x];
        number++;
        grey += level;
        squares += level * level;
    }
    sum[RING] += (double)number;
    sum[RING_GREY] += (double)grey;
    sum[RING_SQUARES] += (double)squares;
}

/* Sums (SUMS) of the group with these runs in lines top to bottom, of a frame with lines begin to end.
   space: (2, end - begin + 1 + 4 MARGIN) working space. Returns 0 where the runs are none of this frame, else 1. */
static int OF_TYPE(sums_of_group)(const PIXEL *image, int64_t begin, int64_t end, int64_t width, int64_t n_runs,
                                  const int64_t *y, const int64_t *first, const int64_t *last, int64_t *space,
                                  double *sum)
{
    int64_t top = y[0], bottom = y[n_runs - 1], x0 = EMPTY;
    int64_t *left = space, *right = space + end - begin + 1 + 4 * MARGIN;

    if (top < begin || bottom < top || bottom > end
        || !reach(n_runs, y, first, last, top, bottom, width, left, right))
        return 0;
    for (int64_t r = 0; r < n_runs; r++)
        x0 = least(x0, first[r]);
    for (int64_t k = 0; k < SUMS; k++)
        sum[k] = 0;
    for (int64_t line = most(top - MARGIN, begin); line <= least(bottom + MARGIN, end); line++) {
        const PIXEL *row = image + line * width;
        int64_t i = line - top + 2 * MARGIN, low, high, rim_low, rim_high;
        widened(left, right, i, 1, &rim_low, &rim_high);
        widened(left, right, i, 2, &low, &high);
        if (rim_high < rim_low) { /* above and below the rim all is background */
            OF_TYPE(add_ring)(row, low, high, width, sum);
            continue;
        }
        OF_TYPE(add_ring)(row, low, rim_low - 1, width, sum);
        OF_TYPE(add_rim)(row, most(rim_low, 0), least(rim_high, width - 1), x0, line - top, sum);
        OF_TYPE(add_ring)(row, rim_high + 1, high, width, sum);
    }
    return 1;
}

/* Sums over the pixels of groups in frames of this height and width, `lines` scan lines in all, a multiple of height.

   start: (n_groups + 1) where each group's runs start among the n_runs of y, first, last, all of them, which are in scan
      order within a group.
   space: (2, height + 4 MARGIN) working space.
   out: (SUMS, n_groups).
   Returns n_groups, or the first group that is none of these frames. */
API int64_t OF_TYPE(sum_pixels)(const PIXEL *image, int64_t lines, int64_t height, int64_t width, int64_t n_groups,
                                int64_t n_runs, const int64_t *start, const int64_t *y, const int64_t *first,
                                const int64_t *last, int64_t *space, double *out)
{
    for (int64_t g = 0; g < n_groups; g++) {
        int64_t head = start[g], end = start[g + 1];
        double sum[SUMS];
        if (height < 1 || head < 0 || end <= head || end > n_runs || y[head] < 0 || y[head] >= lines)
            return g;
        if ((g == 0 && head > 0) || (g == n_groups - 1 && end < n_runs))
            return g;
        int64_t begin = y[head] / height * height;
        if (!OF_TYPE(sums_of_group)(image, begin, begin + height - 1, width, end - head, y + head, first + head,
                                    last + head, space, sum))
            return g;
        for (int64_t k = 0; k < SUMS; k++)
            out[k * n_groups + g] = sum[k];
    }
    return n_groups;
}

/* ---- Pixels of single groups ---- */

/* Whether a pixel of a frame with lines begin to end is beside a white one that is not marked OWN. `cell` is its place
   among the marks, whose lines are `wide` long. */
static int OF_TYPE(beside_others)(const PIXEL *image, int64_t x, int64_t y, int64_t begin, int64_t end, int64_t width,
                                  int64_t threshold, const uint8_t *cell, int64_t wide)
{
    for (int64_t dy = y > begin ? -1 : 0; dy <= (y < end ? 1 : 0); dy++)
        for (int64_t dx = x > 0 ? -1 : 0; dx <= (x < width - 1 ? 1 : 0); dx++)
            if (image[(y + dy) * width + x + dx] > threshold && !(cell[dy * wide + dx] & OWN))
                return 1;
    return 0;
}

/* The pixels of groups, and those within `margin` of them that are neither white pixels of other groups nor beside
   such; groups as for sum_pixels, and white what is brighter than the threshold.

   marks: (n_marks) for the greatest rectangle round a group, wider by margin + 1 on each side.
   ends: (n_groups + 1) where each group's pixels start among the `room` of column, line (in the frame), grey and own.
   Returns n_groups, or the first group that is none of these frames or finds no room. */
API int64_t OF_TYPE(cut_pixels)(const PIXEL *image, int64_t lines, int64_t height, int64_t width, int64_t n_groups,
                                int64_t n_runs, const int64_t *start, const int64_t *y, const int64_t *first,
                                const int64_t *last, int64_t threshold, int64_t margin, int64_t n_marks, int64_t room,
                                uint8_t *marks, int64_t *ends, int64_t *column, int64_t *line, double *grey,
                                uint8_t *own)
{
    int64_t n = 0, box[4];
    ends[0] = 0;
    for (int64_t g = 0; g < n_groups; g++) {
        int64_t begin = frame_of(g, lines, height, width, n_groups, n_runs, start, y, first, last, box);
        if (begin < 0)
            return g;
        int64_t end = begin + height - 1, left = box[0] - margin - 1, top = box[2] - margin - 1;
        int64_t wide = box[1] - left + margin + 2, high = box[3] - top + margin + 2;
        if (wide * high > n_marks || n + wide * high > room)
            return g;
        mark(start[g + 1] - start[g], y + start[g], first + start[g], last + start[g], left, top, wide, high, margin,
             marks);
        for (int64_t at = most(top + 1, begin); at <= least(top + high - 2, end); at++)
            for (int64_t x = most(left + 1, 0); x <= least(left + wide - 2, width - 1); x++) {
                const uint8_t *cell = marks + (at - top) * wide + x - left;
                if (!*cell || (!(*cell & OWN)
                               && OF_TYPE(beside_others)(image, x, at, begin, end, width, threshold, cell, wide)))
                    continue;
                column[n] = x, line[n] = at - begin, grey[n] = image[at * width + x], own[n] = *cell & OWN;
                n++;
            }
        ends[g + 1] = n;
    }
    return n_groups;
}

/* Over the white pixels of groups, as for sum_pixels: how many have the level `peak` (n_groups), how many are above
   `near` (n_groups), and of those with `peak` the sums of dx², dx dy and dy² from places u, v (n_groups) of the frame.

   out: (5, n_groups). Returns n_groups, or the first group that is none of these frames. */
API int64_t OF_TYPE(sum_peaks)(const PIXEL *image, int64_t lines, int64_t height, int64_t width, int64_t n_groups,
                               int64_t n_runs, const int64_t *start, const int64_t *y, const int64_t *first,
                               const int64_t *last, const double *peak, const double *near, const double *u,
                               const double *v, double *out)
{
    int64_t box[4];
    for (int64_t g = 0; g < n_groups; g++) {
        int64_t begin = frame_of(g, lines, height, width, n_groups, n_runs, start, y, first, last, box);
        double sum[5] = {0, 0, 0, 0, 0};
        if (begin < 0)
            return g;
        for (int64_t r = start[g]; r < start[g + 1]; r++) {
            double dy = (double)(y[r] - begin) - v[g];
            for (int64_t x = first[r]; x <= last[r]; x++) {
                double level = image[y[r] * width + x], dx = (double)x - u[g];
                sum[1] += level > near[g];
                if (level == peak[g])
                    sum[0] += 1, sum[2] += dx * dx, sum[3] += dx * dy, sum[4] += dy * dy;
            }
        }
        for (int64_t k = 0; k < 5; k++)
            out[k * n_groups + g] = sum[k];
    }
    return n_groups;
}

/* The brightest white pixel of groups, as for sum_pixels.

   out: (n_groups). Returns n_groups, or the first group that is none of these frames. */
API int64_t OF_TYPE(peaks)(const PIXEL *image, int64_t lines, int64_t height, int64_t width, int64_t n_groups,
                           int64_t n_runs, const int64_t *start, const int64_t *y, const int64_t *first,
                           const int64_t *last, double *out)
{
    int64_t box[4];
    for (int64_t g = 0; g < n_groups; g++) {
        PIXEL peak = 0;
        if (frame_of(g, lines, height, width, n_groups, n_runs, start, y, first, last, box) < 0)
            return g;
        for (int64_t r = start[g]; r < start[g + 1]; r++)
            for (int64_t x = first[r]; x <= last[r]; x++)
                peak = image[y[r] * width + x] > peak ? image[y[r] * width + x] : peak;
        out[g] = peak;
    }
    return n_groups;
}
