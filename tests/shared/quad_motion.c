/* The motion of a rigid body in numbers of 128 bits, or of another type, by Taylor series with steps of their own.

   I w' = L x w - weight x gamma + body + R^T space - D w - |w| drag w + 3 n^2 (a/r)^5 p x I p + called + L x e,
   gamma = R^T e3,  L = I w + rotor,  q' = q (0, w + e) / 2,  I e = sink (w' without e),
   p = R^T ((cos E - e) first + sin E second),  r/a = 1 - e cos E,  E' = n a/r.

   The torques body and space are constant, or linear between the times of a table; `called` is the torque of the
   function of this name, below. */

#include <math.h>
#include <stddef.h>

#ifndef NUMBER
#define NUMBER __float128
#endif
typedef NUMBER quad;

enum { ORDER = 40, JUDGED = 3, STATE = 7, RECORD = 11 };

typedef struct {
    const double *moments, *weight, *damping; /* 3, 3, 3 x 3 */
    ptrdiff_t knots;                          /* 0: the torques are constant */
    const double *times, *body, *space;       /* knots, and 3 for each knot, or 3 */
    const double *rotor, *sink, *drag, *orbit; /* 3, 3, 3, and rate, eccentricity, mean anomaly, both semi-axes */
    const double *push, *cubic, *dipole, *field; /* of `called`: 3 and a rate, 3, 3, 3 */
} Scene;

/* The torques on a piece of the table: values now, slopes, and where the piece ends. */
typedef struct {
    quad body[3], body_slope[3], space[3], space_slope[3], end;
} Piece;

/* Coefficients of the rates and of the quaternion. */
typedef struct {
    quad w[3][ORDER + 1], q[4][ORDER + 1];
    quad u[2][2][ORDER + 1]; /* cosine and sine of the eccentric anomaly, and of the angle of the push */
    quad near[5][ORDER + 1]; /* powers of a/r */
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

/* The coefficients n of the powers of a/r, and n + 1 of cosine and sine of the eccentric anomaly, which are hyperbolic
   on a hyperbola. */
static void expand_orbit(const double *orbit, int n, Series *x)
{
    const quad rate = orbit[0], e = orbit[1], sign = e > 1 ? -1 : 1;
    quad sum = n == 0 ? sign : 0;
    for (int k = 1; k <= n; k++)
        sum += e * x->u[0][0][k] * x->near[0][n - k];
    x->near[0][n] = sum / (1 - e * x->u[0][0][0]);
    for (int power = 1; power < 5; power++)
        x->near[power][n] = product(x->near[power - 1], x->near[0], n);
    x->u[0][0][n + 1] = -sign * rate * product(x->u[0][1], x->near[0], n) / (n + 1);
    x->u[0][1][n + 1] = rate * product(x->u[0][0], x->near[0], n) / (n + 1);
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

/* One step of Newton doubles the digits. */
static quad root(quad square)
{
    quad rough = sqrtl((long double)square);
    return rough > 0 ? (rough + square / rough) / 2 : 0;
}

/* The coefficient n of |w| where w vanishes of order `first` at the point that is expanded, forward or backward in
   time: |t|^first times the root of a series. */
static quad speed(Series *x, const quad *of_lower, int first, int n, int ahead)
{
    if (n < first)
        return 0;
    quad square = 0;
    for (int i = 0; i < 3; i++)
        for (int k = first; k <= n; k++)
            square += x->w[i][k] * x->w[i][n + first - k];
    if (n == first)
        return ahead || first % 2 == 0 ? root(square) : -root(square);
    for (int k = first + 1; k < n; k++)
        square -= of_lower[k] * of_lower[n + first - k];
    return square / (2 * of_lower[first]);
}

/* q (0, w) by components: -x1 -y2 -z3,  w1 -z2 +y3,  z1 +w2 -x3,  -y1 +x2 +w3. */
static const int FACTOR[4][3] = {{1, 2, 3}, {0, 3, 2}, {3, 0, 1}, {2, 1, 0}};
static const int SIGN[4][3] = {{-1, -1, -1}, {1, -1, 1}, {1, 1, -1}, {-1, 1, 1}};

/* All coefficients from those of order 0. */
static void expand(const Scene *s, const Piece *piece, int in_space, int ahead, Series *x)
{
    quad r[3][3] = {{0}}, before[3][3];
    quad rows[3][3][ORDER + 1], o[3][ORDER + 1], e[3][ORDER + 1], momentum[3][ORDER + 1], turn[3][ORDER + 1];
    quad fast[ORDER + 1], squares[3][ORDER + 1];
    int first = ORDER; /* the order of w at this point */
    const double *I = s->moments, *weight = s->weight, *orbit = s->orbit;
    const quad push = s->push[3];
    quad products[3][ORDER + 1];
    for (int n = 0; n < ORDER; n++) {
        expand_orbit(orbit, n, x);
        x->u[1][0][n + 1] = -push * x->u[1][1][n] / (n + 1);
        x->u[1][1][n + 1] = push * x->u[1][0][n] / (n + 1);
        if (first == ORDER && (x->w[0][n] != 0 || x->w[1][n] != 0 || x->w[2][n] != 0))
            first = n;
        if (any(s->drag))
            fast[n] = speed(x, fast, first, n, ahead);
        if (in_space || any(weight) || orbit[0] != 0 || any(s->field)) {
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
                    o[i][n] += orbit[3 + a] * (product(rows[a][i], x->u[0][0], n) - (quad)orbit[1] * r[a][i])
                        + orbit[6 + a] * product(rows[a][i], x->u[0][1], n);
            }
            for (int i = 0; i < 3; i++)
                products[i][n] = product(o[(i + 1) % 3], o[(i + 2) % 3], n);
        }
        quad field[3] = {0};
        for (int i = 0; i < 3; i++)
            for (int a = 0; a < 3; a++)
                field[i] += r[a][i] * s->field[a];
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
            if (s->drag[i] != 0)
                torque -= s->drag[i] * product(fast, x->w[i], n);
            torque += s->push[i] * x->u[1][0][n] + s->dipole[j] * field[k] - s->dipole[k] * field[j];
            if (s->cubic[i] != 0) {
                squares[i][n] = product(x->w[i], x->w[i], n);
                torque -= s->cubic[i] * product(squares[i], x->w[i], n);
            }
            if (orbit[0] != 0 && I[j] != I[k])
                torque += 3 * (quad)orbit[0] * orbit[0] * ((quad)I[k] - I[j])
                    * product(products[i], x->near[4], n);
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
static long double longest(Series *x, const double *orbit, long double tolerance)
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
        long double of_orbit = size(x->u[0], 2, n);
        if (orbit[0] != 0 && of_orbit > 0)
            step = fminl(step, powl(tolerance / of_orbit, 1.0L / n));
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

/* A torque for `rigid.Torque.call`: push cos(rate t) - cubic w^3 + dipole x R^T field, with the numbers of the Scene. */
void called(double t, const double *w, const double *q, const double *numbers, double *torque)
{
    const double *push = numbers, *cubic = numbers + 4, *dipole = numbers + 7, *b = numbers + 10;
    const double *v = q + 1;
    double field[3], cosine = cos(push[3] * t);
    double along = v[0] * b[0] + v[1] * b[1] + v[2] * b[2], scalar = q[0] * q[0] - v[0] * v[0] - v[1] * v[1] - v[2] * v[2];
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        field[i] = scalar * b[i] + 2 * along * v[i] - 2 * q[0] * (v[j] * b[k] - v[k] * b[j]);
    }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        torque[i] = push[i] * cosine - cubic[i] * w[i] * w[i] * w[i] + dipole[j] * field[k] - dipole[k] * field[j];
    }
}

/* The part of a step until the body nearly stops: there the speed has another series, which the step does not show where
   the body turns about one direction. The whole step if the body does not stop. */
static quad until_stop(const Series *x, quad step)
{
    enum { LOOKS = 16, HALVINGS = 120 };
    quad first[3], now[3], before = 0;
    for (int i = 0; i < 3; i++) {
        first[i] = x->w[i][0];
        if (x->w[0][0] == 0 && x->w[1][0] == 0 && x->w[2][0] == 0)
            first[i] = value(x->w[i], step / LOOKS);
    }
    for (int look = 1; look <= LOOKS; look++) {
        quad after = step * look / LOOKS, along = 0, square = 0, change = 0;
        for (int i = 0; i < 3; i++)
            along += first[i] * value(x->w[i], after);
        if (along >= 0) {
            before = after;
            continue;
        }
        for (int halving = 0; halving < HALVINGS; halving++) {
            quad middle = (before + after) / 2;
            along = 0;
            for (int i = 0; i < 3; i++)
                along += first[i] * value(x->w[i], middle);
            *(along < 0 ? &after : &before) = middle;
        }
        for (int i = 0; i < 3; i++) {
            now[i] = value(x->w[i], after);
            square += now[i] * now[i];
            change += first[i] * first[i] + x->w[i][1] * x->w[i][1] * step * step;
        }
        return square < 1e-20L * change ? after : step;
    }
    return step;
}

/* Rates that are next to nothing beside those of the start of a step are those of a body at rest. */
static void stop(quad *state, const Series *x, quad step)
{
    quad square = 0, change = 0;
    for (int i = 0; i < 3; i++) {
        square += state[i] * state[i];
        change += x->w[i][0] * x->w[i][0] + x->w[i][1] * x->w[i][1] * step * step;
    }
    for (int i = 0; i < 3 && square < 1e-50L * change; i++)
        state[i] = 0;
}

/* Cosine and sine of the eccentric anomaly at the start: from the periapsis on, where they are 1 and 0. */
static void start_orbit(const double *orbit, quad *anomaly)
{
    quad left = orbit[0] != 0 ? (quad)orbit[2] / orbit[0] : 0;
    anomaly[0] = 1;
    anomaly[1] = 0;
    while (left != 0) {
        Series x;
        x.u[0][0][0] = anomaly[0];
        x.u[0][1][0] = anomaly[1];
        for (int n = 0; n < ORDER; n++)
            expand_orbit(orbit, n, &x);
        const quad step = powl(1e-34L / size(x.u[0], 2, ORDER), 1.0L / ORDER);
        const quad made = left > step ? step : left < -step ? -step : left;
        for (int i = 0; i < 2; i++)
            anomaly[i] = value(x.u[0][i], made);
        left -= made;
    }
}

/* States from a start, at times that go away from 0; each number as the sum of two doubles.

   A record is w, q, gamma and the work since the start. Returns the number of steps, or -1 if
   there would be more than the limit. */
long motion(const double *moments, const double *weight, const double *damping, ptrdiff_t knots,
            const double *times, const double *body, const double *space, const double *satellite,
            const double *function, const double *omega,
            const double *attitude, ptrdiff_t count, const double *output, double tolerance,
            long limit, double *high, double *low)
{
    const Scene scene = {moments, weight, damping, knots, times, body, space,
                         satellite, satellite + 3, satellite + 6, satellite + 9,
                         function, function + 4, function + 7, function + 10};
    quad state[STATE], angles[2][2] = {{1, 0}, {1, 0}}, gamma[3], square = 0, t = 0;
    int in_space = 0;
    for (ptrdiff_t k = 0; k < (knots ? knots : 1); k++)
        in_space |= any(space + 3 * k);
    for (int i = 0; i < 3; i++)
        state[i] = omega[i];
    for (int i = 0; i < 4; i++)
        square += (quad)attitude[i] * attitude[i];
    quad length = root(square);
    for (int i = 0; i < 4; i++)
        state[3 + i] = attitude[i] / length;
    const quad begin = energy(&scene, state, gamma);
    start_orbit(scene.orbit, angles[0]);

    long steps = 0;
    for (ptrdiff_t done = 0; done < count;) {
        const quad target = output[count - 1];
        const int ahead = target > t;
        Piece piece = piece_at(&scene, t, ahead, target);
        Series x;
        for (int i = 0; i < STATE; i++)
            (i < 3 ? x.w[i] : x.q[i - 3])[0] = state[i];
        for (int i = 0; i < 4; i++)
            x.u[i / 2][i % 2][0] = angles[i / 2][i % 2];
        expand(&scene, &piece, in_space, ahead, &x);
        quad end = piece.end;
        const long double step = longest(&x, scene.orbit, tolerance);
        if (step < fabsl((long double)(end - t)))
            end = ahead ? t + (quad)step : t - (quad)step;
        if (any(scene.drag))
            end = t + until_stop(&x, end - t);
        for (; done < count && (ahead ? output[done] <= end : output[done] >= end); done++) {
            quad record[RECORD];
            for (int i = 0; i < STATE; i++)
                record[i] = value(i < 3 ? x.w[i] : x.q[i - 3], output[done] - t);
            record[10] = energy(&scene, record, record + 7) - begin;
            for (int i = 0; i < RECORD; i++) {
                high[RECORD * done + i] = record[i];
                low[RECORD * done + i] = record[i] - high[RECORD * done + i];
            }
        }
        for (int i = 0; i < STATE; i++)
            state[i] = value(i < 3 ? x.w[i] : x.q[i - 3], end - t);
        if (any(scene.drag))
            stop(state, &x, end - t);
        for (int i = 0; i < 4; i++)
            angles[i / 2][i % 2] = value(x.u[i / 2][i % 2], end - t);
        t = end;
        if (++steps > limit)
            return -1;
    }
    return steps;
}
