#include "host/inspect/record/selected_messages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <tuple>

#include "host/base/answer.hpp"
#include "host/inspect/record/message_text.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace schema = bus::schema;

constexpr double ns_per_ms = 1e6;

/// True if the node is "gp-3" for role "gp-" and a range that holds 3.
bool is_one_of(const std::string& node, std::string_view role, const std::vector<Range>& indices) {
    if (!node.starts_with(role)) {
        return false;
    }
    std::uint32_t index = 0;
    std::from_chars(node.data() + role.size(), node.data() + node.size(), index);
    return std::ranges::any_of(indices, [&](const Range& r) { return r.contains(index); });
}

/// True if no node of the role is asked for, or the message comes from one or goes to one.
bool involves(const RecordedRun& run, const schema::Header& header, std::string_view role,
              const std::vector<Range>& indices) {
    return indices.empty() || is_one_of(run.node_name(header.source()), role, indices) ||
           is_one_of(run.node_name(header.destination()), role, indices);
}

bool is_selected(const RecordedRun& run, const Selection& selection, const NodeTrace& node,
                 const bus::trace::Entry& entry) {
    if (!selection.has_kind(bus::kind_name(entry.kind()))) {
        return false;
    }
    if (!involves(run, entry.header, "gp-", selection.gps) ||
        !involves(run, entry.header, "renderer-", selection.renderers)) {
        return false;
    }
    return selection.frames.empty() ||
           (bus::is_of_frame(entry.kind()) && selection.has_frame(*frame_of(node.load(entry))));
}

auto order_of(const MessageRef& message) {
    const schema::Header& header = message.header();
    return std::tuple(header.clock(), header.source(), header.sequence(), header.destination());
}

}  // namespace

std::vector<MessageRef> select_messages(const RecordedRun& run, const Selection& selection) {
    std::vector<MessageRef> messages;
    for (const auto& [id, node] : run.nodes()) {
        for (std::size_t i = 0; i < node.entries.size(); ++i) {
            if (is_selected(run, selection, node, node.entries[i])) {
                messages.push_back({&node, i});
            }
        }
    }
    std::ranges::sort(messages, {}, order_of);
    return messages;
}

std::uint64_t start_of(const RecordedRun& run) {
    std::uint64_t start = std::numeric_limits<std::uint64_t>::max();
    for (const auto& [id, node] : run.nodes()) {
        for (const bus::trace::Entry& entry : node.entries) {
            start = std::min(start, entry.wall_ns);
        }
    }
    return start == std::numeric_limits<std::uint64_t>::max() ? 0 : start;
}

std::string message_heading() {
    return fmt::format("{:>8} {:>10}  {:<14}    {:<14} {:<15} {:>12}  {}", "clock", "ms", "source",
                       "destination", "kind", "bytes", "what");
}

std::string message_line(const RecordedRun& run, const MessageRef& message,
                         std::uint64_t start_ns) {
    const schema::Header& header = message.header();
    const double ms =
        static_cast<double>(static_cast<std::int64_t>(message.at().wall_ns - start_ns)) / ns_per_ms;
    std::string line =
        fmt::format("{:>8} {:>10.3f}  {:<14} -> {:<14} {:<15} {:>12}  {}", header.clock(), ms,
                    run.node_name(header.source()), run.node_name(header.destination()),
                    bus::kind_name(message.at().kind()), grouped(header.body_bytes()),
                    describe(message.load()));
    line.erase(line.find_last_not_of(' ') + 1);
    return line;
}

}  // namespace pxpl5::host::inspect
