#include "host/session/marks_transfer.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;

schema::MarkKind kind_of(MarkKind kind) {
    switch (kind) {
        case MarkKind::line:
            return schema::MarkKind::line;
        case MarkKind::area:
            return schema::MarkKind::area;
        case MarkKind::text:
            break;
    }
    return schema::MarkKind::text;
}

}  // namespace

std::vector<std::unique_ptr<schema::MarkT>> marks_message(std::span<const PictureMark> marks) {
    std::vector<std::unique_ptr<schema::MarkT>> wire;
    wire.reserve(marks.size());
    for (const PictureMark& mark : marks) {
        auto one = std::make_unique<schema::MarkT>();
        one->kind = kind_of(mark.kind);
        for (const glm::vec2& p : mark.points) {
            one->points.emplace_back(p.x, p.y);
        }
        const MarkColour& c = mark.colour;
        one->colour = std::make_unique<schema::Rgba>(c.r, c.g, c.b, c.a);
        one->width_px = mark.width_px;
        one->text = mark.text;
        one->height_px = mark.height_px;
        one->align_x = mark.align_x;
        one->align_y = mark.align_y;
        wire.push_back(std::move(one));
    }
    return wire;
}

}  // namespace pxpl5::host
