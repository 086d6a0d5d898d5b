// The types of value that files hold, before they become one of our four.
#pragma once

#include <optional>
#include <string>

#include "ringbus/rules/slices_file.hpp"

namespace pxpl5::host::io {

/// "uint8", "int8", ...: the names that a raw file's description uses, too.
constexpr const char* component_name(Component component) {
    return enum_name(component);
}

/// The component that `type` means in a NRRD, MetaImage or VTK file; nothing if it is none.
std::optional<Component> component_named(const std::string& type);

}  // namespace pxpl5::host::io
