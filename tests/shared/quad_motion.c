/* The motion of a rigid body in 128-bit numbers, by Taylor series with steps of their own.

   I w' = L x w - weight x gamma + body + R^T space - D w + 3 n^2 o x I o + L x e,  gamma = R^T e3,
   L = I w + rotor,  q' = q (0, w + e) / 2,  I e = sink (w' without e),  o = R^T (cos towards + sin ahead)
   with the angle n t. The torques body and space are constant, or linear between the times of a table. */

#include <math.h>
#include <stddef.h>

typedef __float128 quad;

enum { ORDER = 40, JUDGED = 3, STATE = 7, RECORD = 11 };

typedef struct {
    const double *moments, *weight, *damping; /* 3, 3, 3 x 3 */
    ptrdiff_t knots;                          /* 0: the torques are constant */
    const double *times, *body, *space;       /* knots, and 3 for each knot, or 3 */
    const double *rotor, *sink, *orbit;       /* 3, 3, and the rate, 3 towards, 3 ahead */
} Scene;

/* The torques on a piece of the table: values now, slopes, and where the piece ends. */
typedef struct {
    quad body[3], body_slope[3], space[3], space_slope[3], end;
} Piece;

/* Coefficients of the rates and of the quaternion. */
typedef struct {
    quad w[3][ORDER + 1], q[4][ORDER + 1];
    quad u[2][ORDER + 1]; /* cosine and sine of the angle on the orbit */
} Series;

static void line(const Scene *s, const double *values, ptrdiff_t k, quad t, quad *now, quad *slope)
{
    for (int i = 0; i < 3; i++) {
        now[i] = values[3 * k + i];
        slope[i] = 0;
        if (s->knots && s->times[k + 1] > s->times[k]) {
            quad begin = s->times[k];
            slope[i] = ((quad)values[3 * k + 3 + i] - now[i]) / (s->times[k + 1] - begin);
            now[i] += slope[i] * (t - begin);
        }
    }
}

/* The piece that begins at t in this direction, and the nearer of its end and the target. */
static Piece piece_at(const Scene *s, quad t, int ahead, quad target)
{
    Piece piece = {.end = target};
    ptrdiff_t k = 0;
    if (s->knots) {
        if (ahead)
            while (k < s->knots - 2 && s->times[k + 1] <= t)
                k++;
        else
            for (k = s->knots - 2; k > 0 && s->times[k] >= t;)
                k--;
        quad knot = s->times[ahead ? k + 1 : k];
        if ((ahead && t < knot && knot < target) || (!ahead && target < knot && knot < t))
            piece.end = knot;
    }
    line(s, s->body, k, t, piece.body, piece.body_slope);
    line(s, s->space, k, t, piece.space, piece.space_slope);
    return piece;
}

static quad product(const quad *a, const quad *b, int n)
{
    quad sum = 0;
    for (int k = 0; k <= n; k++)
        sum += a[k] * b[n - k];
    return sum;
}

/* The matrix R of v_space = R v_body from the products of the components of q. */
static void matrix(quad p[4][4], quad r[3][3])
{
    enum { W, X, Y, Z };
    r[0][0] = p[W][W] + p[X][X] - p[Y][Y] - p[Z][Z];
    r[1][1] = p[W][W] - p[X][X] + p[Y][Y] - p[Z][Z];
    r[2][2] = p[W][W] - p[X][X] - p[Y][Y] + p[Z][Z];
    r[0][1] = 2 * (p[X][Y] - p[W][Z]);
    r[1][0] = 2 * (p[X][Y] + p[W][Z]);
    r[0][2] = 2 * (p[X][Z] + p[W][Y]);
    r[2][0] = 2 * (p[X][Z] - p[W][Y]);
    r[1][2] = 2 * (p[Y][Z] - p[W][X]);
    r[2][1] = 2 * (p[Y][Z] + p[W][X]);
}

static int any(const double *v)
{
    return v[0] != 0 || v[1] != 0 || v[2] != 0;
}

/* q (0, w) by components: -x1 -y2 -z3,  w1 -z2 +y3,  z1 +w2 -x3,  -y1 +x2 +w3. */
static const int FACTOR[4][3] = {{1, 2, 3}, {0, 3, 2}, {3, 0, 1}, {2, 1, 0}};
static const int SIGN[4][3] = {{-1, -1, -1}, {1, -1, 1}, {1, 1, -1}, {-1, 1, 1}};

/* All coefficients from those of order 0. */
static void expand(const Scene *s, const Piece *piece, int in_space, Series *x)
{
    quad r[3][3] = {{0}}, before[3][3];
    quad rows[3][3][ORDER + 1], o[3][ORDER + 1], e[3][ORDER + 1], momentum[3][ORDER + 1], turn[3][ORDER + 1];
    const double *I = s->moments, *weight = s->weight, *orbit = s->orbit;
    for (int n = 0; n < ORDER; n++) {
        if (in_space || any(weight) || orbit[0] != 0) {
            quad p[4][4];
            for (int i = 0; i < 4; i++)
                for (int j = i; j < 4; j++)
                    p[i][j] = product(x->q[i], x->q[j], n);
            for (int i = 0; i < 3; i++)
                for (int j = 0; j < 3; j++)
                    before[i][j] = r[i][j];
            matrix(p, r);
        }
        for (int i = 0; i < 3; i++)
            momentum[i][n] = I[i] * x->w[i][n] + (n == 0 ? s->rotor[i] : 0);
        if (orbit[0] != 0) {
            for (int i = 0; i < 3; i++) {
                for (int a = 0; a < 3; a++)
                    rows[a][i][n] = r[a][i];
                o[i][n] = 0;
                for (int a = 0; a < 3; a++)
                    o[i][n] += orbit[1 + a] * product(rows[a][i], x->u[0], n)
                        + orbit[4 + a] * product(rows[a][i], x->u[1], n);
            }
            x->u[0][n + 1] = -(quad)orbit[0] * x->u[1][n] / (n + 1);
            x->u[1][n + 1] = (quad)orbit[0] * x->u[0][n] / (n + 1);
        }
        quad whole[3];
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, k = (i + 2) % 3;
            quad torque = n == 0 ? piece->body[i] : n == 1 ? piece->body_slope[i] : 0;
            if (I[j] != I[k])
                torque += ((quad)I[j] - I[k]) * product(x->w[j], x->w[k], n);
            torque -= weight[j] * r[2][k] - weight[k] * r[2][j];
            for (int a = 0; a < 3; a++) {
                torque -= s->damping[3 * i + a] * x->w[a][n];
                if (in_space) {
                    torque += r[a][i] * piece->space[a];
                    if (n > 0)
                        torque += before[a][i] * piece->space_slope[a];
                }
            }
            torque += s->rotor[j] * x->w[k][n] - s->rotor[k] * x->w[j][n];
            if (orbit[0] != 0 && I[j] != I[k])
                torque += 3 * (quad)orbit[0] * orbit[0] * ((quad)I[k] - I[j]) * product(o[j], o[k], n);
            whole[i] = torque;
            e[i][n] = s->sink[i] * torque / I[i] / I[i];
            turn[i][n] = x->w[i][n] + e[i][n];
        }
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, k = (i + 2) % 3;
            quad torque = whole[i];
            if (any(s->sink))
                torque += product(momentum[j], e[k], n) - product(momentum[k], e[j], n);
            x->w[i][n + 1] = torque / I[i] / (n + 1);
        }
        for (int i = 0; i < 4; i++) {
            quad sum = 0;
            for (int a = 0; a < 3; a++)
                sum += SIGN[i][a] * product(x->q[FACTOR[i][a]], turn[a], n);
            x->q[i][n + 1] = sum / 2 / (n + 1);
        }
    }
}

static long double size(quad (*series)[ORDER + 1], int rows, int n)
{
    quad square = 0;
    for (int i = 0; i < rows; i++)
        square += series[i][n] * series[i][n];
    return sqrtl((long double)square);
}

/* The step whose last terms are below the tolerance, as shares of an early term and of one. */
static long double longest(Series *x, long double tolerance)
{
    long double step = HUGE_VALL;
    for (int n = ORDER - JUDGED + 1; n <= ORDER; n++) {
        long double of_rates = size(x->w, 3, n), of_attitude = size(x->q, 4, n);
        if (of_rates > 0) {
            long double best = 0; /* at rest the rates are small beside their next terms */
            for (int k = 0; k < 3; k++)
                best = fmaxl(best, powl(tolerance * size(x->w, 3, k) / of_rates, 1.0L / (n - k)));
            step = fminl(step, best);
        }
        if (of_attitude > 0)
            step = fminl(step, powl(tolerance / of_attitude, 1.0L / n));
    }
    return step;
}

static quad value(const quad *series, quad h)
{
    quad sum = series[ORDER];
    for (int n = ORDER - 1; n >= 0; n--)
        sum = sum * h + series[n];
    return sum;
}

/* Kinetic and potential energy; the vertical in the body. */
static quad energy(const Scene *s, const quad *state, quad *gamma)
{
    quad p[4][4], r[3][3], sum = 0;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            p[i][j] = state[3 + i] * state[3 + j];
    matrix(p, r);
    for (int i = 0; i < 3; i++) {
        gamma[i] = r[2][i];
        sum += s->moments[i] * state[i] * state[i] / 2 + s->weight[i] * gamma[i];
    }
    return sum;
}

/* States from a start, at times that go away from 0; each number as the sum of two doubles.

   A record is w, q, gamma and the work since the start. Returns the number of steps, or -1 if
   there would be more than the limit. */
long motion(const double *moments, const double *weight, const double *damping, ptrdiff_t knots,
            const double *times, const double *body, const double *space, const double *satellite,
            const double *omega,
            const double *attitude, ptrdiff_t count, const double *wanted, double tolerance,
            long limit, double *high, double *low)
{
    const Scene scene = {moments, weight, damping, knots, times, body, space, satellite, satellite + 3,
                         satellite + 6};
    quad state[STATE], angle[2] = {1, 0}, gamma[3], square = 0, t = 0;
    int in_space = 0;
    for (ptrdiff_t k = 0; k < (knots ? knots : 1); k++)
        in_space |= any(space + 3 * k);
    for (int i = 0; i < 3; i++)
        state[i] = omega[i];
    for (int i = 0; i < 4; i++)
        square += (quad)attitude[i] * attitude[i];
    quad length = sqrtl((long double)square); /* one step of Newton doubles its digits */
    length = (length + square / length) / 2;
    for (int i = 0; i < 4; i++)
        state[3 + i] = attitude[i] / length;
    const quad begin = energy(&scene, state, gamma);

    long steps = 0;
    for (ptrdiff_t done = 0; done < count;) {
        const quad target = wanted[count - 1];
        const int ahead = target > t;
        Piece piece = piece_at(&scene, t, ahead, target);
        Series x;
        for (int i = 0; i < STATE; i++)
            (i < 3 ? x.w[i] : x.q[i - 3])[0] = state[i];
        for (int i = 0; i < 2; i++)
            x.u[i][0] = angle[i];
        expand(&scene, &piece, in_space, &x);
        quad end = piece.end;
        const long double step = longest(&x, tolerance);
        if (step < fabsl((long double)(end - t)))
            end = ahead ? t + (quad)step : t - (quad)step;
        for (; done < count && (ahead ? wanted[done] <= end : wanted[done] >= end); done++) {
            quad record[RECORD];
            for (int i = 0; i < STATE; i++)
                record[i] = value(i < 3 ? x.w[i] : x.q[i - 3], wanted[done] - t);
            record[10] = energy(&scene, record, record + 7) - begin;
            for (int i = 0; i < RECORD; i++) {
                high[RECORD * done + i] = record[i];
                low[RECORD * done + i] = record[i] - high[RECORD * done + i];
            }
        }
        for (int i = 0; i < STATE; i++)
            state[i] = value(i < 3 ? x.w[i] : x.q[i - 3], end - t);
        for (int i = 0; i < 2 && satellite[6] != 0; i++)
            angle[i] = value(x.u[i], end - t);
        t = end;
        if (++steps > limit)
            return -1;
    }
    return steps;
}
