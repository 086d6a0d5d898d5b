// One valid message of every kind, each field with a value of its own.
#pragma once

#include <vector>

#include "ringbus/message.hpp"

namespace pxpl5::test {

bus::schema::Matrix identity();
bus::schema::DrawFrameT example_draw();
bus::schema::VolumeHeaderT example_header();
bus::schema::RegionProgramsT example_programs();

/// Ordered by kind.
std::vector<bus::Payload> one_of_each_kind();

/// The same message, unpacked and packed by the object API.
bus::Payload repacked(const bus::Message& message);

}  // namespace pxpl5::test
