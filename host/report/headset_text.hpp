// The modelled machine with a head-mounted display, as text and fields.
#pragma once

#include <string>
#include <vector>

#include "host/base/reply.hpp"
#include "host/timing/headset.hpp"

namespace pxpl5::host::report {

struct HeadsetLine {
    std::string name;  ///< "pelvis/skin".
    timing::HeadsetTime time;
};

/// The table, what its columns mean, and each number of the display with its provenance.
std::string text_of(const std::vector<HeadsetLine>& lines, const timing::Headset& headset);

/// The fields of one line, to be put behind those of its row.
void add_fields(const timing::HeadsetTime& time, Fields& fields);

/// Name, unit, value, provenance and source of each number.
std::vector<Fields> fields_of(const timing::Headset& headset);

}  // namespace pxpl5::host::report
