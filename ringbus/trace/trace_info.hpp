// What a trace file says about itself, as MCAP metadata.
#pragma once

#include "ringbus/trace/mcap.hpp"
#include "ringbus/trace/trace_file.hpp"

namespace pxpl5::bus::trace {

inline constexpr const char* metadata_name = "pxpl5";
inline constexpr const char* schema_name = "pxpl5.bus.schema.TraceEntry";
inline constexpr const char* encoding = "flatbuffer";

mcap::Metadata to_metadata(const Info& info);
/// Throws mcap::Damage naming the key that is missing or has a value that it cannot have.
Info to_info(const mcap::Metadata& metadata);

/// "gp-3", as files and logs are named; "host" and not "host-0".
std::string name_of(schema::Role role, std::uint16_t index);

}  // namespace pxpl5::bus::trace
