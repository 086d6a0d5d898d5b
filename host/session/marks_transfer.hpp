// How marks cross the ring: into the message that asks the io process for a picture.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "host/scene/marks.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::host {

/// For ExportPictureT::marks, in the same order.
std::vector<std::unique_ptr<bus::schema::MarkT>> marks_message(std::span<const PictureMark> marks);

}  // namespace pxpl5::host
