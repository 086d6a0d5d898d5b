#include "ringbus/trace/trace_info.hpp"

#include <fmt/core.h>

#include <charconv>

namespace pxpl5::bus::trace {

namespace {

/// Takes the value of `key` out of `left`.
std::string take(mcap::Metadata& left, const char* key) {
    const auto node = left.extract(key);
    if (!node) {
        throw mcap::Damage(fmt::format("'{}' is not said", key));
    }
    return node.mapped();
}

template <typename Number>
Number take_number(mcap::Metadata& left, const char* key, int base = 10) {
    const std::string text = take(left, key);
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
    if (error != std::errc{} || end != text.data() + text.size()) {
        throw mcap::Damage(fmt::format("'{}' is '{}', which is no number for it", key, text));
    }
    return value;
}

/// The value whose name the key has.
template <typename Enum, std::size_t count>
Enum take_named(mcap::Metadata& left, const char* key, const Enum (&values)[count],
                const char* (*name)(Enum)) {
    const std::string text = take(left, key);
    for (const Enum value : values) {
        if (text == name(value)) {
            return value;
        }
    }
    throw mcap::Damage(fmt::format("'{}' is '{}', which is none", key, text));
}

}  // namespace

std::string name_of(schema::Role role, std::uint16_t index) {
    if (role == schema::Role::host) {
        return "host";
    }
    if (role == schema::Role::frame_buffer) {
        return fmt::format("framebuffer-{}", index);
    }
    return fmt::format("{}-{}", schema::EnumNameRole(role), index);
}

std::string Info::node_name() const {
    return name_of(role, index);
}

mcap::Metadata to_metadata(const Info& info) {
    mcap::Metadata metadata = info.more;
    metadata["build"] = info.build;
    metadata["schema_hash"] = fmt::format("{:016x}", info.schema_hash);
    metadata["node"] = fmt::format("{}", info.node);
    metadata["role"] = schema::EnumNameRole(info.role);
    metadata["index"] = fmt::format("{}", info.index);
    metadata["recording"] = schema::EnumNameRecording(info.recording);
    metadata["dropped"] = fmt::format("{}", info.dropped);
    return metadata;
}

Info to_info(const mcap::Metadata& metadata) {
    Info info;
    info.more = metadata;
    info.build = take(info.more, "build");
    info.schema_hash = take_number<std::uint64_t>(info.more, "schema_hash", 16);
    info.node = take_number<NodeId>(info.more, "node");
    info.role = take_named(info.more, "role", schema::EnumValuesRole(), schema::EnumNameRole);
    info.index = take_number<std::uint16_t>(info.more, "index");
    info.recording = take_named(info.more, "recording", schema::EnumValuesRecording(),
                                schema::EnumNameRecording);
    info.dropped = take_number<std::uint64_t>(info.more, "dropped");
    return info;
}

}  // namespace pxpl5::bus::trace
