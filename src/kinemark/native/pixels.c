/* The pixels of marker detection, at the speed of memory: white runs, the groups they form, and sums over the groups, as
   pixel_runs.py, run_groups.py, pixel_sums.py, and group_pixels.py. */

#include "native.h"

enum {
    BIG = 256,  /* pixels whose maximum is taken at once, */
    SMALL = 32, /* and then where one of them is white */
    MARGIN = 2  /* one pixel for the rim of a group, one for its background */
};
#define EMPTY ((int64_t)1 << 40) /* beyond every line and column */

/* Rows of `out` of sum_pixels_8 and sum_pixels_16, as in pixel_sums.py. */
enum {
    ONE, ONE_X, ONE_Y, ONE_XX, ONE_XY, ONE_YY,
    GREY, GREY_X, GREY_Y, GREY_XX, GREY_XY, GREY_YY,
    PEAK, RING, RING_GREY, RING_SQUARES,
    SUMS
};

static inline int64_t least(int64_t a, int64_t b) { return a < b ? a : b; }
static inline int64_t most(int64_t a, int64_t b) { return a > b ? a : b; }

/* ---- Groups: the components of the graph of touching runs, by union and find. ---- */

/* The root of i; the way to it is halved. A parent is never greater than its child, so a root is a group's first run. */
static int64_t root(int64_t *parent, int64_t i)
{
    while (parent[i] != i) {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    return i;
}

static void unite(int64_t *parent, int64_t i, int64_t j)
{
    i = root(parent, i);
    j = root(parent, j);
    parent[most(i, j)] = least(i, j);
}

/* Unite each of n runs with those of the line before that it touches; `low` is the first that a later one may touch. */
static void touch(int64_t n, const int64_t *y, const int64_t *first, const int64_t *last, int64_t height,
                  int64_t *parent)
{
    for (int64_t i = 0, low = 0; i < n; i++) {
        parent[i] = i;
        while (low < i && (y[low] < y[i] - 1 || (y[low] == y[i] - 1 && last[low] < first[i] - 1)))
            low++;
        if (y[i] % height == 0) /* no group reaches from one frame into the next */
            continue;
        for (int64_t j = low; j < i && y[j] == y[i] - 1 && first[j] <= last[i] + 1; j++)
            unite(parent, i, j);
    }
}

/* The first of n runs that is none of an image of this width, or does not come after the run before it; n if none. */
static int64_t first_wrong(int64_t n, const int64_t *y, const int64_t *first, const int64_t *last, int64_t width)
{
    for (int64_t i = 0; i < n; i++) {
        if (y[i] < 0 || y[i] >= EMPTY || first[i] < 0 || last[i] < first[i] || last[i] >= width)
            return i;
        if (i && (y[i] < y[i - 1] || (y[i] == y[i - 1] && first[i] <= last[i - 1])))
            return i;
    }
    return n;
}

/* Runs (n) in scan order, of frames of this height and width, as groups in the order of their first runs. Returns their
   number G, or −1 − i where i is the first run that is out of order or none of these frames.

   label: (n) working space.
   sorted: (3, n) y, first, last of the runs by group.
   start: (n + 1), of which G + 1 are set: the rows of `sorted` where each group starts.
   box: (6, n), of which G columns are set: frame, area, left, right, top, bottom of each group. */
API int64_t group_runs(int64_t n, const int64_t *y, const int64_t *first, const int64_t *last, int64_t height,
                       int64_t width, int64_t *label, int64_t *sorted, int64_t *start, int64_t *box)
{
    int64_t *frame = box, *area = box + n, *left = box + 2 * n, *right = box + 3 * n;
    int64_t *top = box + 4 * n, *bottom = box + 5 * n;
    int64_t count = 0, wrong = first_wrong(n, y, first, last, width);

    if (height < 1 || wrong < n)
        return -1 - wrong;
    touch(n, y, first, last, height, label);
    start[0] = 0;
    for (int64_t i = 0; i < n; i++) {
        if (label[i] == i) {
            label[i] = count++;
            start[count] = 0;
        } else
            label[i] = label[label[i]]; /* the parent came before and has its number */
        start[label[i] + 1]++;
    }
    for (int64_t g = 0; g < count; g++)
        start[g + 1] += start[g];
    for (int64_t i = 0; i < n; i++) {
        int64_t g = label[i], at = start[g]++; /* for now start[g] is the next free row of g */
        sorted[at] = y[i];
        sorted[n + at] = first[i];
        sorted[2 * n + at] = last[i];
    }
    for (int64_t g = count; g > 0; g--)
        start[g] = start[g - 1];
    start[0] = 0;
    for (int64_t g = 0; g < count; g++) {
        int64_t head = start[g], end = start[g + 1];
        top[g] = sorted[head];
        bottom[g] = sorted[end - 1];
        frame[g] = top[g] / height;
        area[g] = 0;
        left[g] = EMPTY;
        right[g] = -EMPTY;
        for (int64_t r = head; r < end; r++) {
            left[g] = least(left[g], sorted[n + r]);
            right[g] = most(right[g], sorted[2 * n + r]);
            area[g] += sorted[2 * n + r] - sorted[n + r] + 1;
        }
    }
    return count;
}

/* ---- The reach of a group along each scan line, for sum_pixels_8 and sum_pixels_16. ---- */

/* Fill left and right (height + 4 MARGIN) with the reach of `n` runs from line `top` - 2 MARGIN to `bottom` + 2 MARGIN,
   empty where there is none. Returns 0 where a run lies outside of these lines or of columns 0 to width - 1, or does not
   come after the run before it, else 1. */
static int reach(int64_t n, const int64_t *y, const int64_t *first, const int64_t *last, int64_t top, int64_t bottom,
                 int64_t width, int64_t *left, int64_t *right)
{
    for (int64_t i = 0; i < bottom - top + 1 + 4 * MARGIN; i++) {
        left[i] = EMPTY;
        right[i] = -EMPTY;
    }
    for (int64_t r = 0; r < n; r++) {
        if (y[r] < top || y[r] > bottom || first[r] < 0 || last[r] < first[r] || last[r] >= width)
            return 0;
        if (r && (y[r] < y[r - 1] || (y[r] == y[r - 1] && first[r] <= last[r - 1])))
            return 0;
        int64_t i = y[r] - top + 2 * MARGIN;
        left[i] = least(left[i], first[r]);
        right[i] = most(right[i], last[r]);
    }
    return 1;
}

/* The reach in line i of what is widened by `by` pixels all round: that of the lines around, and `by` more. (6) */
static void widened(const int64_t *left, const int64_t *right, int64_t i, int64_t by, int64_t *low, int64_t *high)
{
    *low = EMPTY;
    *high = -EMPTY;
    for (int64_t k = i - by; k <= i + by; k++) {
        *low = least(*low, left[k]);
        *high = most(*high, right[k]);
    }
    *low -= by;
    *high += by;
}

/* ---- Single groups, for cut_pixels, sum_peaks and peaks. ---- */

enum { OWN = 1, CLOSE = 2 }; /* marks of pixels: a group's own, and those within the margin */

/* The first line of the frame in which group g lies, or −1 where its runs are none of a frame; and its box: left, right,
   top, bottom. The arguments are those of sum_pixels. */
static int64_t frame_of(int64_t g, int64_t lines, int64_t height, int64_t width, int64_t n_groups, int64_t n_runs,
                        const int64_t *start, const int64_t *y, const int64_t *first, const int64_t *last, int64_t *box)
{
    int64_t head = start[g], end = start[g + 1];
    if (height < 1 || head < 0 || end <= head || end > n_runs || y[head] < 0 || y[head] >= lines
        || (g == 0 && head > 0) || (g == n_groups - 1 && end < n_runs)
        || first_wrong(end - head, y + head, first + head, last + head, width) < end - head
        || y[end - 1] / height != y[head] / height)
        return -1;
    box[0] = EMPTY, box[1] = -EMPTY, box[2] = y[head], box[3] = y[end - 1];
    for (int64_t r = head; r < end; r++) {
        box[0] = least(box[0], first[r]);
        box[1] = most(box[1], last[r]);
    }
    return y[head] / height * height;
}

/* Mark n runs, and what is within the margin of them, in a rectangle of wide × high pixels from left and top on. */
static void mark(int64_t n, const int64_t *y, const int64_t *first, const int64_t *last, int64_t left, int64_t top,
                 int64_t wide, int64_t high, int64_t margin, uint8_t *marks)
{
    for (int64_t i = 0; i < wide * high; i++)
        marks[i] = 0;
    for (int64_t r = 0; r < n; r++) {
        uint8_t *row = marks + (y[r] - top) * wide;
        for (int64_t k = -margin; k <= margin; k++)
            for (int64_t x = first[r] - margin - left; x <= last[r] + margin - left; x++)
                row[k * wide + x] |= CLOSE;
        for (int64_t x = first[r] - left; x <= last[r] - left; x++)
            row[x] |= OWN;
    }
}

/* ---- What reads pixels, once for each type. ---- */

#define PIXEL uint8_t
#define OF_TYPE(name) name##_8
#include "pixels_by_depth.h"
#undef PIXEL
#undef OF_TYPE
#define PIXEL uint16_t
#define OF_TYPE(name) name##_16
#include "pixels_by_depth.h"
