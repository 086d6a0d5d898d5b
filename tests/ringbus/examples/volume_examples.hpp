// Messages of volumes, pictures and files, for one_of_each_kind().
#pragma once

#include <vector>

#include "ringbus/message.hpp"

namespace pxpl5::test {

/// In no particular order; each field has a value of its own.
std::vector<bus::Payload> volume_examples();

}  // namespace pxpl5::test
