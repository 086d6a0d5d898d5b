// The parts of the machine, one by one. Options are google-benchmark's: --benchmark_filter=march,
// --benchmark_format=json.
#include <benchmark/benchmark.h>

void register_renderer_benches();

int main(int argc, char** argv) {
    register_renderer_benches();
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) {
        return 64;
    }
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
