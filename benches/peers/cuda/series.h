// What the lines call that `tapes_as_cpp` prints: sums and products of coefficients of series, in the sequence and with the fused
// operations of crates/chatter/src/expressions/series.rs, so that the coefficients are the same to the bit. Compile with -fmad=false
// (nvcc) or -ffp-contract=off (others): an operation is fused where it says so, and nowhere else.

#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#ifdef __CUDACC__
#define CHATTER_FUNCTION __device__ __forceinline__
#define CHATTER_CONSTEXPR __host__ __device__ constexpr
#define CHATTER_TABLE __device__ constexpr
// Not inlined: what hardly ever happens should cost the other threads no registers, and no room among their instructions.
#define CHATTER_RARE __device__ __noinline__
// Not unrolled, for the same reason: threads at different places of the code share what holds its instructions.
#define CHATTER_ROLLED _Pragma("unroll 1")
#define CHATTER_UNROLLED _Pragma("unroll")
#else
#define CHATTER_FUNCTION inline __attribute__((always_inline))
#define CHATTER_CONSTEXPR constexpr
#define CHATTER_TABLE constexpr
#define CHATTER_RARE __attribute__((noinline))
#define CHATTER_ROLLED
#define CHATTER_UNROLLED
#endif

// N coefficients of each of several series.
template <class S, int N> using Series = S (*)[N];

constexpr double ROUNDOFF = 0x1p-53;

CHATTER_FUNCTION double fused(double a, double b, double c) { return fma(a, b, c); }
CHATTER_FUNCTION double absolute(double a) { return fabs(a); }
CHATTER_FUNCTION double square_root(double a) { return sqrt(a); }
// The smaller and larger of two; the second where the first is no number.
CHATTER_FUNCTION double smaller(double a, double b) { return a < b ? a : b; }
CHATTER_FUNCTION double larger(double a, double b) { return b < a ? a : b; }
CHATTER_FUNCTION bool is_finite(double a) { return fabs(a) <= 1.7976931348623157e308; }

CHATTER_FUNCTION void two_sum(double a, double b, double &sum, double &rest) {
    const double s = a + b, shadow = s - a;
    rest = (a - (s - shadow)) + (b - shadow);
    sum = s;
}

CHATTER_FUNCTION uint64_t bits_of(double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}
CHATTER_FUNCTION double of_bits(uint64_t bits) {
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

// numerics/scalar.rs
constexpr uint64_t TWO_52_BITS = 0x4330000000000000;
constexpr double TWO_52 = 4503599627370496.0, TWO_40 = 1099511627776.0, BIAS = 1023.0;

CHATTER_FUNCTION double coarse_log2(double value) {
    return (of_bits((bits_of(value) >> 12) | TWO_52_BITS) - TWO_52) * (1.0 / TWO_40) - BIAS;
}
CHATTER_FUNCTION double coarse_exp2(double value) {
    double clamped = value > -1000.0 ? value : -1000.0;
    clamped = clamped < 1000.0 ? clamped : 1000.0;
    return of_bits(bits_of(fma(clamped + BIAS, TWO_40, TWO_52)) << 12);
}
CHATTER_FUNCTION double of_24_digits(double value) {
    constexpr uint64_t DROPPED = uint64_t(1) << 29;
    return of_bits((bits_of(value) + DROPPED / 2) & ~(DROPPED - 1));
}

// numerics/with_terms.rs: a number with the size of the terms that it is the sum of.
struct WithTerms {
    double value, terms;

    CHATTER_FUNCTION WithTerms() : value(0.0), terms(0.0) {}
    CHATTER_FUNCTION WithTerms(double value) : value(value), terms(fabs(value)) {}
    CHATTER_FUNCTION WithTerms(double value, double terms) : value(value), terms(terms) {}
    // Below this it cannot be told from zero.
    CHATTER_FUNCTION double level() const { return 32.0 * ROUNDOFF * terms; }
};

CHATTER_FUNCTION WithTerms operator+(WithTerms a, WithTerms b) { return {a.value + b.value, a.terms + b.terms}; }
CHATTER_FUNCTION WithTerms operator-(WithTerms a) { return {-a.value, a.terms}; }
CHATTER_FUNCTION WithTerms operator*(WithTerms a, WithTerms b) {
    return {a.value * b.value, fma(fabs(a.value), b.terms, fabs(b.value) * a.terms)};
}
CHATTER_FUNCTION WithTerms operator/(WithTerms a, WithTerms b) {
    const double value = a.value / b.value, size = fabs(b.value);
    return {value, a.terms / size + fabs(value) * (b.terms / size)};
}
CHATTER_FUNCTION WithTerms fused(WithTerms a, WithTerms b, WithTerms c) {
    return {fma(a.value, b.value, c.value), (a * b).terms + c.terms};
}
CHATTER_FUNCTION WithTerms square_root(WithTerms a) {
    const double root = sqrt(a.value);
    return {root, fabs(0.5 / root) * a.terms + fabs(root)};
}
CHATTER_FUNCTION void two_sum(WithTerms a, WithTerms b, WithTerms &sum, WithTerms &rest) {
    two_sum(a.value, b.value, sum.value, rest.value);
    sum.terms = a.terms + b.terms, rest.terms = 0.0;
}

// A linear combination of order zero in about twice the working precision.
template <class S> struct Compensated {
    S sum, error;

    CHATTER_FUNCTION explicit Compensated(S offset) : sum(offset), error(0.0) {}
    CHATTER_FUNCTION Compensated &add(S coefficient, S value, S low) {
        const S product = coefficient * value;
        error = error + fused(coefficient, value, -product);
        S lost;
        two_sum(sum, product, sum, lost);
        error = error + lost;
        error = fused(coefficient, low, error);
        return *this;
    }
    CHATTER_FUNCTION void into(S &value, S &low) const { two_sum(sum, error, value, low); }
    CHATTER_FUNCTION S value() const {
        S value, low;
        two_sum(sum, error, value, low);
        return value;
    }
};

// sum_i a_i b_{n-1-i}, the outermost products last.
template <class S> CHATTER_FUNCTION S convolution(const S *a, const S *b, int n) {
    if (n == 0) return S(0.0);
    if (n == 1) return a[0] * b[0];
    S even(0.0), odd(0.0);
    const int pairs = (n - 2) / 2;
    CHATTER_UNROLLED
    for (int j = 0; j < pairs; ++j) {
        even = fused(a[1 + 2 * j], b[n - 2 - 2 * j], even);
        odd = fused(a[2 + 2 * j], b[n - 3 - 2 * j], odd);
    }
    if (n % 2) even = fused(a[n - 2], b[1], even);
    return fused(a[0], b[n - 1], fused(a[n - 1], b[0], even + odd));
}

// sum_{j=first..k-first} a_j a_{k-j}: products of different coefficients, each once, and the square in the middle.
template <class S> CHATTER_FUNCTION void self_pairs(const S *a, int first, int k, S &pairs, S &middle) {
    const int half = (k + 1) / 2;
    pairs = half > first ? convolution(a + first, a + (k + 1 - half), half - first) : S(0.0);
    const bool has_middle = k % 2 == 0 && k / 2 >= first;
    middle = has_middle ? a[k / 2] * a[k / 2] : S(0.0);
}

template <class S> CHATTER_FUNCTION S self_convolution(const S *a, int k) {
    S pairs, middle;
    self_pairs(a, 0, k, pairs, middle);
    return fused(pairs, S(2.0), middle);
}

template <class S> CHATTER_FUNCTION S root_coefficient(const S *root, S radicand, S inverse, int k) {
    S pairs, middle;
    self_pairs(root, 1, k, pairs, middle);
    return fused(radicand, inverse, fused(pairs, inverse * S(-2.0), -(middle * inverse)));
}

// 1 / k, correctly rounded.
struct Reciprocals {
    double of[52];
    constexpr Reciprocals() : of() {
        for (int k = 1; k < 52; ++k) of[k] = 1.0 / k;
    }
};
CHATTER_TABLE Reciprocals RECIPROCALS;

// numerics/polynomial.rs: p has n coefficients.

CHATTER_FUNCTION double horner(const double *p, int n, double s) {
    const double square = s * s;
    double even = 0.0, odd = 0.0;
    int k = n & ~1;
    if (n & 1) even = p[n - 1];
    CHATTER_ROLLED
    for (k -= 2; k >= 0; k -= 2) even = fma(even, square, p[k]), odd = fma(odd, square, p[k + 1]);
    return fma(odd, s, even);
}

CHATTER_FUNCTION void horner_with_slope(const double *p, int n, double s, double &value, double &slope) {
    const double square = s * s;
    double even = 0.0, odd = 0.0, even_slope = 0.0, odd_slope = 0.0;
    int k = n & ~1;
    if (n & 1) even = p[n - 1];
    CHATTER_ROLLED
    for (k -= 2; k >= 0; k -= 2) {
        even_slope = fma(even_slope, square, even), odd_slope = fma(odd_slope, square, odd);
        even = fma(even, square, p[k]), odd = fma(odd, square, p[k + 1]);
    }
    value = fma(odd, s, even);
    slope = fma(s + s, fma(odd_slope, s, even_slope), odd);
}

template <int N> CHATTER_FUNCTION void leading_with_slope(const double *p, double s, double &value, double &slope) {
    const double square = s * s;
    double even = p[N - 2], odd = p[N - 1], even_slope = even, odd_slope = odd;
    even = fma(even, square, p[N - 4]), odd = fma(odd, square, p[N - 3]);
    CHATTER_UNROLLED
    for (int k = N - 6; k >= 0; k -= 2) {
        even_slope = fma(even_slope, square, even), odd_slope = fma(odd_slope, square, odd);
        even = fma(even, square, p[k]), odd = fma(odd, square, p[k + 1]);
    }
    value = fma(odd, s, even);
    slope = fma(s + s, fma(odd_slope, s, even_slope), odd);
}

CHATTER_FUNCTION double magnitude(const double *p, int n, double s) {
    double sum = 0.0;
    CHATTER_ROLLED
    for (int k = n - 1; k >= 0; --k) sum = fma(sum, s, fabs(p[k]));
    return sum;
}

// Sums of the sizes of terms: of all, and of those after the leading four, over s^4.
CHATTER_FUNCTION void sizes(const double *p, int n, double s, double &all, double &beyond) {
    constexpr int LEADING = 4;
    beyond = 0.0;
    if (n < LEADING) {
        all = magnitude(p, n, s);
        return;
    }
    const double square = s * s;
    double even = 0.0, odd = 0.0;
    const int others = n - LEADING;
    int k = LEADING + (others & ~1);
    if (others & 1) even = fabs(p[n - 1]);
    CHATTER_ROLLED
    for (k -= 2; k >= LEADING; k -= 2) even = fma(even, square, fabs(p[k])), odd = fma(odd, square, fabs(p[k + 1]));
    beyond = fma(odd, s, even);
    CHATTER_UNROLLED
    for (k = LEADING - 2; k >= 0; k -= 2) even = fma(even, square, fabs(p[k])), odd = fma(odd, square, fabs(p[k + 1]));
    all = fma(odd, s, even);
}
