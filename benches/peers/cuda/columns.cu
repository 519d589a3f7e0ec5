// Columns of the valve's orbit diagram, one trajectory a thread. Compiled as C++ for the processor it runs them one after the other.
//
//     columns COLUMNS TRANSIENT KEEP [ORDER [BLOCK [RESTITUTION]]]
//
// Prints a line of JSON. ORDER 0: those of crates/chatter, each as it is needed, written out; 1: the same in a loop over orders;
// 16 or 18: each step has this order. BLOCK: threads a block. RESTITUTION: one half or more; well below 0.8 chatter comes to rest.
// Samples of the first columns go to the file that CHATTER_SAMPLES names, as doubles. valve.h is what `tapes_as_cpp` prints of
// models/pressure_relief_valve.toml.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "trajectory.h"

struct Summary {
    Counts counts;
    int left;
    double time;
};

template <class Orders>
CHATTER_FUNCTION Summary column(const Common &common, double swept, int transient, int keep, double *samples) {
    Trajectory<Orders> trajectory(common, swept);
    Expansion<Orders> expansion;
    Tracker tracker;
    tracker.interrupt();
    for (int returns = 0; returns < transient + keep && trajectory.left == Left::NOT;) {
        if (!trajectory.advance(common, expansion, tracker)) continue;
        trajectory.since = trajectory.time;
        if (returns >= transient && samples) samples[returns - transient] = trajectory.y[1];
        ++returns;
    }
    return {trajectory.counts, int(trajectory.left), trajectory.time};
}

CHATTER_FUNCTION double swept(int column, int columns) {
    const double first = 0.02015, last = 0.023;
    return column == 0 ? first : column + 1 == columns ? last : first + (last - first) * (double(column) / double(columns - 1));
}

#ifdef __CUDACC__
template <class Orders>
__global__ void all_columns(Common common, int columns, int transient, int keep, double *samples, int stored, Summary *out) {
    const int index = blockIdx.x * blockDim.x + threadIdx.x;
    if (index >= columns) return;
    double *place = index < stored ? samples + size_t(index) * keep : nullptr;
    out[index] = column<Orders>(common, swept(index, columns), transient, keep, place);
}

void check(cudaError_t error, const char *what) {
    if (error == cudaSuccess) return;
    std::fprintf(stderr, "%s: %s\n", what, cudaGetErrorString(error));
    std::exit(1);
}
#endif

// Runs all; gives the seconds that it took.
template <class Orders>
double run(const Common &common, int columns, int transient, int keep, int block, std::vector<double> &samples, std::vector<Summary> &out) {
    const int stored = int(samples.size() / keep);
#ifdef __CUDACC__
    double *device_samples;
    Summary *device_out;
    check(cudaMalloc(&device_samples, samples.size() * sizeof(double)), "samples");
    check(cudaMalloc(&device_out, out.size() * sizeof(Summary)), "summaries");
    check(cudaMemset(device_samples, 0xff, samples.size() * sizeof(double)), "poison");
    check(cudaMemset(device_out, 0xff, out.size() * sizeof(Summary)), "poison");
    cudaEvent_t started, ended;
    cudaEventCreate(&started), cudaEventCreate(&ended);
    // Once for one return, so that what is done at the first launch is not timed.
    all_columns<Orders><<<1, block>>>(common, 1, 0, 1, device_samples, 0, device_out);
    cudaEventRecord(started);
    all_columns<Orders><<<(columns + block - 1) / block, block>>>(common, columns, transient, keep, device_samples, stored, device_out);
    cudaEventRecord(ended);
    check(cudaDeviceSynchronize(), "columns");
    float milliseconds;
    cudaEventElapsedTime(&milliseconds, started, ended);
    check(cudaMemcpy(samples.data(), device_samples, samples.size() * sizeof(double), cudaMemcpyDeviceToHost), "samples");
    check(cudaMemcpy(out.data(), device_out, out.size() * sizeof(Summary), cudaMemcpyDeviceToHost), "summaries");
    cudaFree(device_samples), cudaFree(device_out);
    return milliseconds * 1e-3;
#else
    (void)block;
    const auto started = std::chrono::steady_clock::now();
    for (int i = 0; i < columns; ++i)
        out[i] = column<Orders>(common, swept(i, columns), transient, keep, i < stored ? &samples[size_t(i) * keep] : nullptr);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
#endif
}

// flow/border_value.rs, for restitutions above one half.
double border_value(double r) {
    const double rest = 1.0 - r;
    double d = 0.0;
    for (int step = 0; step < 60; ++step) {
        const double value = d * (5.0 - 5.0 * d + d * d) - rest * (3.0 - 2.0 * d);
        const double slope = 5.0 - 10.0 * d + 3.0 * d * d + 2.0 * rest;
        const double next = d - value / slope;
        if (!(next > d)) break;
        d = next;
    }
    return d * (2.0 + (1.0 - d)) / 6.0;
}

int main(int count, char **arguments) {
    const auto number = [&](int place, int otherwise) { return count > place ? std::atoi(arguments[place]) : otherwise; };
    const int columns = number(1, 1000), transient = number(2, 100), keep = number(3, 200), order = number(4, 0), block = number(5, 64);
    Common common = {{0.0203, 1.25, 10.0, 20.0, 0.0}, 0.0, 1, {}};
    const double r = common.parameters[4] = count > 6 ? std::atof(arguments[6]) : 0.8;
    common.border = border_value(r);
    common.stride = int(std::ceil(std::log(0.5) / std::log(r)));
    const double ratio = std::pow(r, common.stride);
    double power = ratio;
    for (double &weight : common.weights) weight = power / (1.0 - power), power *= ratio;

    std::vector<double> samples(size_t(std::min(columns, 4096)) * keep);
    std::vector<Summary> out(columns);
    double spent = 0.0;
    switch (order) {
    case 0: spent = run<All<true>>(common, columns, transient, keep, block, samples, out); break;
    case 1: spent = run<All<false>>(common, columns, transient, keep, block, samples, out); break;
    case 16: spent = run<One<16>>(common, columns, transient, keep, block, samples, out); break;
    case 18: spent = run<One<18>>(common, columns, transient, keep, block, samples, out); break;
    default: std::fprintf(stderr, "no such order\n"); return 2;
    }
    double steps = 0, impacts = 0, settled = 0, accumulations = 0, releases = 0, grazes = 0, left = 0;
    for (int i = 0; i < columns; ++i) {
        const Counts &c = out[i].counts;
        steps += c.steps, impacts += c.impacts, settled += c.settled, accumulations += c.accumulations;
        releases += c.releases, grazes += c.grazes, left += out[i].left != 0;
    }
    const double returns = double(columns) * (transient + keep);
    std::printf("{\"columns\": %d, \"block\": %d, \"order\": %d, \"returns_per_second\": %.6g, \"seconds\": %.4f, ", columns, block, order,
                returns / spent, spent);
    std::printf("\"steps_a_return\": %.3f, \"impacts_a_return\": %.3f, \"settled_a_return\": %.4f, ", steps / returns,
                impacts / returns, settled / returns);
    std::printf("\"accumulations_a_return\": %.4f, \"releases_a_return\": %.4f, \"grazes\": %.0f, \"left\": %.0f}\n",
                accumulations / returns, releases / returns, grazes, left);
    if (left > 0)
        for (int i = 0, told = 0; i < columns && told < 5; ++i)
            if (out[i].left) ++told, std::fprintf(stderr, "column %d left for reason %d at time %g\n", i, out[i].left, out[i].time);
    if (const char *name = std::getenv("CHATTER_SAMPLES")) {
        FILE *file = std::fopen(name, "wb");
        if (!file || std::fwrite(samples.data(), sizeof(double), samples.size(), file) != samples.size()) return 1;
        std::fclose(file);
    }
    return 0;
}
