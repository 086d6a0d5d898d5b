#include "host/session/transfer/frame_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <memory>
#include <span>

#include "host/machine/port.hpp"
#include "ringbus/rules/regions.hpp"
#include "ringbus/rules/views.hpp"
#include "ringbus/trace/trace_info.hpp"

namespace pxpl5::host {

namespace schema = bus::schema;

FrameParts::FrameParts(Size view, std::size_t views, std::size_t frame_buffers)
    : view_(view), views_(views), parts_(std::min(views, frame_buffers)) {}

void FrameParts::take(std::size_t index, const bus::Message& message) {
    const auto& done = *message.as<schema::FrameDone>();
    const std::size_t due = index < parts_.size() ? views_of(views_, index, parts_.size()) : 0;
    if (done.views() != due || static_cast<int>(done.width()) != view_.width ||
        static_cast<int>(done.height()) != view_.height) {
        const std::string sender =
            bus::trace::name_of(schema::Role::frame_buffer, static_cast<std::uint16_t>(index));
        MachineError error(ExitCode::unavailable,
                           fmt::format("{} sent frame {} with {} views of {} x {} pixels, must "
                                       "have {} of {} x {}. Build all nodes again",
                                       sender, done.frame(), done.views(), done.width(),
                                       done.height(), due, view_.width, view_.height));
        error.node = sender;
        throw error;
    }
    parts_[index] = message;
}

bool FrameParts::is_complete() const {
    return std::ranges::all_of(parts_, [](const auto& part) { return part.has_value(); });
}

const schema::FrameDone& FrameParts::part(std::size_t index) const {
    return *parts_[index]->as<schema::FrameDone>();
}

/// The words of all views.
SharedWords FrameParts::joined(const Words* (schema::FrameDone::*words)() const) const {
    const auto of = [&](std::size_t index) {
        const Words* found = (part(index).*words)();
        return found == nullptr ? std::span<const std::uint32_t>()
                                : std::span<const std::uint32_t>(found->data(), found->size());
    };
    if (parts_.size() == 1) {
        return of(0).empty() ? SharedWords()
                             : SharedWords(of(0), std::make_shared<const bus::Message>(*parts_[0]));
    }
    std::vector<std::uint32_t> into;
    for (std::size_t view = 0; view < views_; ++view) {
        const std::size_t buffer = frame_buffer_of(view, parts_.size());
        const std::span<const std::uint32_t> stack = of(buffer);
        const std::size_t pixels = stack.size() / views_of(views_, buffer, parts_.size());
        const auto own = stack.subspan(view_place(view, parts_.size()) * pixels, pixels);
        into.insert(into.end(), own.begin(), own.end());
    }
    return into;
}

WholeFrame FrameParts::whole() const {
    assert(is_complete());
    WholeFrame whole;
    whole.frame = part(0).frame();
    whole.view = view_;
    whole.views = static_cast<int>(views_);
    whole.pixels = joined(&schema::FrameDone::pixels);
    whole.depths = joined(&schema::FrameDone::depths);
    const std::size_t per_view = region_count(part(0).width(), part(0).height(), 1);
    for (std::size_t view = 0; view < views_; ++view) {
        const schema::FrameDone& done = part(frame_buffer_of(view, parts_.size()));
        const std::size_t first = view_place(view, parts_.size()) * per_view;
        for (std::size_t region = first; region < first + per_view; ++region) {
            const auto at = static_cast<flatbuffers::uoffset_t>(region);
            whole.region_cycles.push_back(done.region_cycles()->Get(at));
            whole.region_renderers.push_back(done.region_renderers()->Get(at));
        }
    }
    for (std::size_t index = 0; index < parts_.size(); ++index) {
        whole.instructions += part(index).instructions();
        whole.moved_mm = std::max(whole.moved_mm, part(index).moved_mm());
    }
    return whole;
}

}  // namespace pxpl5::host
