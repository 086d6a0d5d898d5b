// pxpl5 trace ls: what a recorded run holds.
#pragma once

#include <string>

namespace pxpl5::host::inspect {

struct LsOptions {
    std::string run{}, output{};
    bool json = false;
};

int trace_ls(const LsOptions& options);

}  // namespace pxpl5::host::inspect
