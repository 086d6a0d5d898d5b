#include "tests/fuzz/recordings.hpp"

#include <optional>

#include "isa/table_hash.hpp"
#include "tests/host/inspect/recorded_sphere.hpp"

namespace pxpl5::fuzz {

namespace {

constexpr int picture_px = 128;  ///< One region, so that a question takes little time.

std::vector<host::inspect::NodeTrace> traces_of(int samples) {
    test::RecordedMachine recorded(test::machine_of(2, 2));
    test::set_up_sphere(recorded.session, {picture_px, picture_px});
    if (samples == 1) {
        recorded.session.frames.draw();
    } else {
        recorded.session.frames.draw_samples(samples);
    }
    return recorded.traces.traces();
}

/// The message after one edit of its body; nothing if the ring would refuse it.
std::optional<bus::Message> edited_message(const bus::Message& message, Bytes& bytes) {
    const auto body = message.bytes();
    const auto words = std::make_shared<std::vector<std::uint64_t>>(body.size() / 8 + 1);
    auto* copy = reinterpret_cast<std::uint8_t*>(words->data());
    std::ranges::copy(body, copy);
    overwrite(bytes, {copy, body.size()});
    try {
        return bus::Message(message.header(), {copy, body.size()}, words);
    } catch (const bus::BadMessage&) {
        return std::nullopt;
    }
}

}  // namespace

RecordedFiles::RecordedFiles(const std::filesystem::path& folder, int samples) : folder_(folder) {
    std::filesystem::create_directories(folder / "traces");
    for (const host::inspect::NodeTrace& trace : traces_of(samples)) {
        Node& node = nodes_.emplace_back();
        node.info = trace.info;
        node.info.recording = Recording::full;
        node.info.more["isa_hash"] = isa::table_hash();
        for (const bus::trace::Entry& entry : trace.entries) {
            node.messages.push_back(trace.load(entry));
        }
        messages_ += node.messages.size();
        write(nodes_.size() - 1, node.messages);
    }
}

void RecordedFiles::write(std::size_t node, const std::vector<bus::Message>& messages) const {
    const bus::trace::Info& info = nodes_[node].info;
    bus::trace::TraceWriter writer(folder_ / "traces" / (info.node_name() + ".mcap"), info);
    std::uint64_t wall_ns = 0;
    for (const bus::Message& message : messages) {
        writer.add(message, ++wall_ns);
    }
    writer.close();
}

void RecordedFiles::edit(Bytes& bytes) {
    constexpr int most_edits = 12;
    std::map<std::size_t, std::vector<bus::Message>> edited;
    for (int edit = 0; edit < most_edits && !bytes.empty(); ++edit) {
        std::size_t at = bytes.take<std::uint16_t>() % messages_, node = 0;
        for (; at >= nodes_[node].messages.size(); ++node) {
            at -= nodes_[node].messages.size();
        }
        auto& messages = edited.try_emplace(node, nodes_[node].messages).first->second;
        if (const auto other = edited_message(messages[at], bytes)) {
            messages[at] = *other;
        }
    }
    for (const std::size_t node : changed_) {
        if (!edited.contains(node)) {
            write(node, nodes_[node].messages);
        }
    }
    changed_.clear();
    for (const auto& [node, messages] : edited) {
        write(node, messages);
        changed_.insert(node);
    }
}

}  // namespace pxpl5::fuzz
