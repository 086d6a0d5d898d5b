#include "host/timing/paper_case.hpp"

#include <cassert>

namespace pxpl5::host::timing {

namespace {

constexpr double ns_per_ms = 1e6;

}  // namespace

double error_percent(double modelled, double stated) {
    assert(stated != 0);
    return 100 * (modelled - stated) / stated;
}

StepTime build_of(const Machine& machine, const PaperCase& paper_case) {
    return simulate(machine, {{paper_case.volume, paper_case.build}, {}}).steps.back();
}

double built_ms(const StepTime& build) {
    return static_cast<double>(build.end - build.begin) / ns_per_ms;
}

CaseTime time_of(const Machine& machine, const PaperCase& paper_case) {
    CaseTime time;
    time.build = build_of(machine, paper_case);
    time.built_ms = built_ms(time.build);
    time.rate = frame_rate(machine, paper_case.frame);
    const PaperResult& paper = paper_case.row.paper;
    time.built_error_percent = error_percent(time.built_ms, paper.built_ms);
    time.rate_error_percent = error_percent(time.rate.frames_per_s, paper.frames_per_s);
    return time;
}

}  // namespace pxpl5::host::timing
