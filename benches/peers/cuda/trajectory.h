// One trajectory of the pressure relief valve, as crates/chatter steps it: the same expansions (valve.h, which `tapes_as_cpp` prints),
// certificates, roots, impacts, ends of chatter and phases of contact, to the bit with the same orders. What is no event of this model
// (several contacts, corners, columns of derivatives) is left out. Three things hardly ever happen and are left out, too: a singular
// point that cannot be told from zero, which ends the trajectory, with its reason; a section that is crossed at the instant of an
// impact, and one at the very end of a run.

#pragma once

#include "polynomial.h"
#include "valve.h"

// Orders that a step chooses from, ascending. Where they are written out a step computes all up to the last, in registers, and uses
// those up to its own, which are the same to the bit: threads side by side wait for the highest order among them anyway.
template <bool WRITES_OUT, int... ALL> struct Choice {
    static constexpr int COUNT = sizeof...(ALL), TOP = COUNT - 1;
    static constexpr bool IS_WRITTEN_OUT = WRITES_OUT;
    CHATTER_CONSTEXPR static int of(int index) {
        int order = 0, place = 0;
        ((order = place++ == index ? ALL : order), ...);
        return order;
    }
};
template <int ORDER> using One = Choice<true, ORDER>;
template <bool WRITES_OUT> using All = Choice<WRITES_OUT, 8, 10, 13, 16, 20, 26>;

// Why a trajectory has ended.
enum class Left : int { NOT, UNSETTLED, STUCK, RESTITUTION, UNDECIDED, OFF_CONTACT, PATIENCE };

struct Counts {
    unsigned steps, impacts, settled, accumulations, releases, grazes;
};

// What all trajectories have in common.
struct Common {
    // In the order of the model; the swept one is each trajectory's own.
    double parameters[5];
    // How chatter is completed at this restitution: where it is safe, every how many impacts it is sampled, and the tableau's weights.
    double border;
    int stride;
    double weights[13];
};

constexpr double FOREVER = 1e30, FIRST_UNIT = 0.125, GROWTH = 4.0, LEAST_GROWTH = 1.0 / 16.0, NOISE = 32.0 * ROUNDOFF;
constexpr double LATE_ROUNDOFFS = 8.0, ASKED_ROUNDOFFS = 1024.0, SAFE_FRACTION = 0.5, SAFE_NEGATIVE = -0.25, GRAZE = 5000.0;
// Of the return map: so long may a return take, in so many parts.
constexpr double PATIENCE = 1e4 / 64.0;

CHATTER_FUNCTION double least_step(double time) { return fma(fabs(time) * ROUNDOFF, ROUNDOFF * 1e-12, 1e-290); }
CHATTER_FUNCTION bool reaches(double step, double remaining) { return remaining * (1.0 - 4.0 * ROUNDOFF) <= step; }
CHATTER_FUNCTION double negligible(double time, double longest) { return larger(fabs(time), longest) * ROUNDOFF; }
CHATTER_FUNCTION void later(double &time, double &time_low, double step, double step_low) {
    double error;
    two_sum(time, step, time, error);
    two_sum(time, error + (time_low + step_low), time, time_low);
}
CHATTER_FUNCTION bool legal_rates(double before, double after) {
    const double slack = fabs(before) * 1e-12;
    return 0.0 <= before || (-slack <= after && after <= slack - before);
}
CHATTER_FUNCTION double flight_length(double rate, double acceleration, double jerk) {
    const double nu = -acceleration, radicand = fma(jerk * rate, -8.0 / 3.0, nu * nu);
    const double time = 4.0 * rate / (nu + sqrt(larger(radicand, 0.0)));
    return 0.0 < nu && 0.0 <= radicand && 0.0 <= rate && is_finite(time) ? time : FOREVER;
}

// Values of order zero of a tape's outputs.
template <class Tape, class S> struct AtPoint {
    S c[Tape::CONSTANTS + 1], x[Tape::SERIES][1], low[Tape::SERIES], inverse[Tape::INVERSES + 1];
    CHATTER_FUNCTION AtPoint(const double *parameters, const double *state, const double *remainder) {
        double constants[Tape::CONSTANTS + 1];
        Tape::constants(parameters, constants);
        for (int i = 0; i < Tape::CONSTANTS; ++i) c[i] = S(constants[i]);
        for (int i = 0; i < Tape::STATES; ++i) x[i][0] = S(state[i]), low[i] = as_remainder(remainder[i]);
        for (int i = Tape::STATES; i < Tape::SERIES; ++i) low[i] = S(0.0);
        Tape::begin(c, x, low, inverse, S(0.0));
    }
    CHATTER_FUNCTION S value(int index) const {
        const int place = Tape::output(index);
        return place < 0 ? c[-1 - place] : x[place][0];
    }
    CHATTER_FUNCTION S remainder(int index) const {
        const int place = Tape::output(index);
        return place < 0 ? S(0.0) : low[place];
    }

  private:
    // Terms of a remainder are counted with its number.
    CHATTER_FUNCTION static S as_remainder(double value) {
        S remainder(value);
        drop_terms(remainder);
        return remainder;
    }
    CHATTER_FUNCTION static void drop_terms(double &) {}
    CHATTER_FUNCTION static void drop_terms(WithTerms &value) { value.terms = 0.0; }
};

constexpr int STATES = flight::Motion::STATES;
constexpr int MOST_SERIES =
    flight::Motion::SERIES > contact_0::Motion::SERIES ? flight::Motion::SERIES : contact_0::Motion::SERIES;

// The coefficients of all series, in one mode.
template <class Orders> struct Expansion {
    static constexpr int N = Orders::of(Orders::TOP) + 1;
    double x[MOST_SERIES][N];

    template <class Tape, int K, int LAST> struct Unrolled {
        CHATTER_FUNCTION static void run(const double *c, Series<double, N> x, const double *inverse, double tau) {
            Tape::go_on(K, LAST, c, x, inverse, tau * (1.0 / (K + 1)), 1.0 / K);
            Unrolled<Tape, K + 1, LAST>::run(c, x, inverse, tau);
        }
    };
    template <class Tape, int LAST> struct Unrolled<Tape, LAST, LAST> {
        CHATTER_FUNCTION static void run(const double *c, Series<double, N> x, const double *inverse, double tau) {
            Tape::go_on(LAST, LAST, c, x, inverse, tau, 1.0 / LAST);
        }
    };

    template <class Tape> CHATTER_FUNCTION void run(const double *c, const double *y, const double *y_low, double tau, int order) {
        if constexpr (Orders::IS_WRITTEN_OUT) {
            double low[Tape::SERIES], inverse[Tape::INVERSES + 1];
            for (int i = 0; i < Tape::STATES; ++i) low[i] = y_low[i];
            for (int i = Tape::STATES; i < Tape::SERIES; ++i) low[i] = 0.0;
            double all[Tape::SERIES][N];
            for (int i = 0; i < Tape::STATES; ++i) all[i][0] = y[i];
            Tape::begin(c, all, low, inverse, tau);
            Unrolled<Tape, 1, N - 1>::run(c, all, inverse, tau);
            // What is no state and no guard never leaves the registers.
            CHATTER_UNROLLED
            for (int i = 0; i < Tape::SERIES; ++i) {
                if (i >= Tape::STATES && i != Tape::output(0) && i != Tape::output(1)) continue;
                CHATTER_UNROLLED
                for (int k = 0; k < N; ++k) x[i][k] = all[i][k];
            }
        } else run_rolled<Tape>(c, y, y_low, tau, order);
    }

    template <class Tape> CHATTER_FUNCTION void run_rolled(const double *c, const double *y, const double *y_low, double tau, int order) {
        double low[Tape::SERIES], inverse[Tape::INVERSES + 1];
        for (int i = 0; i < Tape::STATES; ++i) x[i][0] = y[i], low[i] = y_low[i];
        for (int i = Tape::STATES; i < Tape::SERIES; ++i) low[i] = 0.0;
        Tape::begin(c, x, low, inverse, tau);
        CHATTER_ROLLED
        for (int k = 1; k < order; ++k) Tape::go_on(k, order, c, x, inverse, tau * RECIPROCALS.of[k + 1], RECIPROCALS.of[k]);
        Tape::go_on(order, order, c, x, inverse, tau, RECIPROCALS.of[order]);
    }
};

// A section's function along a step: flow/crossing.rs.
struct SectionPath {
    const double *p;
    int n;
    double side, terms, reach;

    CHATTER_FUNCTION static double unit(double value) { return value < 0.0 ? -1.0 : 1.0; }
    CHATTER_FUNCTION static double level(const double *p, int n, double width) { return magnitude(p, n, width) * NOISE; }

    // How it stands to its section where it begins: whether it does, the order that tells, the sign and whether that is a crossing.
    CHATTER_RARE bool start(int &order, double &sign, bool &crossed) const {
        const double most = magnitude(p, n, reach), level = larger(most, terms) * NOISE;
        if (most <= level) return false;
        order = 0, sign = unit(p[0]);
        if (!(fabs(p[0]) > level)) {
            bool told = false;
            for (int k = 100; k >= 0 && !told; --k) {
                const double at = reach * ldexp(1.0, -k), value = horner(p, n, at);
                if (!(fabs(value) > level)) continue;
                told = true, sign = unit(value);
                double greatest = 0.0, power = 1.0;
                for (int i = 1; i < n; ++i) {
                    power *= at;
                    if (fabs(p[i] * power) > greatest) greatest = fabs(p[i] * power), order = i;
                }
            }
            if (!told) return false;
        }
        crossed = side * sign < 0.0 && sign < 0.0;
        return true;
    }
    CHATTER_FUNCTION Root first(double width) const {
        int order;
        double sign;
        bool crossed;
        if (!start(order, sign, crossed)) return {RootKind::NONE, 0.0};
        const double *rest = p + order;
        const int count = n - order;
        Root root = {RootKind::CROSSING, 0.0};
        if (crossed) {
            if (order == 1 && side * p[0] > 0.0) {
                for (int round = 0; round < 4; ++round) {
                    double value, slope;
                    horner_with_slope(p, n, root.at, value, slope);
                    root.at -= value / slope;
                }
                root.at = larger(root.at, 0.0);
            }
        } else {
            root = first_root(rest, count, width, Crossing::FALLING, level(rest, count, width));
            if (root.kind == RootKind::NONE) return root;
        }
        const double middle = (root.at + width) * 0.5;
        const bool distinct = fabs(horner(rest, count, middle)) > level(rest, count, middle)
            || fabs(horner(rest, count, width)) > level(rest, count, width);
        if (!(root.at < width && distinct)) root.kind = RootKind::NONE;
        return root;
    }
    CHATTER_FUNCTION double sign_before(const double *rest, int count, double width, double otherwise) const {
        const double least = level(rest, count, width);
        double distance = 0.0;
        for (int k = 100; k >= 0; --k) {
            const double value = horner(rest, count, width - distance);
            if (fabs(value) > least) return unit(value);
            distance = width * ldexp(1.0, -k);
        }
        return otherwise;
    }
    CHATTER_FUNCTION double side_at(double width) const {
        int order;
        double sign;
        bool crossed;
        return start(order, sign, crossed) && !crossed ? sign_before(p + order, n - order, width, sign) : side;
    }
};

// Samples of a sequence of impacts that may be completed: flow/chatter.
struct Tracker {
    static constexpr int MOST = 14, WIDTH = 1 + STATES;
    bool watches;
    int until_sample, count;
    // Time and states of each, with their rounding remainders.
    double high[MOST][WIDTH], low[MOST][WIDTH];

    CHATTER_FUNCTION void interrupt() { watches = false, count = 0; }

    // Takes note of an impact; whether the end of the sequence is certain, and if so time and change of the state up to there.
    CHATTER_RARE bool observe(const Common &common, const double *now, const double *now_low, double *end) {
        if (!watches) interrupt(), watches = true, until_sample = 0;
        if (until_sample > 0) {
            --until_sample;
            return false;
        }
        until_sample = common.stride - 1;
        if (count == MOST) {
            for (int i = 1; i < MOST; ++i)
                for (int j = 0; j < WIDTH; ++j) high[i - 1][j] = high[i][j], low[i - 1][j] = low[i][j];
            --count;
        }
        for (int j = 0; j < WIDTH; ++j) high[count][j] = now[j], low[count][j] = now_low[j];
        ++count;
        if (count < 3) return false;
        bool certain = true;
        for (int j = 0; j < WIDTH; ++j) {
            double values[MOST], extent = 0.0, before = 0.0;
            for (int i = 0; i < count; ++i) {
                values[i] = (high[i][j] - high[count - 1][j]) + (low[i][j] - low[count - 1][j]);
                extent = larger(extent, fabs(values[i]));
            }
            for (int level = 0; level < count - 1; ++level) {
                const int entries = count - level;
                before = values[entries - 1];
                for (int i = 0; i < entries - 1; ++i)
                    values[i] = fma(values[i + 1] - values[i], common.weights[level], values[i + 1]);
            }
            const double error = fabs(values[0] - before), scale = larger(extent, fabs(now[j]) * (1.0 / 64.0));
            const double uncertain = error > 0.0 ? error / scale : error;
            certain = certain && uncertain <= 32.0 * ROUNDOFF;
            end[j] = values[0];
        }
        return certain;
    }
};

template <class Orders> struct Trajectory {
    static constexpr int N = Expansion<Orders>::N, CLASSES = Orders::COUNT, TOP = Orders::TOP;

    double parameters[5];
    double time = 0.0, time_low = 0.0, y[STATES], low[STATES];
    bool flies = false;
    // How many roots of the gap, of the reaction and of the section lie at the start of the next step.
    int gap_roots = 0, reaction_roots = 0, section_roots = 0;
    // Roots of the gap when it was left, and how long ago that was.
    int left_roots = 0;
    double left_for = 0.0;
    double side = 0.0;
    double reach[CLASSES];
    double flight_time = FOREVER, longest_step = 0.0, since = 0.0, touched_at = 0.0, latest_rate = 0.0;
    unsigned sequence = 0;
    bool completes = false;
    double completion[1 + STATES];
    Left left = Left::NOT;
    Counts counts{};

    // The step.
    double tau, horizon, growth, scaled_step, step, step_low, ended_side;
    double ended[STATES], ended_low[STATES], ended_reach[CLASSES];
    bool clear;
    // The guard that ended it: gap or reaction, section, or none.
    static constexpr int NOWHERE = -1, FIRST = 0, SECTION = 1;
    int event;
    double impact[6], next_flight;

    CHATTER_FUNCTION double remaining() const { return since + PATIENCE - time + (0.0 - time_low); }

    CHATTER_FUNCTION Trajectory(const Common &common, double swept) {
        for (int i = 0; i < 5; ++i) parameters[i] = common.parameters[i];
        parameters[0] = swept;
        y[0] = 0.0, y[1] = 0.0, y[2] = parameters[2];
        for (int i = 0; i < STATES; ++i) low[i] = 0.0;
        for (int i = 0; i < CLASSES; ++i) reach[i] = 0.0;
        reach[TOP] = FIRST_UNIT;
        come_to_rest();
    }

    CHATTER_FUNCTION int plan(double &unit) const {
        int chosen = TOP;
        unit = reach[TOP];
        CHATTER_UNROLLED
        for (int m = TOP; m >= 0; --m) {
            const bool covers = flight_time <= reach[m] * 0.95;
            chosen = covers ? m : chosen, unit = covers ? flight_time : unit;
        }
        unit = of_24_digits(unit * (1.0 / 45045.0)) * 45045.0;
        return chosen;
    }

    CHATTER_FUNCTION const double *first_series(const Expansion<Orders> &e) const {
        return e.x[flies ? flight::Motion::output(0) : contact_0::Motion::output(0)];
    }
    CHATTER_FUNCTION const double *section_series(const Expansion<Orders> &e) const {
        return e.x[flies ? flight::Motion::output(1) : contact_0::Motion::output(1)];
    }
    CHATTER_FUNCTION int first_roots() const { return flies ? gap_roots : reaction_roots; }

    CHATTER_RARE void expand_in_contact(Expansion<Orders> &e, int order) const {
        double c[contact_0::Motion::CONSTANTS];
        contact_0::Motion::constants(parameters, c);
        e.template run_rolled<contact_0::Motion>(c, y, low, tau, order);
    }

    // Expands and finds how far each order reaches.
    CHATTER_FUNCTION void expand(Expansion<Orders> &e, int chosen) {
        const int order = Orders::of(chosen);
        if (flies) {
            double c[flight::Motion::CONSTANTS];
            flight::Motion::constants(parameters, c);
            e.template run<flight::Motion>(c, y, low, tau, order);
        } else expand_in_contact(e, order);
        double inverse[STATES];
        CHATTER_UNROLLED
        for (int i = 0; i < STATES; ++i) {
            const double *p = e.x[i];
            const double leading = (fabs(p[0]) + fabs(p[1])) + (fabs(p[2]) + fabs(p[3]));
            inverse[i] = 1.0 / larger(leading, 1e-290);
        }
        growth = GROWTH;
        CHATTER_UNROLLED
        for (int m = 0; m < CLASSES; ++m) {
            ended_reach[m] = reach[m];
            if (m > chosen) continue;
            double worst = 0.0;
            constexpr double BEFORE_LAST = 1.0 / 16.0;
            CHATTER_UNROLLED
            for (int i = 0; i < STATES; ++i) {
                const double tail = larger(fabs(e.x[i][Orders::of(m)]), fabs(e.x[i][Orders::of(m) - 1]) * BEFORE_LAST);
                worst = larger(worst, tail * inverse[i]);
            }
            // libm::log2(ROUNDOFF * 0.25)
            const double exponent = (-55.0 - coarse_log2(worst)) * (1.0 / Orders::of(m));
            growth = smaller(coarse_exp2(exponent), GROWTH);
            ended_reach[m] = tau * growth;
        }
        growth = smaller(growth, GROWTH);
        double wanted = growth;
        if (horizon < tau * growth) wanted = horizon / tau;
        // The pressure, of which a root is taken.
        const double *p = e.x[2];
        double all, beyond;
        sizes(p + 1, order, wanted, all, beyond);
        const double start = fabs(p[0]), change = all * wanted;
        scaled_step = wanted, clear = true;
        if (!(change <= start * (1.0 / 8.0) && 1e-290 < start)) {
            if (!(change <= start * 0.5)) {
                bool counted;
                const double limit = nearest_zero(p, order + 1, counted) * 0.5;
                if (limit < scaled_step) scaled_step = limit;
                clear = counted;
            }
            clear = clear && fma(start * (ROUNDOFF * ROUNDOFF), 8.0, 1e-290) < start;
        }
        if (scaled_step < wanted) growth = scaled_step;
        double nothing = 0.0;
        for (int i = 0; i < STATES; ++i) nothing = fma(fabs(e.x[i][1]) + fabs(e.x[i][order]), 0.0, nothing);
        clear = clear && is_finite(nothing);
        CHATTER_UNROLLED
        for (int m = 0; m < CLASSES; ++m)
            if (m == chosen) ended_reach[m] = tau * growth;
    }

    CHATTER_RARE static double nearest_zero(const double *a, int n, bool &finite_sums) {
        const int order = n - 1;
        const double inverse = 1.0 / a[0];
        double q[MAX_COEFFICIENTS], closeness = -1.7976931348623157e308;
        finite_sums = true;
        for (int k = 0; k < order; ++k) {
            const double sum = fma(a[k + 1], double(k + 1), convolution(q, a + 1, k)) * inverse;
            q[k] = -sum;
            finite_sums = finite_sums && is_finite(sum);
            if (k >= order / 2) {
                const double root = coarse_log2(fabs(sum)) * (1.0 / (k + 1));
                closeness = root < closeness ? closeness : root;
            }
        }
        return coarse_exp2(-closeness);
    }

    // Shortens the step to the zero of a guard; whether all is certain. `met` where a section may be.
    template <bool IS_SECTION> CHATTER_FUNCTION bool look_at(const double *p, int n, int roots, double relative, bool &met) {
        const double end = scaled_step, start = p[0];
        double all, beyond;
        sizes(p + 1, n - 1, end, all, beyond);
        const double rest = all * end, noise = (rest + fabs(start)) * relative;
        bool settled = rest + noise < fabs(start);
        if (IS_SECTION) {
            const double here = start < 0.0 ? -1.0 : 1.0;
            const bool known = 0.0 < fabs(ended_side), agrees = 0.0 < ended_side * here && 0.0 < fabs(start);
            if (!((agrees || (!known && noise < fabs(start))) && growth * 1e-12 < end)) return false;
            ended_side = here;
        } else if (!(noise < start)) return false;
        if (settled) return true;
        double guess = 0.0;
        bool expected = false, is_real;
        if (!IS_SECTION && flies && roots == 1) {
            guess = smaller(1.0, end);
            expected = fma(fma(coefficient(p, n, 2), end, p[1]), end, p[0]) < 0.0;
        } else {
            guess = quadratic_root(p, n, is_real);
            if (!IS_SECTION) expected = is_real && inside(guess, end);
        }
        if (!expected) {
            double value;
            settled = has_no_event<IS_SECTION>(p, n, start, end, noise, beyond, value);
            if (IS_SECTION) met = !(settled && 0.0 < start * value);
            if (settled) return true;
        }
        double root, slope;
        const bool converged = newton(p, n, guess, end, root, slope);
        const double drop = slope * root;
        bool found = converged && inside(root, end) && noise * (rest + fabs(start)) * GRAZE < drop * drop && noise < start;
        found = found && (falls_by_leading(p, n, root, beyond) || falls_steadily(p, n, root));
        if (IS_SECTION && found) found = noise < fabs(horner(p, n, end));
        if (!found && expected) settled = has_no_event_after_all(p, n, start, end, noise, beyond);
        if (!found && !settled) settled = count_signs(p, n, start, end, noise, found, root);
        if (found) scaled_step = root, event = IS_SECTION ? SECTION : FIRST;
        return found || settled;
    }

    template <bool IS_SECTION>
    CHATTER_FUNCTION static bool has_no_event(
        const double *p, int n, double start, double end, double noise, double beyond, double &value) {
        value = horner(p, n, end);
        const LeadingSlopes slopes(p, n, end, beyond);
        const bool up = slopes.rest < smaller(slopes.first, slopes.last), down = larger(slopes.first, slopes.last) < -slopes.rest;
        const bool stays = noise < smaller(start, value) || larger(start, value) < -noise;
        const bool only_rises = up && start < -noise && noise < value;
        if ((up || down) && (stays || only_rises)) return true;
        return keeps_sign(p, n, end, noise) || (!IS_SECTION && rises(p, n, end, noise, NOISE));
    }

    CHATTER_RARE static bool has_no_event_after_all(const double *p, int n, double start, double end, double noise, double beyond) {
        double value;
        return has_no_event<false>(p, n, start, end, noise, beyond, value);
    }

    CHATTER_RARE static bool count_signs(const double *p, int n, double start, double end, double noise, bool &found, double &at) {
        double values[MAX_COEFFICIENTS];
        bernstein(p[0], p + 1, n, end, values);
        const SignCount count(values, n, noise);
        const bool positive = noise < start;
        if (count.one && positive) {
            double second, slope;
            const double guess = count.first_change * end * (1.0 / (n - 1));
            if (newton(p, n, guess, end, second, slope) && inside(second, end)) at = second, found = true;
        }
        return found || count.none || (count.one && !positive);
    }

    CHATTER_FUNCTION bool locate(const Expansion<Orders> &e, int order) {
        event = NOWHERE;
        const double length = scaled_step * tau;
        if (!(clear && is_finite(length) && least_step(time) < length && LEAST_GROWTH <= growth)) return false;
        double relative = NOISE;
        if (reaches(length, horizon)) relative += fabs(time) * (4.0 * LATE_ROUNDOFFS * ROUNDOFF) / length;
        bool met = false;
        const int roots = first_roots();
        if (!look_at<false>(first_series(e) + roots, order + 1 - roots, roots, relative, met)) return false;
        const double *section = section_series(e) + section_roots;
        const int n = order + 1 - section_roots;
        if (!look_at<true>(section, n, section_roots, relative, met)) return false;
        if (met) {
            const double value = horner(section, n, scaled_step), noise = magnitude(section, n, scaled_step) * NOISE;
            const bool crossed = event == SECTION;
            if (!(crossed || noise < fabs(value))) return false;
            ended_side = crossed ? -ended_side : value < 0.0 ? -1.0 : 1.0;
        }
        return true;
    }

    // Moves to the end of the step, and applies an impact.
    CHATTER_FUNCTION void finish(const Expansion<Orders> &e, int order) {
        step = scaled_step * tau, step_low = fma(scaled_step, tau, -step);
        CHATTER_UNROLLED
        for (int i = 0; i < STATES; ++i)
            two_sum(y[i], fma(horner(e.x[i] + 1, order, scaled_step), scaled_step, low[i]), ended[i], ended_low[i]);
        if (order == Orders::of(TOP) && step * 64.0 < ended_reach[TOP]) ended_reach[TOP] = smaller(ended_reach[TOP], tau);
        next_flight = FOREVER;
        if (!(flies && event == FIRST)) return;
        const AtPoint<flight::Impact0, double> at(parameters, ended, ended_low);
        for (int i = 0; i < 6; ++i) impact[i] = at.value(i);
        if (legal_rates(impact[0], impact[1])) {
            for (int i = 0; i < 2; ++i) ended[i] = at.value(6 + i), ended_low[i] = at.remainder(6 + i);
        }
        next_flight = flight_length(impact[1], impact[2], impact[3]);
    }

    // A step that could not be certified, with full root isolation: flow/resolve.rs.
    CHATTER_RARE bool settle(Expansion<Orders> &e, int chosen, bool &touched, bool &shortened) {
        ++counts.settled;
        const int order = Orders::of(chosen);
        horizon = remaining(), ended_side = side;
        plan(tau);
        for (int tries = 0;; ++tries) {
            expand(e, chosen);
            bool told = is_finite(scaled_step) && scaled_step > 0.0;
            for (int i = 0; i < STATES && told; ++i) told = is_finite(magnitude(e.x[i], order + 1, scaled_step));
            told = told && is_finite(magnitude(first_series(e), order + 1, scaled_step));
            if (told && (growth >= LEAST_GROWTH || tries == 40)) break;
            if (tries > 40) return leave(Left::UNSETTLED);
            tau *= LEAST_GROWTH;
        }
        const double least = least_step(time);
        if (!clear || (scaled_step * tau <= least && horizon > least)) return leave(Left::UNSETTLED);
        event = NOWHERE, touched = false;
        const double whole = scaled_step, open = fabs(time) * (LATE_ROUNDOFFS * ROUNDOFF) / tau;
        const bool ends_the_run = reaches(whole * tau, horizon);

        const int roots = first_roots(), n = order + 1 - roots;
        const double *p = first_series(e) + roots;
        bool skips = false;
        if (!flies && roots == 0) {
            const double level = size_of_terms(e, false) * NOISE;
            skips = true;
            for (int k = 0; k < n; ++k) skips = skips && fabs(p[k]) <= level;
        }
        if (!skips) {
            bool stuck = false;
            Root root;
            double risen[MAX_COEFFICIENTS];
            const int count = flies && roots == 0 ? positive_coefficients(p, n) : 0;
            if (count == 0) {
                root = first_closing(p, n, scaled_step, roots > 0, stuck);
            } else {
                int zeros = 0, m = 0;
                while (zeros < count && larger(p[zeros], 0.0) == 0.0) ++zeros;
                for (int k = zeros; k < n; ++k) risen[m++] = k < count ? larger(p[k], 0.0) : p[k];
                root = first_closing(risen, m, scaled_step, true, stuck);
            }
            if (stuck) return leave(Left::STUCK);
            if (root.kind == RootKind::NONE && ends_the_run) {
                double value, slope;
                horner_with_slope(p, n, scaled_step, value, slope);
                const double noise = magnitude(p, n, scaled_step) * NOISE, level = larger(noise, fabs(slope) * open);
                if (p[0] > level && value <= level && slope * scaled_step < -noise) root = {RootKind::CROSSING, scaled_step};
            }
            if (root.kind != RootKind::NONE) {
                scaled_step = root.at;
                touched = root.kind == RootKind::TOUCHING;
                if (!touched) event = FIRST;
            }
        }
        const Root crossing = section_path(e, order).first(scaled_step);
        if (crossing.kind == RootKind::CROSSING) scaled_step = crossing.at, event = SECTION, touched = false;
        if (crossing.kind == RootKind::TOUCHING) return leave(Left::UNSETTLED);
        ended_side = event == SECTION ? -1.0 : section_path(e, order).side_at(scaled_step);
        shortened = scaled_step < whole;
        finish(e, order);
        return true;
    }

    CHATTER_FUNCTION double size_of_terms(const Expansion<Orders> &e, bool of_section) const {
        auto x = const_cast<Expansion<Orders> &>(e).x;
        if (flies) {
            double c[flight::Motion::CONSTANTS];
            flight::Motion::constants(parameters, c);
            return flight::Motion::size_of_terms<double, N>(flight::Motion::output(of_section), c, x);
        }
        double c[contact_0::Motion::CONSTANTS];
        contact_0::Motion::constants(parameters, c);
        return contact_0::Motion::size_of_terms<double, N>(contact_0::Motion::output(of_section), c, x);
    }

    CHATTER_FUNCTION SectionPath section_path(const Expansion<Orders> &e, int order) const {
        const double seen = longest_step > 0.0 ? larger(longest_step * GROWTH / tau, scaled_step) : growth;
        return {section_series(e) + section_roots, order + 1 - section_roots, ended_side,
                section_roots == 0 ? size_of_terms(e, true) : 0.0,
                section_roots > 0 && scaled_step > 0.0 ? smaller(growth, scaled_step) : smaller(growth, seen)};
    }

    // How many of the lowest coefficients of the gap are known not to be negative, since it was left from rest.
    CHATTER_FUNCTION int positive_coefficients(const double *p, int n) const {
        if (left_roots < 2 || left_roots >= n) return 0;
        const double s = left_for / tau;
        double change = 0.0, power = s, binomial = 1.0;
        for (int above = 0; left_roots + 1 + above < n; ++above) {
            binomial *= double(left_roots + above + 1) / double(above + 1);
            change = fma(fabs(p[left_roots + 1 + above]) * binomial, power, change);
            power *= s;
        }
        return p[left_roots] > change ? left_roots : 0;
    }

    // The first zero of a gap or reaction, whose value at the start is no sum of larger terms.
    CHATTER_RARE static Root first_closing(const double *p, int n, double width, bool is_left, bool &stuck) {
        for (;;) {
            int more = 0;
            while (is_left && more < n && p[more] == 0.0) ++more;
            if (more < n) p += more, n -= more;
            const double start = p[0], level = magnitude(p, n, width) * NOISE;
            if (start > level) return first_root(p, n, width, Crossing::FALLING, level);
            if (!is_left && n >= 3 && p[1] <= 0.0 && p[2] > 0.0 && p[1] * p[1] <= 4.0 * p[2] * level) {
                const double at = -p[1] / (p[2] + p[2]);
                if (at <= width) return {RootKind::TOUCHING, at};
            }
            if (start <= 0.0 && is_left) {
                stuck = true;
                return {RootKind::NONE, 0.0};
            }
            if (start <= 0.0) {
                if (n < 2 || p[1] <= 0.0) return {RootKind::CROSSING, 0.0};
                ++p, --n, is_left = true;
                continue;
            }
            break;
        }
        // Positive, but small against what it reaches later: pieces that double in length, each with the noise of its own size.
        const double start = p[0];
        double end = width, begin = 0.0;
        for (int halving = 0; halving < 1100 && !(start > magnitude(p, n, end) * NOISE); ++halving) end *= 0.5;
        while (end <= width) {
            double piece[MAX_COEFFICIENTS];
            for (int k = 0; k < n; ++k) piece[k] = p[k];
            if (begin != 0.0)
                for (int first = 0; first < n; ++first)
                    for (int k = n - 2; k >= first; --k) piece[k] = fma(piece[k + 1], begin, piece[k]);
            const Root root = first_root(piece, n, end - begin, Crossing::FALLING, magnitude(p, n, end) * NOISE);
            if (root.kind != RootKind::NONE) return {root.kind, begin + root.at};
            begin = end, end = end + end;
        }
        return {RootKind::NONE, 0.0};
    }

    // --- the mode machine -----------------------------------------------------------------------------------------------------------

    CHATTER_FUNCTION bool leave(Left reason) {
        left = reason;
        return false;
    }

    CHATTER_FUNCTION double largest() const { return larger(larger(larger(0.0, fabs(y[0])), fabs(y[1])), fabs(y[2])); }
    CHATTER_FUNCTION bool may_be_rounding(double rate) const { return fabs(rate) <= largest() * (ASKED_ROUNDOFFS * ROUNDOFF); }

    CHATTER_FUNCTION void count_impact(double rate) {
        sequence = sequence > 0 && rate > latest_rate ? sequence + 1 : 1;
        latest_rate = rate;
    }

    // Moves by one step; true where it came to the section.
    CHATTER_FUNCTION bool advance(const Common &common, Expansion<Orders> &e, Tracker &tracker) {
        if (completes) {
            complete();
            return false;
        }
        ++counts.steps;
        horizon = remaining(), ended_side = side;
        const int chosen = plan(tau);
        expand(e, chosen);
        bool touched = false, shortened = false;
        if (locate(e, Orders::of(chosen))) finish(e, Orders::of(chosen));
        else if (!settle(e, chosen, touched, shortened)) return false;
        for (int i = 0; i < STATES; ++i) y[i] = ended[i], low[i] = ended_low[i];
        for (int m = 0; m < CLASSES; ++m) reach[m] = ended_reach[m];
        side = ended_side;
        if (flies && !touched && event != SECTION && follows(common)) {
            if (event == FIRST) tracker.interrupt();
            return false;
        }
        return digest(common, tracker, touched, shortened);
    }

    // An ordinary step: flow/flight.rs.
    CHATTER_FUNCTION bool follows(const Common &common) {
        const bool bounced = event == FIRST;
        double new_time = time, new_low = time_low;
        later(new_time, new_low, step, step_low);
        const double new_longest = larger(longest_step, step);
        bool ordinary = negligible(new_time, longest_step) < step && is_finite(fma(y[2], 0.0, fma(y[1], 0.0, fma(y[0], 0.0, 0.0))));
        if (bounced) {
            const double least = largest() * (ASKED_ROUNDOFFS * ROUNDOFF);
            ordinary = ordinary && impact[0] < -least && legal_rates(impact[0], impact[1]) && 0.0 < impact[1] && 0.0 < impact[4]
                && impact[2] < 0.0 && negligible(new_time, new_longest) < next_flight && impact[5] < 1.0 && is_far(common);
        } else ordinary = ordinary && !reaches(step, remaining());
        if (!ordinary) return false;
        if (bounced) {
            left_roots = 0, left_for = 0.0;
            touched_at = new_time;
            ++counts.impacts;
            count_impact(impact[0]);
            flight_time = next_flight;
        } else {
            if (gap_roots >= 2) left_roots = gap_roots, left_for = step;
            else left_for = left_for + step;
            flight_time = rest_of_flight();
        }
        gap_roots = bounced, section_roots = 0, reaction_roots = 0;
        time = new_time, time_low = new_low, longest_step = new_longest;
        return true;
    }

    CHATTER_FUNCTION double rest_of_flight() const {
        return flight_time < FOREVER && step < flight_time ? flight_time - step : FOREVER;
    }
    CHATTER_FUNCTION bool is_far(const Common &common) const {
        const double above = impact[3] * impact[1], below = impact[2] * impact[2];
        return !(above < SAFE_FRACTION * common.border * below && SAFE_NEGATIVE * below < above);
    }

    CHATTER_RARE bool digest(const Common &common, Tracker &tracker, bool touched, bool shortened) {
        const bool at_horizon = event == NOWHERE && reaches(step, remaining()) && !shortened;
        later(time, time_low, step, step_low);
        const bool opens = !flies && event == FIRST, undisturbed = event != FIRST;
        const double longer_than = negligible(time, longest_step);
        if (!(undisturbed || opens)) left_roots = 0, left_for = 0.0;
        else if (flies && gap_roots >= 2) left_roots = gap_roots, left_for = step;
        else left_for = left_for + step;
        if (!(undisturbed || opens) || step > longer_than) gap_roots = 0, reaction_roots = 0, section_roots = 0;
        if (step > longer_than) longest_step = larger(longest_step, step);
        if (!flies && (y[0] != 0.0 || y[1] != 0.0)) return leave(Left::OFF_CONTACT);
        if (touched) {
            (flies ? gap_roots : reaction_roots) = 2;
            flight_time = FOREVER;
            tracker.interrupt();
            counts.grazes += flies;
            return false;
        }
        if (event == NOWHERE) {
            flight_time = rest_of_flight();
            if (at_horizon) leave(Left::PATIENCE);
            return false;
        }
        if (event == SECTION) {
            section_roots = 1;
            flight_time = rest_of_flight();
            return true;
        }
        if (opens) {
            tracker.interrupt();
            ++counts.releases;
            flies = true, gap_roots = 3, reaction_roots = 0;
            flight_time = FOREVER;
            return false;
        }
        flight_time = next_flight;
        gap_roots = 1;
        meet(common, tracker);
        return false;
    }

    CHATTER_FUNCTION bool only_touches() const {
        double longest = longest_step;
        for (int m = 0; m < CLASSES; ++m) longest = larger(longest, reach[m]);
        const double unit = smaller(longest, time - touched_at), steps = smaller(time / unit, 256.0);
        const double speed = impact[2] * unit, known = (1.0 + sqrt(steps)) * (1024.0 * ROUNDOFF);
        return unit > 0.0 && impact[0] * impact[0] <= known * speed * speed;
    }

    CHATTER_FUNCTION void meet(const Common &common, Tracker &tracker) {
        if (impact[2] > 0.0 && only_touches()) {
            two_sum(y[1], impact[0] - impact[1] + low[1], y[1], low[1]);
            gap_roots = 2, flight_time = FOREVER, touched_at = time, sequence = 0;
            tracker.interrupt();
            ++counts.grazes;
            return;
        }
        touched_at = time;
        if (impact[0] >= 0.0 && sequence > 0) return end_here();
        if (may_be_rounding(impact[0])) {
            const AtPoint<flight::Local0, WithTerms> local(parameters, y, low);
            if (fabs(impact[0]) <= local.value(1).level()) {
                if (sequence > 0) return end_here();
                ++counts.grazes;
                come_to_rest();
                tracker.interrupt();
                return;
            }
        }
        if (!legal_rates(impact[0], impact[1])) {
            left = Left::RESTITUTION;
            return;
        }
        ++counts.impacts;
        count_impact(impact[0]);
        if (!(impact[4] != 0.0 && impact[1] > 0.0)) {
            tracker.interrupt();
            come_to_rest();
            return;
        }
        const bool is_short = flight_time <= negligible(time, longest_step);
        bool certain = false;
        if (impact[5] < 1.0) {
            if (impact[2] < 0.0 && !is_far(common)) {
                const double now[] = {time, y[0], y[1], y[2]}, now_low[] = {time_low, low[0], low[1], low[2]};
                certain = tracker.observe(common, now, now_low, completion) && ends_undisturbed();
            } else tracker.interrupt();
        }
        if (!certain && impact[2] < 0.0 && impact[5] < 1.0 && is_short) {
            completion[0] = flight_time < FOREVER ? flight_time / (1.0 - impact[5]) : FOREVER;
            completion[1] = completion[2] = completion[3] = 0.0;
            certain = true;
        }
        completes = certain;
    }

    // Whether the section stays away until the end of a chatter sequence.
    CHATTER_RARE bool ends_undisturbed() const {
        if (completion[0] > remaining()) return false;
        using Short = Expansion<Choice<false, 8>>;
        Short e;
        double c[flight::Motion::CONSTANTS];
        flight::Motion::constants(parameters, c);
        e.template run<flight::Motion>(c, y, low, completion[0], 8);
        const double *p = e.x[flight::Motion::output(1)];
        const double change = magnitude(p + 1, 8, 1.0) * 2.0, size = fabs(p[0]) + fabs(p[1]);
        if (!(fabs(p[0]) <= change)) return true;
        double rest[STATES];
        const double none[STATES] = {};
        for (int i = 0; i < STATES; ++i) rest[i] = y[i] + (low[i] + completion[1 + i]);
        Short at_rest;
        at_rest.template run<flight::Motion>(c, rest, none, 0.0, 8);
        return fabs(at_rest.x[flight::Motion::output(1)][0]) <= size * 1e-12;
    }

    CHATTER_FUNCTION void end_here() {
        for (int i = 0; i <= STATES; ++i) completion[i] = 0.0;
        complete();
    }

    CHATTER_RARE void complete() {
        completes = false;
        ++counts.accumulations;
        for (int i = 0; i < STATES; ++i) two_sum(y[i], completion[1 + i] + low[i], y[i], low[i]);
        later(time, time_low, completion[0], 0.0);
        come_to_rest();
    }

    // At rest on the seat: it stays closed, or lifts off at once, as acceleration and jerk say.
    CHATTER_RARE void come_to_rest() {
        sequence = 0, left_roots = 0, left_for = 0.0, flight_time = FOREVER;
        flies = true, gap_roots = 0, reaction_roots = 0;
        const AtPoint<flight::Capture0, double> rest(parameters, y, low);
        for (int i = 0; i < STATES; ++i) {
            const double value = rest.value(i);
            if (y[i] != value) y[i] = value, low[i] = 0.0;
        }
        const AtPoint<flight::Local0, WithTerms> local(parameters, y, low);
        const WithTerms acceleration = local.value(2), jerk = local.value(3);
        if (acceleration.value > acceleration.level()) gap_roots = 2;
        else if (acceleration.value < -acceleration.level()) flies = false;
        else if (jerk.value > jerk.level()) gap_roots = 3;
        else if (jerk.value < -jerk.level()) flies = false, reaction_roots = 1;
        else left = Left::UNDECIDED;
    }
};
