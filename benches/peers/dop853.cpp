// The valve by the method of Dormand and Prince of order 8 (DOP853), written for it by hand: what a careful programmer would
// do without Chatter. Tolerance 1e-10, dense output of order 7, events by Newton's method on it, kept in a bracket.
//
//     dop853 columns COLUMNS TRANSIENT KEEP      returns a second, and the first samples
//     dop853 trajectory IMPACTS                  microseconds an impact, time and state
//
// An event is looked for where a function has changed its sign from one end of a step to the other, or the gap has a least
// value between; impacts that show in neither way are passed over. Coefficients are in tableau.h, which environment.py writes
// from SciPy's.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "tableau.h"

namespace {

constexpr double KAPPA = 1.25, DELTA = 10.0, BETA = 20.0, RESTITUTION = 0.8, SECTION = 9.7;
// Relative; and absolute, far below the least gaps that flights reach.
constexpr double TOLERANCE = 1e-10, ABSOLUTE = 1e-14;
// A step from an impact goes a little beyond the end of the flight, by what a constant acceleration says. Longer ones step over
// the last impacts before release, between which the gap is negative for less than a step.
constexpr double BEYOND = 1.1;
constexpr int N = 3;

struct Valve {
    double q;
    double time = 0.0;
    double y[N] = {0.0, 0.0, DELTA};
    double step = 1e-3;
    double k[16][N];
    bool first_known = false;

    explicit Valve(double q) : q(q) {}

    void field(const double *y, double *rate) const {
        rate[0] = y[1];
        rate[1] = -KAPPA * y[1] - y[0] - DELTA + y[2];
        rate[2] = BETA * (q - y[0] * std::sqrt(y[2]));
    }

    template <int S> void stage(double h) {
        double at[N];
        for (int i = 0; i < N; ++i) {
            double sum = 0.0;
            for (int j = 0; j < S; ++j)
                if (A[S][j] != 0.0) sum += A[S][j] * k[j][i];
            at[i] = y[i] + h * sum;
        }
        field(at, k[S]);
    }

    // Goes one accepted step; gives its length and the state at its end.
    double advance(double *end) {
        if (!first_known) field(y, k[0]);
        bool rejected = false;
        for (;;) {
            const double h = step;
            stage<1>(h), stage<2>(h), stage<3>(h), stage<4>(h), stage<5>(h), stage<6>(h);
            stage<7>(h), stage<8>(h), stage<9>(h), stage<10>(h), stage<11>(h);
            double five = 0.0, three = 0.0;
            for (int i = 0; i < N; ++i) {
                double sum = 0.0, e5 = 0.0, e3 = 0.0;
                for (int j = 0; j < 12; ++j) {
                    if (B[j] != 0.0) sum += B[j] * k[j][i];
                    if (E5[j] != 0.0) e5 += E5[j] * k[j][i];
                    if (E3[j] != 0.0) e3 += E3[j] * k[j][i];
                }
                end[i] = y[i] + h * sum;
                const double scale = ABSOLUTE + TOLERANCE * std::max(std::fabs(y[i]), std::fabs(end[i]));
                e5 /= scale, e3 /= scale;
                five += e5 * e5, three += e3 * e3;
            }
            const double below = five + 0.01 * three;
            const double error = below > 0.0 ? h * five / std::sqrt(below * N) : 0.0;
            const double factor = error > 0.0 ? 0.9 * std::pow(error, -0.125) : 6.0;
            if (error <= 1.0) {
                step = h * std::min(rejected ? 1.0 : 6.0, std::max(0.333, factor));
                field(end, k[12]);
                return h;
            }
            rejected = true;
            step = h * std::max(0.333, factor);
        }
    }

    double dense[7][N];

    // Prepares the state within the step that was just made.
    void interpolate(double h, const double *end) {
        stage<13>(h), stage<14>(h), stage<15>(h);
        for (int i = 0; i < N; ++i) {
            const double difference = end[i] - y[i];
            dense[0][i] = difference;
            dense[1][i] = h * k[0][i] - difference;
            dense[2][i] = 2.0 * difference - h * (k[12][i] + k[0][i]);
            for (int d = 0; d < 4; ++d) {
                double sum = 0.0;
                for (int j = 0; j < 16; ++j)
                    if (D[d][j] != 0.0) sum += D[d][j] * k[j][i];
                dense[3 + d][i] = h * sum;
            }
        }
    }

    double at(double x, int i) const {
        double value = 0.0;
        for (int d = 6; d >= 0; --d) value = (value + dense[d][i]) * ((d % 2 == 0) ? x : 1.0 - x);
        return y[i] + value;
    }

    // The same and its derivative.
    void with_slope(double x, int i, double &value, double &slope) const {
        value = slope = 0.0;
        for (int d = 6; d >= 0; --d) {
            const double sum = value + dense[d][i];
            if (d % 2 == 0) slope = slope * x + sum, value = sum * x;
            else slope = slope * (1.0 - x) - sum, value = sum * (1.0 - x);
        }
        value += y[i];
    }

    // Where component i goes through a level, falling (sign 1) or rising (-1), as a part of the step: before `high`.
    double crossing(int i, double level, double sign, double start, double end, double high = 1.0) const {
        double low = 0.0;
        double x = start != 0.0 ? high * start / (start - end) : 0.5 * high;
        for (int round = 0; round < 60; ++round) {
            double value, slope;
            with_slope(x, i, value, slope);
            value -= level;
            (value * sign > 0.0 ? low : high) = x;
            double next = x - value / slope;
            if (!(next > low && next < high)) next = 0.5 * (low + high);
            if (std::fabs(next - x) < 1e-15 + 1e-13 * x) return next;
            x = next;
        }
        return x;
    }

    // Goes on to the next impact or crossing of the section: true for an impact.
    bool next_event() {
        for (;;) {
            double end[N];
            const double h = advance(end);
            bool impact = end[0] < 0.0;
            const bool section = y[2] > SECTION && end[2] <= SECTION;
            // The gap has a least value within the step: the flight before release may end there.
            double until = 1.0, least = end[0];
            if (!impact && y[1] < 0.0 && end[1] > 0.0) {
                interpolate(h, end);
                until = crossing(1, 0.0, -1.0, y[1], end[1]);
                least = at(until, 0);
                impact = least < 0.0;
            }
            if (!impact && !section) {
                std::memcpy(y, end, sizeof y);
                std::memcpy(k[0], k[12], sizeof k[0]);
                first_known = true;
                time += h;
                continue;
            }
            interpolate(h, end);
            double x = 2.0;
            bool hits = false;
            if (impact) {
                x = crossing(0, 0.0, 1.0, y[0], least, until);
                hits = true;
            }
            if (section) {
                const double other = crossing(2, SECTION, 1.0, y[2] - SECTION, end[2] - SECTION);
                if (other < x) x = other, hits = false;
            }
            double state[N];
            for (int i = 0; i < N; ++i) state[i] = at(x, i);
            if (hits) {
                state[0] = 0.0, state[1] *= -RESTITUTION;
                const double acceleration = -KAPPA * state[1] - DELTA + state[2];
                if (acceleration < 0.0) step = std::min(step, BEYOND * 2.0 * state[1] / -acceleration);
            } else state[2] = std::nextafter(SECTION, 0.0);
            std::memcpy(y, state, sizeof y);
            first_known = false;
            time += x * h;
            return hits;
        }
    }
};

double seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

int columns(int count, int transient, int keep) {
    std::vector<double> samples;
    const double started = seconds();
    for (int column = 0; column < count; ++column) {
        Valve valve(0.02015 + (0.023 - 0.02015) * column / std::max(count - 1, 1));
        for (int returns = 0; returns < transient + keep;) {
            if (valve.next_event()) continue;
            if (returns++ >= transient) samples.push_back(valve.y[1]);
        }
    }
    const double spent = seconds() - started;
    std::printf("{\"returns_per_second\": %.17g, \"samples\": [", double(count) * (transient + keep) / spent);
    const size_t printed = std::min<size_t>(samples.size(), 10000);
    for (size_t i = 0; i < printed; ++i) std::printf("%s%.17g", i ? ", " : "", samples[i]);
    std::printf("]}\n");
    return 0;
}

int trajectory(long impacts) {
    Valve valve(0.0203);
    const double started = seconds();
    for (long left = impacts; left > 0;) left -= valve.next_event();
    const double spent = seconds() - started;
    std::printf("{\"microseconds_per_impact\": %.17g, \"time\": %.17g, \"state\": [%.17g, %.17g, %.17g]}\n",
                1e6 * spent / impacts, valve.time, valve.y[0], valve.y[1], valve.y[2]);
    return 0;
}

} // namespace

int main(int argc, char **argv) {
    const std::string what = argc > 1 ? argv[1] : "";
    if (what == "columns" && argc == 5) return columns(std::atoi(argv[2]), std::atoi(argv[3]), std::atoi(argv[4]));
    if (what == "trajectory" && argc == 3) return trajectory(std::atol(argv[2]));
    std::fprintf(stderr, "dop853 columns COLUMNS TRANSIENT KEEP | dop853 trajectory IMPACTS\n");
    return 2;
}
