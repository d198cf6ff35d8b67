/* A rigid body of any tensor of inertia with deviation vectors of its motion, in 128-bit numbers, by Gragg's method with the
   extrapolation of Bulirsch and Stoer (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.9).

   I w' = L x w - weight x gamma + body + R^T space - D w,  L = I w + rotor,  gamma = R^T e3,  q' = q (0, w) / 2;
   I d' = (I d) x w + L x d - weight x (gamma x x) + (R^T space) x x - D d,  x' = d + x x w  of a deviation vector (d, x);
   A' = l,  B' = A / t  with l = ln |v| of the first. All vectors are along the axes of the tensor. */

#include <math.h>
#include <stddef.h>

typedef __float128 quad;

enum { COLUMNS = 13, MOST = 6, LARGEST = 9 + 6 * MOST };

typedef struct {
    quad inertia[3][3], inverse[3][3], weight[3], damping[3][3], rotor[3], body[3], space[3];
    double scale;    /* unit of the rates of a deviation vector; 0: l is not integrated */
    int of_attitude; /* whether x counts, or gamma x x */
    int count, size;
    quad log_start;
} Body;

static void cross(const quad *a, const quad *b, quad *c)
{
    for (int i = 0; i < 3; i++)
        c[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static void times(const quad m[3][3], const quad *v, quad *out)
{
    for (int i = 0; i < 3; i++)
        out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
}

/* Row a of R in the body: the direction a of space. The quaternion may have any length. */
static void direction(const quad *q, int a, quad *row)
{
    const quad v[3] = {q[1], q[2], q[3]};
    const quad square = q[0] * q[0] + v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    for (int k = 0; k < 3; k++)
        row[k] = 2 * v[a] * v[k];
    row[a] += 2 * q[0] * q[0] - square;
    row[(a + 1) % 3] -= 2 * q[0] * v[(a + 2) % 3];
    row[(a + 2) % 3] += 2 * q[0] * v[(a + 1) % 3];
    for (int k = 0; k < 3; k++)
        row[k] /= square;
}

static quad log_size(const Body *b, const quad *y, const quad *v)
{
    quad gamma[3], turn[3], square = 0;
    direction(y + 3, 2, gamma);
    cross(gamma, v + 3, turn);
    for (int k = 0; k < 3; k++) {
        const quad part = b->of_attitude ? v[3 + k] : turn[k];
        square += v[k] * v[k] / ((quad)b->scale * b->scale) + part * part;
    }
    return logl((long double)square) / 2;
}

static void slope(const Body *b, quad t, const quad *y, quad *f)
{
    const quad *w = y, *q = y + 3;
    quad L[3], gamma[3], row[3], pushed[3] = {0}, torque[3], part[3];
    times(b->inertia, w, L);
    for (int k = 0; k < 3; k++)
        L[k] += b->rotor[k];
    direction(q, 2, gamma);
    for (int a = 0; a < 3; a++) {
        direction(q, a, row);
        for (int k = 0; k < 3; k++)
            pushed[k] += row[k] * b->space[a];
    }
    cross(L, w, torque);
    cross(b->weight, gamma, part);
    for (int k = 0; k < 3; k++)
        torque[k] += b->body[k] + pushed[k] - part[k];
    times(b->damping, w, part);
    for (int k = 0; k < 3; k++)
        torque[k] -= part[k];
    times(b->inverse, torque, f);
    f[3] = -(q[1] * w[0] + q[2] * w[1] + q[3] * w[2]) / 2;
    cross(q + 1, w, part);
    for (int k = 0; k < 3; k++)
        f[4 + k] = (q[0] * w[k] + part[k]) / 2;
    for (int j = 0; j < b->count; j++) {
        const quad *d = y + 9 + 6 * j, *x = d + 3;
        quad *g = f + 9 + 6 * j, Id[3], turn[3];
        times(b->inertia, d, Id);
        cross(Id, w, torque);
        cross(L, d, part);
        for (int k = 0; k < 3; k++)
            torque[k] += part[k];
        cross(gamma, x, turn);
        cross(b->weight, turn, part);
        for (int k = 0; k < 3; k++)
            torque[k] -= part[k];
        cross(pushed, x, part);
        for (int k = 0; k < 3; k++)
            torque[k] += part[k];
        times(b->damping, d, part);
        for (int k = 0; k < 3; k++)
            torque[k] -= part[k];
        times(b->inverse, torque, g);
        cross(x, w, part);
        for (int k = 0; k < 3; k++)
            g[3 + k] = d[k] + part[k];
    }
    f[7] = f[8] = 0;
    if (b->count && b->scale > 0) {
        f[7] = log_size(b, y, y + 9) - b->log_start;
        f[8] = t > 0 ? y[7] / t : f[7];
    }
}

/* The largest error, relative to the rates, the quaternion, the time (of the integrals of logarithms in 64 bits) and
   each deviation vector. */
static long double distance(const Body *b, quad t, const quad *y, const quad *other)
{
    static const int ENDS[] = {0, 3, 7, 9};
    const long double of_integrals = 1e9L;
    long double worst = 0;
    for (int block = 0; block < 3 + b->count; block++) {
        const int from = block <= 3 ? ENDS[block] : 9 + 6 * (block - 3), to = block < 3 ? ENDS[block + 1] : from + 6;
        long double size = block == 2 ? of_integrals * fabsl((long double)t) : 0, off = 0;
        for (int i = from; i < to; i++) {
            const long double apart = fabsl((long double)(y[i] - other[i]));
            if (!isfinite(apart))
                return HUGE_VALL;
            size = fmaxl(size, fabsl((long double)y[i]));
            off = fmaxl(off, apart);
        }
        if (size > 0)
            worst = fmaxl(worst, off / size);
    }
    return worst;
}

/* One step of Gragg's method in so many parts, without the smoothing step. */
static void gragg(const Body *b, quad t, quad h, int parts, const quad *y, const quad *first, quad *end)
{
    quad before[LARGEST], now[LARGEST], f[LARGEST];
    const quad part = h / parts;
    for (int i = 0; i < b->size; i++) {
        before[i] = y[i];
        now[i] = y[i] + part * first[i];
    }
    for (int k = 1; k < parts; k++) {
        slope(b, t + k * part, now, f);
        for (int i = 0; i < b->size; i++) {
            const quad next = before[i] + 2 * part * f[i];
            before[i] = now[i];
            now[i] = next;
        }
    }
    for (int i = 0; i < b->size; i++)
        end[i] = now[i];
}

/* The state after a step, and the difference of the two best values of the tableau. */
static long double extrapolated(const Body *b, quad t, quad h, const quad *y, quad *end)
{
    static _Thread_local quad tableau[COLUMNS][LARGEST];
    quad first[LARGEST];
    slope(b, t, y, first);
    long double error = 0;
    for (int row = 0; row < COLUMNS; row++) {
        gragg(b, t, h, 2 * (row + 1), y, first, tableau[row]);
        for (int column = row - 1; column >= 0; column--) {
            const quad ratio = (quad)(row + 1) / (column + 1);
            for (int i = 0; i < b->size; i++)
                tableau[column][i] =
                    tableau[column + 1][i] + (tableau[column + 1][i] - tableau[column][i]) / (ratio * ratio - 1);
        }
        if (row == COLUMNS - 1)
            error = distance(b, t + h, tableau[0], tableau[1]);
    }
    for (int i = 0; i < b->size; i++)
        end[i] = tableau[0][i];
    return error;
}

static quad pair(const double *high, const double *low, int i)
{
    return (quad)high[i] + low[i];
}

/* States at times in order from a time on, or back; numbers are sums of two doubles. A record is w, q, A, B and the
   deviation vectors. Returns the number of steps, or -1 beyond the limit. */
long deviating(const double *inertia, const double *inverse, const double *inverse_low, const double *weight,
               const double *damping, const double *rotor, const double *body, const double *space, double scale,
               int of_attitude, int count, double begin, const double *start, const double *start_low,
               ptrdiff_t output, const double *at, double tolerance, long limit, double *high, double *low)
{
    Body b = {.scale = scale, .of_attitude = of_attitude, .count = count, .size = 9 + 6 * count};
    for (int i = 0; i < 3; i++) {
        b.weight[i] = weight[i], b.rotor[i] = rotor[i], b.body[i] = body[i], b.space[i] = space[i];
        for (int k = 0; k < 3; k++) {
            b.inertia[i][k] = inertia[3 * i + k], b.damping[i][k] = damping[3 * i + k];
            b.inverse[i][k] = pair(inverse, inverse_low, 3 * i + k);
        }
    }
    quad y[LARGEST], end[LARGEST], t = begin;
    for (int i = 0; i < b.size; i++)
        y[i] = pair(start, start_low, i);
    if (count && scale > 0)
        b.log_start = log_size(&b, y, y + 9);
    long double longest = 0;
    long steps = 0;
    for (ptrdiff_t done = 0; done < output; done++) {
        const quad target = at[done];
        while (t != target) {
            const long double left = (long double)(target - t);
            if (longest == 0)
                longest = fabsl(left);
            const int last = fabsl(left) <= longest;
            const quad h = last ? target - t : (quad)copysignl(longest, left);
            const long double error = extrapolated(&b, t, h, y, end);
            if (++steps > limit)
                return -1;
            const long double more = 0.9L * powl(tolerance / (error + 1e-40L), 1.0L / (2 * COLUMNS - 1));
            if (!(error <= tolerance)) {
                longest = fabsl((long double)h) * (more > 0.1L ? more : 0.1L);
                continue;
            }
            if (!last || more < 1)
                longest = fabsl((long double)h) * fminl(more, 3.0L);
            t = last ? target : t + h;
            for (int i = 0; i < b.size; i++)
                y[i] = end[i];
        }
        for (int i = 0; i < b.size; i++) {
            high[b.size * done + i] = y[i];
            low[b.size * done + i] = y[i] - high[b.size * done + i];
        }
    }
    return steps;
}
