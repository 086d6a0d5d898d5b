// Writes the fitted values beside those of the file.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "host/base/reply.hpp"
#include "host/timing/fit.hpp"

namespace pxpl5::host::report {

/// names  Of the cases, in their order.
std::string text_of(const timing::Fit& fit, std::span<const timing::PaperCase> cases,
                    std::span<const std::string> names);
Fields fields_of(const timing::Fit& fit);

}  // namespace pxpl5::host::report
