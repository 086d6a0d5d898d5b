// Writes the present scene as a script.
#pragma once

#include <string>

#include "host/session/session.hpp"

namespace pxpl5::host {

/// A script that loads the volume, checks that it is the same one, and makes the scene. Unlike
/// History::script() it neither repeats the way to the scene nor writes files.
std::string scene_script(const Session& session);

}  // namespace pxpl5::host
