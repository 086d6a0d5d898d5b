// The description of a trace as MCAP metadata.
#pragma once

#include "ringbus/trace/mcap.hpp"
#include "ringbus/trace/trace_file.hpp"

namespace pxpl5::bus::trace {

inline constexpr const char* metadata_name = "pxpl5";
inline constexpr const char* schema_name = "pxpl5.bus.schema.TraceEntry";
inline constexpr const char* encoding = "flatbuffer";

mcap::Metadata to_metadata(const Info& info);
/// Throws mcap::Damage, which names the key that is missing or has an invalid value.
Info to_info(const mcap::Metadata& metadata);

/// The node's name in files and logs, for example "gp-3". The host's name is "host".
std::string name_of(schema::Role role, std::uint16_t index);

}  // namespace pxpl5::bus::trace
