#include "host/scene/marks_messages.hpp"

namespace pxpl5::host {

namespace schema = bus::schema;

std::vector<std::unique_ptr<schema::MarkT>> marks_message(std::span<const PictureMark> marks) {
    std::vector<std::unique_ptr<schema::MarkT>> wire;
    wire.reserve(marks.size());
    for (const PictureMark& mark : marks) {
        auto one = std::make_unique<schema::MarkT>();
        one->kind = mark.kind;
        for (const glm::vec2& p : mark.points) {
            one->points.emplace_back(p.x, p.y);
        }
        const MarkColor& c = mark.color;
        one->color = std::make_unique<schema::Rgba>(c.r, c.g, c.b, c.a);
        one->width_px = mark.width_px;
        one->text = mark.text;
        one->height_px = mark.height_px;
        one->align_x = mark.align_x;
        one->align_y = mark.align_y;
        wire.push_back(std::move(one));
    }
    return wire;
}

PictureMark mark_of(const schema::Mark& wire) {
    const schema::Rgba& color = *wire.color();
    PictureMark mark{wire.kind(),
                     {},
                     {color.r(), color.g(), color.b(), color.a()},
                     wire.width_px(),
                     wire.text() == nullptr ? "" : wire.text()->str(),
                     wire.height_px(),
                     wire.align_x(),
                     wire.align_y()};
    for (const schema::PicturePoint* p : *wire.points()) {
        mark.points.emplace_back(p->x(), p->y());
    }
    return mark;
}

}  // namespace pxpl5::host
