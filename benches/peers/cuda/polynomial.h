// Roots of polynomials with certainty: crates/chatter/src/numerics/roots.rs, flow/certificates.rs and what flow/step.rs finds roots by.
// A polynomial has n coefficients, the lowest first.

#pragma once

#include "series.h"

constexpr int MAX_COEFFICIENTS = 27;

// 1 / binomial(n - 1, k).
struct InverseBinomials {
    double of[MAX_COEFFICIENTS + 1][MAX_COEFFICIENTS];
    constexpr InverseBinomials() : of() {
        for (int n = 1; n <= MAX_COEFFICIENTS; ++n) {
            double binomial = 1.0;
            of[n][0] = 1.0;
            for (int k = 1; k < n; ++k) {
                binomial = binomial * (n - k) / k;
                of[n][k] = 1.0 / binomial;
            }
        }
    }
};
CHATTER_TABLE InverseBinomials INVERSE_BINOMIALS;

// Coefficients in Bernstein's basis on [0, width].
CHATTER_FUNCTION void bernstein(double constant, const double *rest, int n, double width, double *out) {
    const double *inverse = INVERSE_BINOMIALS.of[n];
    out[0] = constant;
    double power = width;
    CHATTER_ROLLED
    for (int k = 1; k < n; ++k) out[k] = rest[k - 1] * power * inverse[k], power *= width;
    CHATTER_ROLLED
    for (int first = 1; first < n; ++first)
        CHATTER_ROLLED
        for (int k = n - 1; k >= first; --k) out[k] += out[k - 1];
}

enum class Crossing { FALLING, EITHER };
enum class RootKind { NONE, CROSSING, TOUCHING };
struct Root {
    RootKind kind;
    double at;
};

// --- certificates -----------------------------------------------------------------------------------------------------------------

CHATTER_FUNCTION double coefficient(const double *p, int n, int k) { return k < n ? p[k] : 0.0; }

struct LeadingSlopes {
    double first, last, rest;
    CHATTER_FUNCTION LeadingSlopes(const double *p, int n, double s, double beyond) {
        first = p[1];
        last = fma(coefficient(p, n, 2) * 2.0, s, first);
        const double square = s * s, degree = n - 1;
        const double high = fma(beyond * degree, s, fabs(coefficient(p, n, 4) * 4.0));
        rest = fma(high, s, fabs(coefficient(p, n, 3) * 3.0)) * square;
    }
};

CHATTER_FUNCTION bool falls_by_leading(const double *p, int n, double s, double beyond) {
    const LeadingSlopes slopes(p, n, s, beyond);
    return larger(slopes.first, slopes.last) + slopes.rest < 0.0;
}

CHATTER_FUNCTION bool falls_steadily(const double *p, int n, double s) {
    const double square = s * s, bend = n > 2 ? p[2] + p[2] : 0.0;
    double even = 0.0, odd = 0.0;
    const int high = n > 3 ? n - 3 : 0;
    // As the others, but that what is left over at the top begins the sum of odd powers.
    int k = 3 + (high & ~1);
    if (high & 1) odd = fabs(p[n - 1]) * (n - 1);
    CHATTER_ROLLED
    for (k -= 2; k >= 3; k -= 2) {
        even = fma(even, square, fabs(p[k + 1]) * (k + 1));
        odd = fma(odd, square, fabs(p[k]) * k);
    }
    const double rest = fma(even, s, odd) * square, last = fma(bend, s, p[1]);
    return larger(p[1], last) + rest < 0.0;
}

CHATTER_FUNCTION bool keeps_sign(const double *p, int n, double s, double noise) {
    constexpr int LEADING = 6;
    if (n <= LEADING) return false;
    const double square = s * s, beyond = square * square * square;
    const double level = fma(magnitude(p + LEADING, n - LEADING, s), beyond, noise);
    double leading[LEADING];
    constexpr double INVERSE[LEADING] = {1.0, 1.0 / 5.0, 1.0 / 10.0, 1.0 / 10.0, 1.0 / 5.0, 1.0};
    leading[0] = p[0];
    double power = s;
    CHATTER_UNROLLED
    for (int k = 1; k < LEADING; ++k) leading[k] = p[k] * power * INVERSE[k], power *= s;
    CHATTER_UNROLLED
    for (int first = 1; first < LEADING; ++first)
        CHATTER_UNROLLED
        for (int k = LEADING - 1; k >= first; --k) leading[k] += leading[k - 1];
    double least = leading[0], greatest = leading[0];
    CHATTER_UNROLLED
    for (int k = 1; k < LEADING; ++k) least = smaller(leading[k], least), greatest = larger(leading[k], greatest);
    return level < least || greatest < -level;
}

CHATTER_RARE bool stays_above_tangent(const double *p, int n, double s, double noise) {
    double bend = 0.0;
    CHATTER_ROLLED
    for (int k = n - 1; k >= 3; --k) bend = fma(bend, s, fabs(p[k]) * (k * (k - 1)));
    const double twice = p[2] * 2.0;
    if (!(bend * s < twice)) return false;
    double lowest = -p[1] / twice;
    const double square = lowest * lowest;
    lowest = lowest - p[3] * 3.0 * square / fma(p[3] * 2.0 * 3.0, lowest, twice);
    const double at = smaller(larger(lowest, 0.0), s);
    double value, slope;
    horner_with_slope(p, n, at, value, slope);
    return noise < value - fabs(slope) * s;
}

CHATTER_RARE bool rises(const double *p, int n, double s, double noise, double noise_factor) {
    constexpr double MARGIN = 1.001, FAR = 3.0;
    if (n < 4) return false;
    const double dip = p[1] < 0.0 ? -p[1] : 0.0;
    const double near = smaller(FAR * dip / p[2], s);
    const double least_bend = p[2] - near * magnitude(p + 3, n - 3, near);
    const bool may_rise = 0.0 < p[2] && noise < p[0];
    bool rootless = MARGIN / 4.0 * dip * dip < p[0] * least_bend;
    if (may_rise && !rootless) rootless = stays_above_tangent(p, n, near, noise);
    if (!(rootless && may_rise)) return false;
    double g[MAX_COEFFICIENTS];
    const double level = magnitude(p + 2, n - 2, s) * noise_factor;
    bernstein(p[2] * (1.0 - 1.0 / FAR), p + 3, n - 2, s, g);
    double least = g[0];
    CHATTER_ROLLED
    for (int k = 1; k < n - 2; ++k) least = smaller(g[k], least);
    return level < least;
}

// Signs of Bernstein coefficients: whether all are clear and none or one change, and where that is.
struct SignCount {
    bool none, one;
    double first_change;
    CHATTER_FUNCTION SignCount(const double *values, int n, double noise) {
        int changes = 0;
        bool clear = noise < fabs(values[0]);
        double place = 0.0, before = 1.0, after = 1.0;
        CHATTER_ROLLED
        for (int i = 0; i + 1 < n; ++i) {
            const double a = values[i], b = values[i + 1];
            clear = clear && noise < fabs(b);
            if ((a < 0.0 && 0.0 <= b) || (0.0 <= a && b < 0.0)) {
                if (changes == 0) place = i, before = a, after = b;
                ++changes;
            }
        }
        first_change = place + before / (before - after);
        none = clear && changes == 0;
        one = clear && changes == 1;
    }
};

// --- Newton's method --------------------------------------------------------------------------------------------------------------

CHATTER_FUNCTION bool inside(double place, double end) { return 0.0 < place && place <= end; }

CHATTER_FUNCTION double quadratic_root(const double *p, int n, bool &is_real) {
    const double c = p[0], b = p[1], a = coefficient(p, n, 2);
    const double radicand = fma(b, b, -4.0 * a * c);
    is_real = 0.0 <= radicand;
    return (c + c) / (sqrt(larger(radicand, 0.0)) - b);
}

CHATTER_FUNCTION double nearer_inverse(double nearby, double slope, double &miss) {
    miss = fma(-slope, nearby, 1.0);
    return fma(nearby, miss, nearby);
}

CHATTER_FUNCTION bool newton(const double *p, int n, double guess, double end, double &root, double &slope_there) {
    constexpr int LEADING = 6, STEPS = 6;
    // NEWTON_DONE, times what makes it reach double-double.
    const double least = 1e-8 * sqrt(ROUNDOFF * 1e16), close = sqrt(least);
    const double far = end + end;
    const bool usable = inside(guess, far);
    double at = usable ? guess : end, inverse = 0.0, miss;
    bool done = !usable;
    if (n >= 2 * LEADING) {
        double half_bend = p[LEADING - 1] * 10.0;
        half_bend = fma(half_bend, at, p[4] * 6.0);
        half_bend = fma(half_bend, at, p[3] * 3.0);
        half_bend = fma(half_bend, at, p[2] * 1.0);
        double value, slope;
        leading_with_slope<LEADING>(p, at, value, slope);
        inverse = 1.0 / slope;
        const double step = value * inverse, bend = half_bend * inverse;
        double next = at - fma(step * step, bend, step);
        at = usable && inside(next, far) ? next : at;
        leading_with_slope<2 * LEADING>(p, at, value, slope);
        inverse = nearer_inverse(inverse, slope, miss);
        inverse = nearer_inverse(inverse, slope, miss);
        next = at - value * inverse;
        at = usable && inside(next, far) ? next : at;
    }
    slope_there = 0.0;
    CHATTER_ROLLED
    for (int step = 0; step < STEPS && !done; ++step) {
        double value, slope;
        horner_with_slope(p, n, at, value, slope);
        const double nearer = nearer_inverse(inverse, slope, miss);
        inverse = fabs(miss) <= close ? nearer : 1.0 / slope;
        const double correction = value * inverse;
        slope_there = slope;
        at -= correction;
        done = fabs(correction) <= fabs(at) * least;
    }
    root = at;
    return done && usable;
}

// --- full isolation ---------------------------------------------------------------------------------------------------------------

CHATTER_FUNCTION double bracketed_root(const double *p, int n, double low, double high) {
    const bool rising = horner(p, n, low) < 0.0;
    double at = (low + high) * 0.5, last_step = high - low;
    for (int round = 0; round < 200; ++round) {
        double value, slope;
        horner_with_slope(p, n, at, value, slope);
        if (value == 0.0) return at;
        ((value < 0.0) == rising ? low : high) = at;
        const double newton = at - value / slope;
        const bool is_inside = newton > low && newton < high;
        const double next = is_inside && fabs(newton - at) < last_step * 0.5 ? newton : (low + high) * 0.5;
        last_step = fabs(next - at);
        if (next == at || last_step <= 2.0 * ROUNDOFF * fabs(at)) return next;
        at = next;
    }
    return at;
}

enum class Verdict { NONE, ONE, UNCLEAR };

CHATTER_FUNCTION int sign_beyond(double value, double noise) { return value > noise ? 1 : value < -noise ? -1 : 0; }

CHATTER_FUNCTION Verdict verdict(const double *values, int n, double noise) {
    int changes = 0, unclear = 0, last = sign_beyond(values[0], noise);
    if (last == 0 || sign_beyond(values[n - 1], noise) == 0) return Verdict::UNCLEAR;
    for (int i = 1; i < n; ++i) {
        const int sign = sign_beyond(values[i], noise);
        if (sign == 0) {
            ++unclear;
            continue;
        }
        if (!(unclear == 0 || (unclear == 1 && sign != last))) return Verdict::UNCLEAR;
        changes += sign != last;
        last = sign, unclear = 0;
    }
    return changes == 0 ? Verdict::NONE : changes == 1 ? Verdict::ONE : Verdict::UNCLEAR;
}

CHATTER_FUNCTION bool is_passed(const double *values, int n, Crossing crossing, double noise) {
    bool rises = false, falls = false, small = fabs(values[0]) <= noise;
    for (int i = 0; i + 1 < n; ++i) {
        rises |= values[i + 1] > values[i], falls |= values[i + 1] < values[i];
        small = small && fabs(values[i + 1]) <= noise;
    }
    const bool crosses = (values[0] > 0.0) != (values[n - 1] > 0.0);
    const bool counts = crosses && (falls || crossing == Crossing::EITHER);
    return rises != falls && !counts && small;
}

// Decides a tiny interval in which p is within the noise of zero.
CHATTER_FUNCTION Root indistinct(const double *p, int n, double low, double high, double width, Crossing crossing, double noise) {
    const double at = (low + high) * 0.5, size = high - low;
    double derivative[MAX_COEFFICIENTS];
    for (int k = 1; k < n; ++k) derivative[k - 1] = p[k] * k;
    double turn = at;
    for (int round = 0; round < 8; ++round) {
        double slope, bend;
        horner_with_slope(derivative, n - 1, turn, slope, bend);
        if (bend == 0.0) break;
        turn -= slope / bend;
    }
    if (fabs(turn - at) < 1e-5 * width && turn > 0.0 && turn <= width && fabs(horner(p, n, turn)) <= noise)
        return {RootKind::TOUCHING, turn};
    double value, slope;
    horner_with_slope(p, n, at, value, slope);
    double root = at - value / slope;
    for (int round = 0; round < 3; ++round) {
        double there, steep;
        horner_with_slope(p, n, root, there, steep);
        const double step = there / steep;
        if (fabs(step) < size) root -= step;
    }
    const bool counts = crossing == Crossing::EITHER || slope < 0.0;
    const bool here = root > 0.0 && root > low - size && root <= high + size && root <= width;
    return {counts && here ? RootKind::CROSSING : RootKind::NONE, root};
}

// The first root in (0, width] that crosses as asked, or touches.
CHATTER_RARE Root first_root(const double *p, int n, double width, Crossing crossing, double noise) {
    constexpr int MOST_HALVINGS = 26;
    struct Part {
        double low, high;
        int depth;
        double values[MAX_COEFFICIENTS];
    };
    Part stack[MOST_HALVINGS + 2];
    int parts = 1;
    stack[0].low = 0.0, stack[0].high = width, stack[0].depth = 0;
    bernstein(p[0], p + 1, n, width, stack[0].values);
    while (parts > 0) {
        Part &part = stack[--parts];
        const double low = part.low, high = part.high;
        switch (verdict(part.values, n, noise)) {
        case Verdict::NONE: break;
        case Verdict::ONE:
            if (crossing == Crossing::EITHER || part.values[0] > 0.0) return {RootKind::CROSSING, bracketed_root(p, n, low, high)};
            break;
        case Verdict::UNCLEAR:
            if (is_passed(part.values, n, crossing, noise)) break;
            if (part.depth < MOST_HALVINGS) {
                // The left half lies above the right one.
                Part &left = stack[parts + 1];
                const double middle = (low + high) * 0.5;
                left.low = low, left.high = middle, left.depth = part.depth + 1;
                for (int k = 0; k < n; ++k) left.values[k] = part.values[k];
                for (int step = 0; step < n; ++step) {
                    part.values[n - 1 - step] = left.values[n - 1];
                    for (int i = n - 1; i > step; --i) left.values[i] = (left.values[i - 1] + left.values[i]) * 0.5;
                }
                part.low = middle, part.depth += 1;
                parts += 2;
                break;
            }
            const Root root = indistinct(p, n, low, high, width, crossing, noise);
            if (root.kind != RootKind::NONE) return root;
            break;
        }
    }
    return {RootKind::NONE, 0.0};
}
