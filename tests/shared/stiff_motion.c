/* The motion of a strongly damped body by collocation: Radau IIA of seven stages, in 80-bit numbers.

   I w' = L x w - weight x gamma + body + R^T space - D w,  gamma = R^T e3,  L = I w,  q' = q (0, w) / 2.
   The torques body and space are constant, or linear between the times of a table. */

#include <math.h>
#include <stddef.h>

typedef long double real;

enum { STAGES = 7, STATE = 7, ALL = STAGES * STATE, RECORD = 11, NEWTONS = 30 };

typedef struct {
    const double *moments, *weight, *damping;
    ptrdiff_t knots;
    const double *times, *body, *space;
} Scene;

static void at(const Scene *s, const double *values, ptrdiff_t k, real t, real *now)
{
    for (int i = 0; i < 3; i++) {
        now[i] = values[3 * k + i];
        if (s->knots && s->times[k + 1] > s->times[k])
            now[i] += (values[3 * k + 3 + i] - now[i]) * ((t - s->times[k]) / ((real)s->times[k + 1] - s->times[k]));
    }
}

static void matrix(const real *q, real r[3][3])
{
    const real w = q[0], x = q[1], y = q[2], z = q[3];
    r[0][0] = w * w + x * x - y * y - z * z;
    r[1][1] = w * w - x * x + y * y - z * z;
    r[2][2] = w * w - x * x - y * y + z * z;
    r[0][1] = 2 * (x * y - w * z);
    r[1][0] = 2 * (x * y + w * z);
    r[0][2] = 2 * (x * z + w * y);
    r[2][0] = 2 * (x * z - w * y);
    r[1][2] = 2 * (y * z - w * x);
    r[2][1] = 2 * (y * z + w * x);
}

/* Of second degree in the state: rates, then the quaternion. */
static void slope(const Scene *s, ptrdiff_t k, real t, const real *y, real *f)
{
    const double *I = s->moments;
    real r[3][3], body[3], space[3];
    const real *w = y, *q = y + 3;
    matrix(q, r);
    at(s, s->body, k, t, body);
    at(s, s->space, k, t, space);
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, l = (i + 2) % 3;
        real torque = body[i] + ((real)I[j] - I[l]) * w[j] * w[l] - (s->weight[j] * r[2][l] - s->weight[l] * r[2][j]);
        for (int a = 0; a < 3; a++)
            torque += r[a][i] * space[a] - s->damping[3 * i + a] * w[a];
        f[i] = torque / I[i];
    }
    f[3] = (-q[1] * w[0] - q[2] * w[1] - q[3] * w[2]) / 2;
    f[4] = (q[0] * w[0] - q[3] * w[1] + q[2] * w[2]) / 2;
    f[5] = (q[3] * w[0] + q[0] * w[1] - q[1] * w[2]) / 2;
    f[6] = (-q[2] * w[0] + q[1] * w[1] + q[0] * w[2]) / 2;
}

static int factor(real m[ALL][ALL], int *pivots)
{
    for (int k = 0; k < ALL; k++) {
        int best = k;
        for (int i = k + 1; i < ALL; i++)
            if (fabsl(m[i][k]) > fabsl(m[best][k]))
                best = i;
        pivots[k] = best;
        if (m[best][k] == 0)
            return 0;
        for (int j = 0; j < ALL && best != k; j++) {
            const real held = m[k][j];
            m[k][j] = m[best][j];
            m[best][j] = held;
        }
        for (int i = k + 1; i < ALL; i++) {
            const real share = m[i][k] /= m[k][k];
            if (share != 0)
                for (int j = k + 1; j < ALL; j++)
                    m[i][j] -= share * m[k][j];
        }
    }
    return 1;
}

static void solve(real m[ALL][ALL], const int *pivots, real *x)
{
    for (int k = 0; k < ALL; k++) {
        const real held = x[k];
        x[k] = x[pivots[k]];
        x[pivots[k]] = held;
    }
    for (int k = 0; k < ALL; k++)
        for (int j = 0; j < k; j++)
            x[k] -= m[k][j] * x[j];
    for (int k = ALL - 1; k >= 0; k--) {
        for (int j = k + 1; j < ALL; j++)
            x[k] -= m[k][j] * x[j];
        x[k] /= m[k][k];
    }
}

static real size(const real *v, int n)
{
    real square = 0;
    for (int i = 0; i < n; i++)
        square += v[i] * v[i];
    return sqrtl(square);
}

/* One step; how much the last of eight divided differences is above the tolerance, negative if Newton's iteration
   does not converge. `table`: nodes, A by rows, weights of the last difference of the nodes with 0 before. */
static real step(const Scene *s, ptrdiff_t k, real t, real h, const real *y, real least, double tolerance,
                 const real *table, real *end)
{
    static real m[ALL][ALL];
    const real *c = table, *A = table + STAGES, *top = A + STAGES * STAGES;
    real J[STATE][STATE], f[STAGES][STATE], z[STAGES][STATE] = {{0}}, rest[ALL];
    int pivots[ALL];
    const real unit = 1;
    for (int j = 0; j < STATE; j++) { /* exact: of second degree */
        real plus[STATE], minus[STATE], one[STATE], other[STATE];
        const real e = j < 3 ? fmaxl(size(y, 3), least) : unit;
        for (int i = 0; i < STATE; i++)
            plus[i] = minus[i] = y[i];
        plus[j] += e;
        minus[j] -= e;
        slope(s, k, t, plus, one);
        slope(s, k, t, minus, other);
        for (int i = 0; i < STATE; i++)
            J[i][j] = (one[i] - other[i]) / (plus[j] - minus[j]);
    }
    for (int a = 0; a < STAGES; a++)
        for (int b = 0; b < STAGES; b++)
            for (int i = 0; i < STATE; i++)
                for (int j = 0; j < STATE; j++)
                    m[STATE * a + i][STATE * b + j] = (a == b && i == j) - h * A[STAGES * a + b] * J[i][j];
    if (!factor(m, pivots))
        return -1;
    real before = HUGE_VALL;
    int converged = 0;
    for (int n = 0; n < NEWTONS && !converged; n++) {
        for (int a = 0; a < STAGES; a++) {
            real there[STATE];
            for (int i = 0; i < STATE; i++)
                there[i] = y[i] + z[a][i];
            slope(s, k, t + c[a] * h, there, f[a]);
        }
        for (int a = 0; a < STAGES; a++)
            for (int i = 0; i < STATE; i++) {
                real sum = -z[a][i];
                for (int b = 0; b < STAGES; b++)
                    sum += h * A[STAGES * a + b] * f[b][i];
                rest[STATE * a + i] = sum;
            }
        solve(m, pivots, rest);
        real change = 0, rates = least;
        for (int i = 0; i < 3; i++)
            rates = fmaxl(rates, fabsl(y[i] + z[STAGES - 1][i]));
        for (int a = 0; a < STAGES; a++)
            for (int i = 0; i < STATE; i++) {
                z[a][i] += rest[STATE * a + i];
                change = fmaxl(change, fabsl(rest[STATE * a + i]) / (i < 3 ? rates : unit));
            }
        if (!(change < 1e10L))
            return -1;
        /* The first roundings, or as small as rounding leaves it. */
        converged = change < 1e-18L || (change < 1e-15L && change > before / 4);
        if (!converged && n > 4 && change > 0.9L * before)
            return -1;
        before = change;
    }
    if (!converged)
        return -1;
    real last[STATE] = {0}, worst;
    for (int i = 0; i < STATE; i++) {
        end[i] = y[i] + z[STAGES - 1][i];
        for (int a = 0; a < STAGES; a++)
            last[i] += top[a] * z[a][i];
    }
    worst = size(last, 3) / fmaxl(size(end, 3), least);
    worst = fmaxl(worst, size(last + 3, 4));
    return worst / tolerance;
}

static real energy(const Scene *s, const real *y, real *gamma)
{
    real r[3][3], sum = 0;
    matrix(y + 3, r);
    for (int i = 0; i < 3; i++) {
        gamma[i] = r[2][i];
        sum += s->moments[i] * y[i] * y[i] / 2 + s->weight[i] * gamma[i];
    }
    return sum;
}

/* States from a start at ascending times, none below 0; each number as the sum of two doubles. A record is w, q,
   gamma and the work. Rates below `rest` are compared with it. Returns the number of steps, -1 beyond the limit. */
long stiff_motion(const double *moments, const double *weight, const double *damping, ptrdiff_t knots,
                  const double *times, const double *body, const double *space, const double *omega,
                  const double *attitude, ptrdiff_t count, const double *output, double rest, double tolerance,
                  long limit, const double *table_high, const double *table_low, double *high, double *low)
{
    enum { TABLE = STAGES + STAGES * STAGES + STAGES };
    const Scene s = {moments, weight, damping, knots, times, body, space};
    real table[TABLE], y[STATE], gamma[3], square = 0, t = 0, h = output[count - 1];
    for (int i = 0; i < TABLE; i++)
        table[i] = (real)table_high[i] + table_low[i];
    for (int i = 0; i < 4; i++)
        square += (real)attitude[i] * attitude[i];
    for (int i = 0; i < STATE; i++)
        y[i] = i < 3 ? omega[i] : attitude[i - 3] / sqrtl(square);
    const real begin = energy(&s, y, gamma);
    long steps = 0;
    ptrdiff_t k = 0;
    for (ptrdiff_t done = 0; done < count;) {
        if (output[done] <= t) {
            real record[RECORD];
            for (int i = 0; i < STATE; i++)
                record[i] = y[i];
            record[10] = energy(&s, y, record + 7) - begin;
            for (int i = 0; i < RECORD; i++) {
                high[RECORD * done + i] = record[i];
                low[RECORD * done + i] = record[i] - high[RECORD * done + i];
            }
            done++;
            continue;
        }
        while (knots && k < knots - 2 && times[k + 1] <= t)
            k++;
        real stop = output[done], end[STATE];
        if (knots && times[k + 1] > t && times[k + 1] < stop)
            stop = times[k + 1];
        const int cut = h >= stop - t;
        const real own = cut ? stop - t : h;
        const real excess = step(&s, k, t, own, y, rest, tolerance, table, end);
        if (++steps > limit)
            return -1;
        if (excess >= 0 && excess <= 1) {
            t = cut ? stop : t + own;
            for (int i = 0; i < STATE; i++)
                y[i] = end[i];
            const real longer = own * fminl(4, 0.8L * powl(fmaxl(excess, 1e-30L), -1.0L / 7));
            h = cut ? fmaxl(h, longer) : longer;
        } else {
            h = own * (excess < 0 ? 0.25L : fmaxl(0.1L, 0.8L * powl(excess, -1.0L / 7)));
        }
    }
    return steps;
}
