#include "host/io/values/component.hpp"

#include <map>

#include "host/io/values/header_text.hpp"

namespace pxpl5::host::io {

namespace {

using Names = std::map<std::string, Component>;

/// Spellings of NRRD, of VTK (with underscores) and of MetaImage. A long is 8 bytes in VTK files of
/// the machines that write them today, and 4 in MetaImage by its definition.
const Names& names() {
    using enum Component;
    static const Names all = {
        {"signed char", int8},
        {"int8", int8},
        {"int8_t", int8},
        {"char", int8},
        {"met_char", int8},
        {"uchar", uint8},
        {"unsigned char", uint8},
        {"uint8", uint8},
        {"uint8_t", uint8},
        {"unsigned_char", uint8},
        {"met_uchar", uint8},
        {"short", int16},
        {"short int", int16},
        {"signed short", int16},
        {"signed short int", int16},
        {"int16", int16},
        {"int16_t", int16},
        {"met_short", int16},
        {"ushort", uint16},
        {"unsigned short", uint16},
        {"unsigned short int", uint16},
        {"uint16", uint16},
        {"uint16_t", uint16},
        {"unsigned_short", uint16},
        {"met_ushort", uint16},
        {"int", int32},
        {"signed int", int32},
        {"int32", int32},
        {"int32_t", int32},
        {"met_int", int32},
        {"met_long", int32},
        {"uint", uint32},
        {"unsigned int", uint32},
        {"uint32", uint32},
        {"uint32_t", uint32},
        {"unsigned_int", uint32},
        {"met_uint", uint32},
        {"met_ulong", uint32},
        {"longlong", int64},
        {"long long", int64},
        {"long long int", int64},
        {"signed long long", int64},
        {"signed long long int", int64},
        {"int64", int64},
        {"int64_t", int64},
        {"long", int64},
        {"vtktypeint64", int64},
        {"met_long_long", int64},
        {"ulonglong", uint64},
        {"unsigned long long", uint64},
        {"unsigned long long int", uint64},
        {"uint64", uint64},
        {"uint64_t", uint64},
        {"unsigned_long", uint64},
        {"vtktypeuint64", uint64},
        {"met_ulong_long", uint64},
        {"float", float32},
        {"float32", float32},
        {"met_float", float32},
        {"double", float64},
        {"float64", float64},
        {"met_double", float64},
    };
    return all;
}

}  // namespace

std::optional<Component> component_named(const std::string& type) {
    const auto found = names().find(lower_case(type));
    return found == names().end() ? std::nullopt : std::optional(found->second);
}

}  // namespace pxpl5::host::io
