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

[[noreturn]] void refuse_name(const char* key, const std::string& text) {
    throw mcap::Damage(fmt::format("'{}' is '{}', which is none", key, text));
}

schema::Role take_role(mcap::Metadata& left) {
    const std::string text = take(left, "role");
    for (const schema::Role role : schema::EnumValuesRole()) {
        if (text == schema::EnumNameRole(role)) {
            return role;
        }
    }
    refuse_name("role", text);
}

Recording take_recording(mcap::Metadata& left) {
    const std::string text = take(left, "recording");
    const std::optional<Recording> recording = enum_named<Recording>(text);
    return recording ? *recording : (refuse_name("recording", text), Recording::off);
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
    metadata["recording"] = enum_name(info.recording);
    metadata["dropped"] = fmt::format("{}", info.dropped);
    return metadata;
}

Info to_info(const mcap::Metadata& metadata) {
    Info info;
    info.more = metadata;
    info.build = take(info.more, "build");
    info.schema_hash = take_number<std::uint64_t>(info.more, "schema_hash", 16);
    info.node = take_number<NodeId>(info.more, "node");
    info.role = take_role(info.more);
    info.index = take_number<std::uint16_t>(info.more, "index");
    info.recording = take_recording(info.more);
    info.dropped = take_number<std::uint64_t>(info.more, "dropped");
    return info;
}

}  // namespace pxpl5::bus::trace
