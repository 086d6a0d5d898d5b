// Conversion of marks to messages and back: the session asks the io process to draw them.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "host/scene/marks.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::host {

/// Marks for ExportPictureT::marks, in the same order.
std::vector<std::unique_ptr<bus::schema::MarkT>> marks_message(std::span<const PictureMark> marks);

/// The mark of a verified message.
PictureMark mark_of(const bus::schema::Mark& wire);

}  // namespace pxpl5::host
