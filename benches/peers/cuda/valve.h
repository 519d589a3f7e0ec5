// Written by `cargo run -p chatter-dynamics --example tapes_as_cpp`.

namespace flight {
// Output 0 of Motion: Gap(0).
// Output 1 of Motion: Section(0).
struct Motion {
    static constexpr int STATES = 3, SERIES = 8, INVERSES = 1, CONSTANTS = 7, OUTPUTS = 2;
    CHATTER_FUNCTION static void constants(const double *p, double *c) {
        const double e0 = p[0];
        const double e1 = p[1];
        const double e2 = p[2];
        const double e3 = p[3];
        const double e15 = 1.0;
        const double e16 = -1.0;
        const double e17 = e16 * e1;
        const double e20 = e16 * e2;
        const double e31 = -9.7;
        const double e61 = e0 * e3;
        const double e62 = e16 * e3;
        c[0] = e17;
        c[1] = e16;
        c[2] = e15;
        c[3] = e20;
        c[4] = e62;
        c[5] = e61;
        c[6] = e31;
    }
    template <class S, int N>
    CHATTER_FUNCTION static void begin(const S *c, Series<S, N> x, S *low, S *inverse, S factor) {
        if (N > 1) x[1][1] = Compensated<S>(c[3]).add(c[0], x[1][0], low[1]).add(c[1], x[0][0], low[0]).add(c[2], x[2][0], low[2]).value() * factor;
        x[4][0] = square_root(x[2][0]), inverse[0] = S(0.5) / x[4][0];
        x[5][0] = x[0][0] * x[4][0];
        if (N > 1) x[2][1] = Compensated<S>(c[5]).add(c[4], x[5][0], low[5]).value() * factor;
        Compensated<S>(c[6]).add(c[2], x[2][0], low[2]).into(x[7][0], low[7]);
        if (N > 1) x[0][1] = x[1][0] * factor;
    }
    template <class S, int N>
    CHATTER_FUNCTION static void go_on(int k, int last, const S *c, Series<S, N> x, const S *inverse, S factor, S reciprocal) {
        if (k < last) x[1][k + 1] = fused(x[2][k], c[2] * factor, fused(c[1], x[0][k], fused(c[0], x[1][k], S(0.0))) * factor);
        x[4][k] = root_coefficient(x[4], x[2][k], inverse[0], k);
        x[5][k] = convolution(x[0], x[4], k + 1);
        if (k < last) x[2][k + 1] = x[5][k] * (c[4] * factor);
        x[7][k] = fused(c[2], x[2][k], S(0.0));
        if (k < last) x[0][k + 1] = x[1][k] * factor;
    }
    CHATTER_FUNCTION static constexpr int output(int index) {
        return index == 0 ? 0 : index == 1 ? 7 : 0;
    }
    template <class S, int N>
    CHATTER_FUNCTION static S size_of_terms(int series, const S *c, Series<S, N> x) {
        if (series == 7) return absolute(c[6]) + absolute(c[2] * x[2][0]);
        return absolute(x[series][0]);
    }
};
// Outputs after the scalars: states [0, 1].
struct Impact0 {
    static constexpr int STATES = 3, SERIES = 8, INVERSES = 1, CONSTANTS = 10, OUTPUTS = 8;
    CHATTER_FUNCTION static void constants(const double *p, double *c) {
        const double e0 = p[0];
        const double e1 = p[1];
        const double e2 = p[2];
        const double e3 = p[3];
        const double e4 = p[4];
        const double e15 = 1.0;
        const double e16 = -1.0;
        const double e17 = e16 * e1;
        const double e20 = e16 * e2;
        const double e29 = 0.0;
        const double e61 = e0 * e3;
        const double e62 = e16 * e3;
        const double e66 = e16 * e4;
        const double e67 = e1 * e4;
        c[0] = e66;
        c[1] = e67;
        c[2] = e16;
        c[3] = e15;
        c[4] = e20;
        c[5] = e17;
        c[6] = e4;
        c[7] = e62;
        c[8] = e61;
        c[9] = e29;
    }
    template <class S, int N>
    CHATTER_FUNCTION static void begin(const S *c, Series<S, N> x, S *low, S *inverse, S factor) {
        Compensated<S>(S(0.0)).add(c[0], x[1][0], low[1]).into(x[3][0], low[3]);
        Compensated<S>(c[4]).add(c[1], x[1][0], low[1]).add(c[2], x[0][0], low[0]).add(c[3], x[2][0], low[2]).into(x[4][0], low[4]);
        x[5][0] = square_root(x[2][0]), inverse[0] = S(0.5) / x[5][0];
        x[6][0] = x[0][0] * x[5][0];
        Compensated<S>(c[8]).add(c[5], x[4][0], low[4]).add(c[6], x[1][0], low[1]).add(c[7], x[6][0], low[6]).into(x[7][0], low[7]);
    }
    template <class S, int N>
    CHATTER_FUNCTION static void go_on(int k, int last, const S *c, Series<S, N> x, const S *inverse, S factor, S reciprocal) {
        x[3][k] = fused(c[0], x[1][k], S(0.0));
        x[4][k] = fused(c[3], x[2][k], fused(c[2], x[0][k], fused(c[1], x[1][k], S(0.0))));
        x[5][k] = root_coefficient(x[5], x[2][k], inverse[0], k);
        x[6][k] = convolution(x[0], x[5], k + 1);
        x[7][k] = fused(c[7], x[6][k], fused(c[6], x[1][k], fused(c[5], x[4][k], S(0.0))));
    }
    CHATTER_FUNCTION static constexpr int output(int index) {
        return index == 0 ? 1 : index == 1 ? 3 : index == 2 ? 4 : index == 3 ? 7 : index == 4 ? -1 - 6 : index == 5 ? -1 - 6 : index == 6 ? -1 - 9 : index == 7 ? 3 : 0;
    }
    template <class S, int N>
    CHATTER_FUNCTION static S size_of_terms(int series, const S *c, Series<S, N> x) {
        if (series == 3) return S(0.0) + absolute(c[0] * x[1][0]);
        if (series == 4) return absolute(c[4]) + absolute(c[1] * x[1][0]) + absolute(c[2] * x[0][0]) + absolute(c[3] * x[2][0]);
        if (series == 7) return absolute(c[8]) + absolute(c[5] * x[4][0]) + absolute(c[6] * x[1][0]) + absolute(c[7] * x[6][0]);
        return absolute(x[series][0]);
    }
};
struct Local0 {
    static constexpr int STATES = 3, SERIES = 7, INVERSES = 1, CONSTANTS = 6, OUTPUTS = 4;
    CHATTER_FUNCTION static void constants(const double *p, double *c) {
        const double e0 = p[0];
        const double e1 = p[1];
        const double e2 = p[2];
        const double e3 = p[3];
        const double e15 = 1.0;
        const double e16 = -1.0;
        const double e17 = e16 * e1;
        const double e20 = e16 * e2;
        const double e61 = e0 * e3;
        const double e62 = e16 * e3;
        c[0] = e17;
        c[1] = e16;
        c[2] = e15;
        c[3] = e20;
        c[4] = e62;
        c[5] = e61;
    }
    template <class S, int N>
    CHATTER_FUNCTION static void begin(const S *c, Series<S, N> x, S *low, S *inverse, S factor) {
        Compensated<S>(c[3]).add(c[0], x[1][0], low[1]).add(c[1], x[0][0], low[0]).add(c[2], x[2][0], low[2]).into(x[3][0], low[3]);
        x[4][0] = square_root(x[2][0]), inverse[0] = S(0.5) / x[4][0];
        x[5][0] = x[0][0] * x[4][0];
        Compensated<S>(c[5]).add(c[0], x[3][0], low[3]).add(c[1], x[1][0], low[1]).add(c[4], x[5][0], low[5]).into(x[6][0], low[6]);
    }
    template <class S, int N>
    CHATTER_FUNCTION static void go_on(int k, int last, const S *c, Series<S, N> x, const S *inverse, S factor, S reciprocal) {
        x[3][k] = fused(c[2], x[2][k], fused(c[1], x[0][k], fused(c[0], x[1][k], S(0.0))));
        x[4][k] = root_coefficient(x[4], x[2][k], inverse[0], k);
        x[5][k] = convolution(x[0], x[4], k + 1);
        x[6][k] = fused(c[4], x[5][k], fused(c[1], x[1][k], fused(c[0], x[3][k], S(0.0))));
    }
    CHATTER_FUNCTION static constexpr int output(int index) {
        return index == 0 ? 0 : index == 1 ? 1 : index == 2 ? 3 : index == 3 ? 6 : 0;
    }
    template <class S, int N>
    CHATTER_FUNCTION static S size_of_terms(int series, const S *c, Series<S, N> x) {
        if (series == 3) return absolute(c[3]) + absolute(c[0] * x[1][0]) + absolute(c[1] * x[0][0]) + absolute(c[2] * x[2][0]);
        if (series == 6) return absolute(c[5]) + absolute(c[0] * x[3][0]) + absolute(c[1] * x[1][0]) + absolute(c[4] * x[5][0]);
        return absolute(x[series][0]);
    }
};
struct Capture0 {
    static constexpr int STATES = 3, SERIES = 3, INVERSES = 0, CONSTANTS = 1, OUTPUTS = 3;
    CHATTER_FUNCTION static void constants(const double *p, double *c) {
        const double e29 = 0.0;
        c[0] = e29;
    }
    template <class S, int N>
    CHATTER_FUNCTION static void begin(const S *c, Series<S, N> x, S *low, S *inverse, S factor) {
    }
    template <class S, int N>
    CHATTER_FUNCTION static void go_on(int k, int last, const S *c, Series<S, N> x, const S *inverse, S factor, S reciprocal) {
    }
    CHATTER_FUNCTION static constexpr int output(int index) {
        return index == 0 ? -1 - 0 : index == 1 ? -1 - 0 : index == 2 ? 2 : 0;
    }
    template <class S, int N>
    CHATTER_FUNCTION static S size_of_terms(int series, const S *c, Series<S, N> x) {
        return absolute(x[series][0]);
    }
};
struct Residuals {
    static constexpr int STATES = 3, SERIES = 3, INVERSES = 0, CONSTANTS = 0, OUTPUTS = 0;
    CHATTER_FUNCTION static void constants(const double *p, double *c) {
    }
    template <class S, int N>
    CHATTER_FUNCTION static void begin(const S *c, Series<S, N> x, S *low, S *inverse, S factor) {
    }
    template <class S, int N>
    CHATTER_FUNCTION static void go_on(int k, int last, const S *c, Series<S, N> x, const S *inverse, S factor, S reciprocal) {
    }
    CHATTER_FUNCTION static constexpr int output(int index) {
        return 0;
    }
    template <class S, int N>
    CHATTER_FUNCTION static S size_of_terms(int series, const S *c, Series<S, N> x) {
        return absolute(x[series][0]);
    }
};
}

namespace contact_0 {
// Output 0 of Motion: Reaction(0).
// Output 1 of Motion: Section(0).
struct Motion {
    static constexpr int STATES = 3, SERIES = 8, INVERSES = 1, CONSTANTS = 8, OUTPUTS = 2;
    CHATTER_FUNCTION static void constants(const double *p, double *c) {
        const double e0 = p[0];
        const double e1 = p[1];
        const double e2 = p[2];
        const double e3 = p[3];
        const double e15 = 1.0;
        const double e16 = -1.0;
        const double e29 = 0.0;
        const double e31 = -9.7;
        const double e57 = e0 * e3;
        const double e58 = e16 * e3;
        c[0] = e29;
        c[1] = e58;
        c[2] = e57;
        c[3] = e1;
        c[4] = e15;
        c[5] = e16;
        c[6] = e2;
        c[7] = e31;
    }
    template <class S, int N>
    CHATTER_FUNCTION static void begin(const S *c, Series<S, N> x, S *low, S *inverse, S factor) {
        x[3][0] = square_root(x[2][0]), inverse[0] = S(0.5) / x[3][0];
        x[4][0] = x[0][0] * x[3][0];
        if (N > 1) x[2][1] = Compensated<S>(c[2]).add(c[1], x[4][0], low[4]).value() * factor;
        Compensated<S>(c[6]).add(c[3], x[1][0], low[1]).add(c[4], x[0][0], low[0]).add(c[5], x[2][0], low[2]).into(x[6][0], low[6]);
        Compensated<S>(c[7]).add(c[4], x[2][0], low[2]).into(x[7][0], low[7]);
        if (N > 1) x[0][1] = x[1][0] * factor;
        if (N > 1) x[1][1] = c[0] * factor;
    }
    template <class S, int N>
    CHATTER_FUNCTION static void go_on(int k, int last, const S *c, Series<S, N> x, const S *inverse, S factor, S reciprocal) {
        x[3][k] = root_coefficient(x[3], x[2][k], inverse[0], k);
        x[4][k] = convolution(x[0], x[3], k + 1);
        if (k < last) x[2][k + 1] = x[4][k] * (c[1] * factor);
        x[6][k] = fused(c[5], x[2][k], fused(c[4], x[0][k], fused(c[3], x[1][k], S(0.0))));
        x[7][k] = fused(c[4], x[2][k], S(0.0));
        if (k < last) x[0][k + 1] = x[1][k] * factor;
        if (k < last) x[1][k + 1] = S(0.0);
    }
    CHATTER_FUNCTION static constexpr int output(int index) {
        return index == 0 ? 6 : index == 1 ? 7 : 0;
    }
    template <class S, int N>
    CHATTER_FUNCTION static S size_of_terms(int series, const S *c, Series<S, N> x) {
        if (series == 6) return absolute(c[6]) + absolute(c[3] * x[1][0]) + absolute(c[4] * x[0][0]) + absolute(c[5] * x[2][0]);
        if (series == 7) return absolute(c[7]) + absolute(c[4] * x[2][0]);
        return absolute(x[series][0]);
    }
};
struct Local0 {
    static constexpr int STATES = 3, SERIES = 3, INVERSES = 0, CONSTANTS = 1, OUTPUTS = 4;
    CHATTER_FUNCTION static void constants(const double *p, double *c) {
        const double e29 = 0.0;
        c[0] = e29;
    }
    template <class S, int N>
    CHATTER_FUNCTION static void begin(const S *c, Series<S, N> x, S *low, S *inverse, S factor) {
    }
    template <class S, int N>
    CHATTER_FUNCTION static void go_on(int k, int last, const S *c, Series<S, N> x, const S *inverse, S factor, S reciprocal) {
    }
    CHATTER_FUNCTION static constexpr int output(int index) {
        return index == 0 ? 0 : index == 1 ? 1 : index == 2 ? -1 - 0 : index == 3 ? -1 - 0 : 0;
    }
    template <class S, int N>
    CHATTER_FUNCTION static S size_of_terms(int series, const S *c, Series<S, N> x) {
        return absolute(x[series][0]);
    }
};
struct Capture0 {
    static constexpr int STATES = 3, SERIES = 3, INVERSES = 0, CONSTANTS = 1, OUTPUTS = 3;
    CHATTER_FUNCTION static void constants(const double *p, double *c) {
        const double e29 = 0.0;
        c[0] = e29;
    }
    template <class S, int N>
    CHATTER_FUNCTION static void begin(const S *c, Series<S, N> x, S *low, S *inverse, S factor) {
    }
    template <class S, int N>
    CHATTER_FUNCTION static void go_on(int k, int last, const S *c, Series<S, N> x, const S *inverse, S factor, S reciprocal) {
    }
    CHATTER_FUNCTION static constexpr int output(int index) {
        return index == 0 ? -1 - 0 : index == 1 ? -1 - 0 : index == 2 ? 2 : 0;
    }
    template <class S, int N>
    CHATTER_FUNCTION static S size_of_terms(int series, const S *c, Series<S, N> x) {
        return absolute(x[series][0]);
    }
};
struct Residuals {
    static constexpr int STATES = 3, SERIES = 3, INVERSES = 0, CONSTANTS = 0, OUTPUTS = 2;
    CHATTER_FUNCTION static void constants(const double *p, double *c) {
    }
    template <class S, int N>
    CHATTER_FUNCTION static void begin(const S *c, Series<S, N> x, S *low, S *inverse, S factor) {
    }
    template <class S, int N>
    CHATTER_FUNCTION static void go_on(int k, int last, const S *c, Series<S, N> x, const S *inverse, S factor, S reciprocal) {
    }
    CHATTER_FUNCTION static constexpr int output(int index) {
        return index == 0 ? 0 : index == 1 ? 1 : 0;
    }
    template <class S, int N>
    CHATTER_FUNCTION static S size_of_terms(int series, const S *c, Series<S, N> x) {
        return absolute(x[series][0]);
    }
};
}

